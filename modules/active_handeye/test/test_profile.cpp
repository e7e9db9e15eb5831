// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "measure_scene.hpp"

namespace opencv_test { namespace {

const Matx33d K(1400, 0, 320, 0, 1405, 240, 0, 0, 1);
const Matx<double, 5, 1> dist(-0.12, 0.08, 1e-3, -8e-4, 0);

//! Pixel of the recorded image of a point of the camera frame.
Vec2d project(const Vec3d& X)
{
    const double x = X[0] / X[2], y = X[1] / X[2], r2 = x * x + y * y;
    const double radial = 1 + r2 * (dist(0) + r2 * (dist(1) + r2 * dist(4)));
    const double u = x * radial + 2 * dist(2) * x * y + dist(3) * (r2 + 2 * x * x);
    const double v = y * radial + dist(2) * (r2 + 2 * y * y) + 2 * dist(3) * x * y;
    return Vec2d(K(0, 0) * u + K(0, 2), K(1, 1) * v + K(1, 2));
}

//! A profile in the light plane n.X = d: points a (across the image) and b (away from the camera) of it.
struct Profile
{
    Vec3d n = normalize(Vec3d(0.02, 0.93, 0.37)), a, b;
    double d = 0.2;

    Profile()
    {
        a = normalize(Vec3d(1, 0, 0) - n * n[0]);
        b = a.cross(n);
        if (b[2] < 0)
            b = -b;
    }

    Vec3d at(double s, double h) const { return n * d + s * a + h * b; }
    Vec4d plane() const { return Vec4d(n[0], n[1], n[2], d); }
};

//! Straight pieces from corner to corner of a polyline (s, h), one point for each column of the image.
struct Stripe
{
    Mat points, sigmas, ids;
    Stripe(const Profile& profile, const std::vector<Vec2d>& corners, double sigma, int trimmed = 2)
    {
        for (size_t piece = 0; piece + 1 < corners.size(); ++piece)
        {
            const auto pixel = [&](double t)
            {
                const Vec2d c = corners[piece] * (1 - t) + corners[piece + 1] * t;
                return project(profile.at(c[0], c[1]));
            };
            const double first = std::ceil(pixel(0)[0]) + trimmed, last = std::floor(pixel(1)[0]) - trimmed;
            for (double u = first; u <= last; ++u)
            {
                double low = 0, high = 1;
                for (int i = 0; i < 60; ++i)
                    (pixel(0.5 * (low + high))[0] < u ? low : high) = 0.5 * (low + high);
                points.push_back(Mat(Matx12d(u, pixel(low)[1])));
                ids.push_back(int(piece));
            }
        }
        sigmas = Mat(points.rows, 1, CV_64F, Scalar(sigma));
    }

    //! With errors across the stripe; `correlation` of neighbours.
    Mat noisy(RNG& rng, double correlation = 0) const
    {
        Mat result = points.clone();
        double error = rng.gaussian(1);
        for (int i = 0; i < result.rows; ++i)
        {
            result.at<double>(i, 1) += error * sigmas.at<double>(i);
            error = correlation * error + std::sqrt(1 - correlation * correlation) * rng.gaussian(1);
        }
        return result;
    }
};

const std::vector<Vec2d> flat = {Vec2d(-0.09, 0.30), Vec2d(0.09, 0.33)};

//! A V-groove of 60 degrees between two plates: root at (0.005, 0.312).
const std::vector<Vec2d> groove = {Vec2d(-0.08, 0.300), Vec2d(0.005 - 0.012 * std::tan(CV_PI / 6), 0.300),
                                   Vec2d(0.005, 0.312), Vec2d(0.005 + 0.012 * std::tan(CV_PI / 6), 0.300),
                                   Vec2d(0.08, 0.300)};

Vec2d pixelOf(const Mat& points, int i)
{
    return Vec2d(points.ptr<double>(i));
}

Matx22d covarianceOf(const Mat& covariances, int i)
{
    return Matx22d(covariances.ptr<double>(i));
}

//! The exact stripe at column u.
double rowAt(const Profile& profile, const std::vector<Vec2d>& corners, double u)
{
    double low = 0, high = 1;
    const auto pixel = [&](double t)
    {
        const Vec2d c = corners[0] * (1 - t) + corners[1] * t;
        return project(profile.at(c[0], c[1]));
    };
    for (int i = 0; i < 60; ++i)
        (pixel(0.5 * (low + high))[0] < u ? low : high) = 0.5 * (low + high);
    return pixel(low)[1];
}

TEST(ActiveHandEye_Profile, locateOnStripe_is_exact_for_a_straight_piece_behind_a_lens)
{
    const Profile profile;
    const Stripe stripe(profile, flat, 0.1);
    const Matx<double, 3, 2> wanted(150.3, 500, 320, 500, 520.75, 500);
    Mat points, covariances;
    locateOnStripe(stripe.points, stripe.sigmas, stripe.ids, wanted, K, dist, points, covariances, 0, STRIPE_HORIZONTAL,
                   15, 30);
    for (int i = 0; i < 3; ++i)
    {
        EXPECT_NEAR(wanted(i, 0), pixelOf(points, i)[0], 1e-8);
        EXPECT_NEAR(rowAt(profile, flat, wanted(i, 0)), pixelOf(points, i)[1], 1e-7);
        EXPECT_NEAR(0, covarianceOf(covariances, i)(0, 0), 1e-18);
    }
}

TEST(ActiveHandEye_Profile, locateOnStripe_takes_rows_for_a_vertical_stripe)
{
    const Profile profile;
    const Stripe stripe(profile, flat, 0.1);
    Mat swapped(stripe.points.rows, 2, CV_64F);
    stripe.points.col(0).copyTo(swapped.col(1));
    stripe.points.col(1).copyTo(swapped.col(0));
    const Matx33d turned(K(1, 1), 0, K(1, 2), 0, K(0, 0), K(0, 2), 0, 0, 1);
    const Matx<double, 5, 1> lens(dist(0), dist(1), dist(3), dist(2), dist(4)); // p1 and p2 change places with x and y
    Mat points, covariances, straight, straightCovariances;
    locateOnStripe(swapped, stripe.sigmas, stripe.ids, Matx12d(500, 320), turned, lens, points, covariances, 0,
                   STRIPE_VERTICAL, 15, 30);
    locateOnStripe(stripe.points, stripe.sigmas, stripe.ids, Matx12d(320, 500), K, dist, straight, straightCovariances,
                   0, STRIPE_HORIZONTAL, 15, 30);
    EXPECT_NEAR(pixelOf(straight, 0)[1], pixelOf(points, 0)[0], 1e-9);
    EXPECT_NEAR(pixelOf(straight, 0)[0], pixelOf(points, 0)[1], 1e-9);
    EXPECT_NEAR(covarianceOf(straightCovariances, 0)(1, 1), covarianceOf(covariances, 0)(0, 0), 1e-12);
}

//! RMS of error / stated sigma across the stripe.
double standardizedError(double correlation, uint64 seed)
{
    const Profile profile;
    const Stripe stripe(profile, flat, 0.4);
    RNG rng(seed);
    const int trials = 600;
    double sum = 0;
    for (int trial = 0; trial < trials; ++trial)
    {
        const double u = rng.uniform(140., 500.);
        Mat points, covariances;
        locateOnStripe(stripe.noisy(rng, correlation), stripe.sigmas, stripe.ids, Matx12d(u, 500), K, dist, points,
                       covariances, 0, STRIPE_HORIZONTAL, 15, 30);
        const double error = pixelOf(points, 0)[1] - rowAt(profile, flat, u);
        sum += error * error / covarianceOf(covariances, 0)(1, 1);
    }
    return std::sqrt(sum / trials);
}

TEST(ActiveHandEye_Profile, locateOnStripe_states_its_error_for_independent_columns)
{
    const double ratio = standardizedError(0, 3);
    EXPECT_GT(ratio, 0.80); // scatter and correlation only ever raise the variance
    EXPECT_LT(ratio, 1.05);
}

TEST(ActiveHandEye_Profile, locateOnStripe_states_its_error_for_columns_that_err_alike)
{
    const double ratio = standardizedError(0.6, 4);
    EXPECT_GT(ratio, 0.80);
    EXPECT_LT(ratio, 1.15); // 1.9 if the columns counted as independent
}

TEST(ActiveHandEye_Profile, locateOnStripe_moves_along_the_line_by_sigmaAlong)
{
    const Profile profile;
    const Stripe stripe(profile, flat, 0.1);
    Mat points, exact, slid;
    const Matx12d wanted(320, 500);
    locateOnStripe(stripe.points, stripe.sigmas, stripe.ids, wanted, K, dist, points, exact, 0, STRIPE_HORIZONTAL, 15,
                   30);
    locateOnStripe(stripe.points, stripe.sigmas, stripe.ids, wanted, K, dist, points, slid, 0.5, STRIPE_HORIZONTAL, 15,
                   30);
    const double slope = (rowAt(profile, flat, 321) - rowAt(profile, flat, 319)) / 2;
    const Matx22d part = covarianceOf(slid, 0) - covarianceOf(exact, 0);
    EXPECT_NEAR(0.25, part(0, 0), 1e-9);
    EXPECT_NEAR(0.25 * slope, part(0, 1), 1e-6);
    EXPECT_NEAR(0.25 * slope * slope, part(1, 1), 1e-6);
}

TEST(ActiveHandEye_Profile, locateOnStripe_gives_NaN_where_no_straight_piece_is_near)
{
    const Profile profile;
    const Stripe stripe(profile, flat, 0.1);
    const double v = rowAt(profile, flat, 320);
    const Matx<double, 3, 2> wanted(320, v + 11, 5, v, 320, v + 9);
    Mat points, covariances;
    locateOnStripe(stripe.points, stripe.sigmas, stripe.ids, wanted, K, dist, points, covariances);
    EXPECT_TRUE(std::isnan(pixelOf(points, 0)[0]) && std::isnan(covarianceOf(covariances, 0)(1, 1)));
    EXPECT_TRUE(std::isnan(pixelOf(points, 1)[1]));
    EXPECT_NEAR(v, pixelOf(points, 2)[1], 1e-6);
    const Mat none(stripe.points.rows, 1, CV_32S, Scalar(-1));
    locateOnStripe(stripe.points, stripe.sigmas, none, wanted, K, dist, points, covariances);
    EXPECT_TRUE(std::isnan(pixelOf(points, 2)[1]));
    locateOnStripe(Mat(0, 2, CV_64F), Mat(0, 1, CV_64F), Mat(0, 1, CV_32S), wanted, K, dist, points, covariances);
    EXPECT_TRUE(std::isnan(pixelOf(points, 2)[1]));
}

TEST(ActiveHandEye_Profile, findProfileCorners_is_exact_for_a_groove_behind_a_lens)
{
    const Profile profile;
    const Stripe stripe(profile, groove, 0.1);
    Mat corners, covariances, angles, segments;
    findProfileCorners(stripe.points, stripe.sigmas, stripe.ids, K, dist, profile.plane(), corners, covariances, angles,
                       segments);
    ASSERT_EQ(3, corners.rows);
    const double truth[] = {240, 60, 240}; // a plate's edge, the root, the other plate's edge
    for (int i = 0; i < 3; ++i)
    {
        const Vec2d exact = project(profile.at(groove[size_t(i) + 1][0], groove[size_t(i) + 1][1]));
        EXPECT_LT(cv::norm(exact - pixelOf(corners, i)), 1e-6) << i;
        EXPECT_NEAR(truth[i], angles.at<double>(i), 1e-5) << i;
        EXPECT_EQ(i, segments.at<int>(i, 0));
        EXPECT_EQ(i + 1, segments.at<int>(i, 1));
    }
}

TEST(ActiveHandEye_Profile, findProfileCorners_states_the_error_of_the_root)
{
    const Profile profile;
    const Stripe stripe(profile, groove, 0.4);
    const Vec2d exact = project(profile.at(groove[2][0], groove[2][1]));
    RNG rng(5);
    const int trials = 600;
    double sum = 0;
    for (int trial = 0; trial < trials; ++trial)
    {
        Mat corners, covariances, angles, segments;
        findProfileCorners(stripe.noisy(rng), stripe.sigmas, stripe.ids, K, dist, profile.plane(), corners, covariances,
                           angles, segments);
        ASSERT_EQ(3, corners.rows);
        const Vec2d error = pixelOf(corners, 1) - exact;
        sum += error.dot(covarianceOf(covariances, 1).inv() * error);
    }
    EXPECT_GT(sum / trials, 2 * 0.7); // chi-square with 2 degrees of freedom; floor and scatter only ever raise it
    EXPECT_LT(sum / trials, 2 * 1.1);
}

TEST(ActiveHandEye_Profile, findProfileCorners_does_not_join_pieces_that_do_not_meet)
{
    const Profile profile;
    const std::vector<Vec2d> steps = {Vec2d(-0.08, 0.30), Vec2d(-0.001, 0.30)},
                             behind = {Vec2d(0.001, 0.33), Vec2d(0.08, 0.32)};
    const Stripe left(profile, steps, 0.1), right(profile, behind, 0.1);
    Mat points, sigmas, ids;
    vconcat(left.points, right.points, points);
    vconcat(left.sigmas, right.sigmas, sigmas);
    vconcat(left.ids, right.ids + 1, ids);
    Mat corners, covariances, angles, segments;
    findProfileCorners(points, sigmas, ids, K, dist, profile.plane(), corners, covariances, angles, segments);
    EXPECT_EQ(0, corners.rows);
    EXPECT_EQ(0, angles.rows);
}

TEST(ActiveHandEye_Profile, wrong_input_is_named)
{
    const Profile profile;
    const Stripe stripe(profile, flat, 0.1);
    const Matx12d wanted(320, 500);
    Mat out, covariances, angles, segments;
    const auto locate =
        [&](const Mat& points, const Mat& sigmas, const Mat& ids, double sigmaAlong, int orientation, double window)
    { locateOnStripe(points, sigmas, ids, wanted, K, dist, out, covariances, sigmaAlong, orientation, window); };
    const Mat &p = stripe.points, &s = stripe.sigmas, &i = stripe.ids;
    expectError([&] { locate(p, s.rowRange(0, 3), i, 0, 0, 15); }, Error::StsBadSize,
                {"sigmas: needed one number for each"});
    expectError([&] { locate(p, s, i.rowRange(0, 3), 0, 0, 15); }, Error::StsBadSize,
                {"segmentIds: needed one number"});
    expectError([&] { locate(p, 0 * s, i, 0, 0, 15); }, Error::StsOutOfRange, {"sigmas: needed"});
    expectError([&] { locate(p, s, i - 5, 0, 0, 15); }, Error::StsOutOfRange, {"segmentIds: needed numbers from -1"});
    expectError([&] { locate(p, s, i, -1, 0, 15); }, Error::StsOutOfRange,
                {"sigmaAlong: needed 0 or a positive number"});
    expectError([&] { locate(p, s, i, 0, 2, 15); }, Error::StsBadArg, {"orientation: needed STRIPE_HORIZONTAL"});
    expectError([&] { locate(p, s, i, 0, 0, 1); }, Error::StsOutOfRange, {"halfWindow: needed 4 to 1000"});
    expectError([&] { findProfileCorners(p, s, i, K, dist, Vec4d(0, 0, 1, -1), out, covariances, angles, segments); },
                Error::StsBadArg, {"lightPlane"});
}

}} // namespace opencv_test
