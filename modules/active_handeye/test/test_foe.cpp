// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "point_scene.hpp"

namespace opencv_test { namespace {

struct Pair
{
    Mat x1, x2;
    Vec3d foe; //!< K c, unit
};

//! Points before and after the camera moved by c (camera frame).
Pair translate(const Vec3d& c, int points, double noise, uint64 seed, double depthSpread = 100)
{
    RNG rng(seed);
    const Matx33d K(1413, 0, 316, 0, 1420, 243, 0, 0, 1);
    Pair pair;
    pair.x1.create(points, 2, CV_64F);
    pair.x2.create(points, 2, CV_64F);
    for (int j = 0; j < points; ++j)
    {
        const double z = 550 + rng.uniform(-depthSpread, depthSpread);
        const Vec3d X(rng.uniform(-0.2, 0.2) * z, rng.uniform(-0.15, 0.15) * z, z);
        const Vec3d images[2] = {K * X, K * (X - c)};
        for (int axis = 0; axis < 2; ++axis)
        {
            pair.x1.at<double>(j, axis) = images[0][axis] / images[0][2] + (noise > 0 ? rng.gaussian(noise) : 0);
            pair.x2.at<double>(j, axis) = images[1][axis] / images[1][2] + (noise > 0 ? rng.gaussian(noise) : 0);
        }
    }
    pair.foe = K * c;
    pair.foe *= 1 / cv::norm(pair.foe);
    return pair;
}

vector<Vec3d> motions()
{
    return vector<Vec3d>{Vec3d(0, 0, 60),  Vec3d(0, 0, -60),  Vec3d(50, 0, 0),
                         Vec3d(0, -50, 0), Vec3d(30, 20, 40), Vec3d(-30, 40, -2)};
}

TEST(ActiveHandEye_EstimateFOE, exact_data_give_the_signed_direction)
{
    for (const Vec3d& c : motions())
        for (int method : {FOE_LEAST_SQUARES, FOE_RANSAC})
        {
            SCOPED_TRACE(cv::format("c = (%g, %g, %g), method %d", c[0], c[1], c[2], method));
            const Pair pair = translate(c, 40, 0, 3);
            Vec3d foe;
            Mat mask, covariance;
            EXPECT_EQ(40, estimateFOE(pair.x1, pair.x2, foe, mask, covariance, FOEMethod(method)));
            EXPECT_LE(cv::norm(foe - pair.foe), 1e-9);
            EXPECT_EQ(40, cv::countNonZero(mask));
            EXPECT_LE(cv::norm(covariance), 1e-15);
        }
}

TEST(ActiveHandEye_EstimateFOE, two_matches_suffice)
{
    const Pair pair = translate(Vec3d(30, 20, 40), 2, 0, 5);
    Vec3d foe;
    EXPECT_EQ(2, estimateFOE(pair.x1, pair.x2, foe));
    EXPECT_LE(cv::norm(foe - pair.foe), 1e-9);
}

TEST(ActiveHandEye_EstimateFOE, swapped_views_turn_the_sign)
{
    const Pair pair = translate(Vec3d(30, 20, 40), 20, 0.1, 5);
    Vec3d forth, back;
    estimateFOE(pair.x1, pair.x2, forth);
    estimateFOE(pair.x2, pair.x1, back);
    EXPECT_LE(cv::norm(forth + back), 1e-9);
}

TEST(ActiveHandEye_EstimateFOE, thirty_percent_wrong_matches_are_masked)
{
    for (const Vec3d& c : motions())
    {
        Pair pair = translate(c, 100, 0.2, 7);
        RNG rng(11);
        for (int j = 0; j < 30; ++j)
            pair.x2.at<double>(j, 0) = rng.uniform(0., 640.), pair.x2.at<double>(j, 1) = rng.uniform(0., 480.);
        Vec3d foe, clean;
        Mat mask;
        estimateFOE(pair.x1, pair.x2, foe, mask);
        Matx33d covariance;
        estimateFOE(pair.x1.rowRange(30, 100), pair.x2.rowRange(30, 100), clean, noArray(), covariance,
                    FOE_LEAST_SQUARES);
        EXPECT_LE(cv::norm(foe - clean),
                  2 * std::sqrt(cv::trace(covariance))); // a few wrong matches lie near their line by chance
        EXPECT_LE(cv::countNonZero(mask.rowRange(0, 30)), 4);
        EXPECT_GE(cv::countNonZero(mask.rowRange(30, 100)), 68);
    }
}

TEST(ActiveHandEye_EstimateFOE, wrong_matches_within_the_threshold_are_masked)
{
    for (const Vec3d& c : motions())
    {
        Pair pair = translate(c, 100, 0.02, 7);
        int wrong = 0;
        for (int j = 0; j < 30; ++j) // across the line of the displacement, which the threshold of 1 px allows
        {
            const Mat moved = pair.x2.row(j) - pair.x1.row(j);
            const Vec2d along(moved.at<double>(0), moved.at<double>(1)),
                off = (j % 2 ? 0.7 : -0.7) * along / cv::norm(along);
            if (cv::norm(along) < 10)
                continue;
            pair.x2.at<double>(j, 0) -= off[1];
            pair.x2.at<double>(j, 1) += off[0];
            ++wrong;
        }
        ASSERT_GE(wrong, 20);
        Vec3d foe;
        Mat mask;
        Matx33d covariance;
        EXPECT_LE(estimateFOE(pair.x1, pair.x2, foe, mask, covariance), 100 - wrong + 1) << c;
        EXPECT_GE(cv::countNonZero(mask.rowRange(30, 100)), 69) << c;
        EXPECT_LE(cv::norm(foe - pair.foe), 3 * std::sqrt(cv::trace(covariance))) << c;
    }
}

//! Normalised error squared on the tangent plane: chi-square with two degrees of freedom, mean 2.
TEST(ActiveHandEye_EstimateFOE, covariance_predicts_the_error)
{
    for (const Vec3d& c : motions())
    {
        double sum = 0;
        const int trials = 300;
        for (int trial = 0; trial < trials; ++trial)
        {
            const Pair pair = translate(c, 60, 0.3, 100 + trial);
            Vec3d foe;
            Matx33d covariance;
            estimateFOE(pair.x1, pair.x2, foe, noArray(), covariance, FOE_LEAST_SQUARES);
            EXPECT_LE(cv::norm(covariance * foe), 1e-9 * cv::norm(covariance));
            const Vec3d error = foe - pair.foe;
            Mat inverse;
            cv::invert(covariance + foe * foe.t() * cv::trace(covariance), inverse, DECOMP_SVD);
            sum += error.dot(Vec3d(Mat(inverse * Mat(error, false).reshape(1, 3))));
        }
        EXPECT_NEAR(2, sum / trials, 0.45) << c; // 0.45 is 4 standard deviations of the mean
    }
}

TEST(ActiveHandEye_EstimateFOE, all_layouts_give_the_same)
{
    const Pair pair = translate(Vec3d(30, 20, 40), 20, 0.1, 5);
    vector<Point2d> list1, list2;
    for (int j = 0; j < 20; ++j)
    {
        list1.push_back(Point2d(pair.x1.at<double>(j, 0), pair.x1.at<double>(j, 1)));
        list2.push_back(Point2d(pair.x2.at<double>(j, 0), pair.x2.at<double>(j, 1)));
    }
    Mat wide(20, 5, CV_64F, Scalar(7));
    pair.x2.copyTo(wide.colRange(2, 4));
    Vec3d reference, foe;
    estimateFOE(pair.x1, pair.x2, reference);
    estimateFOE(list1, list2, foe);
    EXPECT_EQ(reference, foe);
    estimateFOE(pair.x1.reshape(2, 20), wide.colRange(2, 4), foe);
    EXPECT_EQ(reference, foe);
    Mat float1, float2;
    pair.x1.convertTo(float1, CV_32F);
    pair.x2.convertTo(float2, CV_32F);
    estimateFOE(float1, float2, foe);
    EXPECT_LE(cv::norm(foe - reference), 1e-5);
}

TEST(ActiveHandEye_EstimateFOE, input_that_cannot_answer_is_refused)
{
    const Pair pair = translate(Vec3d(30, 20, 40), 20, 0.1, 5);
    Vec3d foe;
    const auto estimate = [&foe](const Mat& x1, const Mat& x2)
    { return [&foe, x1, x2]() { estimateFOE(x1, x2, foe); }; };
    expectError(estimate(pair.x1.rowRange(0, 1), pair.x2.rowRange(0, 1)), Error::StsNoConv,
                {"needed at least 2 matches, given 1"});
    expectError(estimate(pair.x1, pair.x1), Error::StsNoConv, {"no parallax", "median displacement of 0 px"});
    Mat jitter = pair.x1.clone();
    RNG rng(3);
    for (int j = 0; j < 20; ++j)
        jitter.at<double>(j, 0) += rng.gaussian(0.1), jitter.at<double>(j, 1) += rng.gaussian(0.1);
    expectError(estimate(pair.x1, jitter), Error::StsNoConv, {"points1, points2: no parallax", "px at a residual of"});
    const Mat line1 = (Mat_<double>(3, 2) << 10., 10., 20., 20., 40., 40.),
              line2 = (Mat_<double>(3, 2) << 12., 12., 23., 23., 44., 44.);
    expectError(estimate(line1, line2), Error::StsNoConv, {"on one line"});
    RNG random(9);
    Mat noise1(100, 2, CV_64F), noise2(100, 2, CV_64F);
    random.fill(noise1, RNG::UNIFORM, 0, 480);
    random.fill(noise2, RNG::UNIFORM, 0, 480);
    expectError(estimate(noise1, noise2), Error::StsNoConv, {"needed a tenth of the matches to agree", "of 100"});
}

TEST(ActiveHandEye_EstimateFOE, wrong_input_is_named)
{
    const Pair pair = translate(Vec3d(30, 20, 40), 20, 0.1, 5);
    Vec3d foe;
    Mat withNaN = pair.x1.clone();
    withNaN.at<double>(4, 1) = std::numeric_limits<double>::quiet_NaN();
    expectError([&] { estimateFOE(withNaN, pair.x2, foe); }, Error::StsBadArg,
                {"points1", "finite", "given", "position 9"});
    expectError([&] { estimateFOE(pair.x1, pair.x2.rowRange(0, 19), foe); }, Error::StsBadSize,
                {"points2", "20 matches", "given 19"});
    expectError([&] { estimateFOE(pair.x1.t(), pair.x2.t(), foe); }, Error::StsBadSize,
                {"points1", "N x 2", "given 2 x 20"});
    expectError([&] { estimateFOE(pair.x1, pair.x2, foe, noArray(), noArray(), FOEMethod(7)); }, Error::StsBadArg,
                {"method", "given 7"});
    expectError([&] { estimateFOE(pair.x1, pair.x2, foe, noArray(), noArray(), FOE_RANSAC, -1); }, Error::StsOutOfRange,
                {"threshold", "positive", "given -1"});
    expectError([&] { estimateFOE(pair.x1, pair.x2, foe, noArray(), noArray(), FOE_RANSAC, 1, 1); },
                Error::StsOutOfRange, {"confidence", "between 0 and 1"});
}

}} // namespace opencv_test
