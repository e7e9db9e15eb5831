// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "measure_scene.hpp"

#include <numeric>

namespace opencv_test { namespace {

const double pixelSigma = 0.05, robotTranslation = 2e-5, robotRotation = 1e-4;

Vec3d normal(RNG& rng, double sigma)
{
    return Vec3d(rng.gaussian(sigma), rng.gaussian(sigma), rng.gaussian(sigma));
}

//! One scene point on the stripe of several views.
struct SeenPoint
{
    Measurement tool;
    Vec3d X;
    std::vector<Mat> R;
    std::vector<Vec3d> t;
    Mat pixels;

    //! The light plane of every view passes through the point; `spread` of the orientations in rad.
    SeenPoint(int views, double spread, uint64 seed) : tool(litScene()), X(0.31, 0.12, 0.05)
    {
        tool.D = Mat::zeros(5, 1, CV_64F);
        RNG rng(seed);
        const Vec3d n(tool.light[0], tool.light[1], tool.light[2]);
        for (int i = 0; i < views; ++i)
        {
            const Vec2d wanted(rng.uniform(200., 440.), 0);
            const double x = (wanted[0] - tool.K(0, 2)) / tool.K(0, 0), depth = rng.uniform(0.5, 0.6);
            // the point on the light plane with this column and depth
            const double y = (tool.light[3] / depth - n[0] * x - n[2]) / n[1];
            const Vec3d inCamera = depth * Vec3d(x, y, 1);
            const Matx33d Rg = rotation(normal(rng, spread)) * tool.R_gripper2base;
            R.push_back(Mat(Rg));
            t.push_back(X - Rg * (tool.R_cam2gripper * inCamera + tool.t_cam2gripper));
            pixels.push_back(Mat(Matx12d(tool.K(0, 0) * x + tool.K(0, 1) * y + tool.K(0, 2),
                                         tool.K(1, 1) * y + tool.K(1, 2))));
        }
    }

    std::vector<int> views() const
    {
        std::vector<int> result;
        for (int i = 0; i < pixels.rows; ++i)
            result.push_back(i);
        return result;
    }

    void measure(const Mat& seen, const std::vector<int>& stripeViews, const Mat& calibration, Mat& points,
                 Mat& covariances, Mat& disagreements, double tr = robotTranslation, double rr = robotRotation) const
    {
        const std::vector<int> ids(stripeViews.size(), 0);
        measureStripePoints(R, t, seen, stripeViews, ids, tool.K, tool.D, tool.light, tool.R_cam2gripper,
                            tool.t_cam2gripper, points, covariances, disagreements, calibration,
                            pixelCovariances(seen.rows), tr, rr);
    }

    static Mat pixelCovariances(int count)
    {
        const int sizes[] = {count, 2, 2};
        Mat result(3, sizes, CV_64F, Scalar(0));
        for (int i = 0; i < count; ++i)
            result.at<double>(i, 0, 0) = result.at<double>(i, 1, 1) = pixelSigma * pixelSigma;
        return result;
    }
};

Vec20d calibrationError(RNG& rng, const Vec4d& light)
{
    const double size[] = {0.2,  0.2,  0.3,  0.3,  1e-12, 1e-12, 1e-12, 1e-12, 1e-12, 1e-12,
                           1e-4, 1e-4, 1e-4, 4e-5, 4e-5,  4e-5,  1e-4,  1e-4,  1e-4,  3e-5};
    Vec20d error;
    for (int i = 0; i < 20; ++i)
        error[i] = rng.gaussian(size[i]);
    const Vec3d n(light[0], light[1], light[2]), dn(error[16], error[17], error[18]);
    const Vec3d tangent = dn - n * n.dot(dn);
    for (int i = 0; i < 3; ++i)
        error[16 + i] = tangent[i];
    return error;
}

//! Covariance of calibrationError by many draws.
Mat calibrationCovariance(const Vec4d& light)
{
    const double size[] = {0.2,  0.2,  0.3,  0.3,  1e-12, 1e-12, 1e-12, 1e-12, 1e-12, 1e-12,
                           1e-4, 1e-4, 1e-4, 4e-5, 4e-5,  4e-5,  1e-4,  1e-4,  1e-4,  3e-5};
    Mat C = Mat::zeros(20, 20, CV_64F);
    for (int i = 0; i < 20; ++i)
        C.at<double>(i, i) = size[i] * size[i];
    const Vec3d n(light[0], light[1], light[2]);
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            C.at<double>(16 + i, 16 + j) = 1e-8 * ((i == j) - n[i] * n[j]);
    return C;
}

Matx33d covarianceOf(const Mat& covariances)
{
    return Matx33d(covariances.ptr<double>(0));
}

Vec3d pointOf(const Mat& points)
{
    return Vec3d(points.ptr<double>(0));
}

TEST(ActiveHandEye_MeasurePoints, one_view_is_what_reprojectStripe_says)
{
    const SeenPoint seen(1, 0.1, 2);
    const Mat C = calibrationCovariance(seen.tool.light), sigma(1, 1, CV_64F, Scalar(pixelSigma));
    Mat points, covariances, apart, X, single;
    seen.measure(seen.pixels, seen.views(), C, points, covariances, apart);
    reprojectStripe(seen.pixels, seen.tool.K, seen.tool.D, seen.tool.light, X, single, seen.tool.R_cam2gripper,
                    seen.tool.t_cam2gripper, seen.R[0], seen.t[0], C, sigma, robotTranslation, robotRotation);
    EXPECT_LT(cv::norm(pointOf(points) - seen.X), 1e-12);
    EXPECT_LT(cv::norm(pointOf(points) - pointOf(X)), 1e-12);
    EXPECT_LT(cv::norm(covarianceOf(covariances) - covarianceOf(single)), 1e-9 * cv::norm(covarianceOf(single)));
    EXPECT_EQ(0, apart.at<double>(0));
}

TEST(ActiveHandEye_MeasurePoints, the_covariance_of_several_views_is_that_of_their_errors)
{
    const int views = 5, trials = 3000;
    const SeenPoint seen(views, 0.25, 3);
    const Mat C = calibrationCovariance(seen.tool.light);
    RNG rng(9);
    double sum = 0, disagreement = 0, largest = 0;
    for (int trial = 0; trial < trials; ++trial)
    {
        SeenPoint given = seen; // the calibration and the poses that the user has
        given.tool = seen.tool.corrected(calibrationError(rng, seen.tool.light));
        for (int i = 0; i < views; ++i)
        {
            given.R[size_t(i)] = Mat(rotation(normal(rng, robotRotation)) * Matx33d(seen.R[size_t(i)]));
            given.t[size_t(i)] = seen.t[size_t(i)] + normal(rng, robotTranslation);
        }
        Mat noisy = seen.pixels.clone(), points, covariances, apart;
        for (int i = 0; i < int(noisy.total()); ++i)
            noisy.ptr<double>()[i] += rng.gaussian(pixelSigma);
        given.measure(noisy, seen.views(), C, points, covariances, apart);
        const Vec3d error = pointOf(points) - seen.X;
        const double squared = error.dot(covarianceOf(covariances).inv() * error);
        sum += squared;
        largest = std::max(largest, squared);
        disagreement += cv::mean(apart)[0];
    }
    EXPECT_NEAR(3, sum / trials, 3 * 0.08); // chi-square with 3 degrees of freedom: 0.045 by chance
    EXPECT_LT(largest, 30);
    EXPECT_NEAR(3, disagreement / trials, 3 * 0.1);
}

TEST(ActiveHandEye_MeasurePoints, views_from_one_place_keep_the_error_of_the_calibration)
{
    SeenPoint seen(1, 0.1, 4);
    const Mat C = calibrationCovariance(seen.tool.light);
    const int count = 50;
    Mat points, all, noise, many, apart;
    seen.measure(seen.pixels, seen.views(), C, points, all, apart);
    seen.measure(seen.pixels, seen.views(), Mat(), points, noise, apart);
    const Mat repeated = repeat(seen.pixels, count, 1);
    seen.R.resize(count, seen.R[0]);
    seen.t.resize(count, seen.t[0]);
    std::vector<int> views(count);
    std::iota(views.begin(), views.end(), 0);
    seen.measure(repeated, views, C, points, many, apart);
    const Matx33d calibration = covarianceOf(all) - covarianceOf(noise);
    const Matx33d expected = calibration + covarianceOf(noise) * (1. / count);
    EXPECT_LT(cv::norm(covarianceOf(many) - expected), 1e-3 * cv::norm(expected));
    EXPECT_GT(cv::trace(calibration), 2 * cv::trace(covarianceOf(noise)) / count);
}

TEST(ActiveHandEye_MeasurePoints, pixels_of_one_view_share_the_error_of_its_pose)
{
    const SeenPoint seen(1, 0.1, 5);
    const int count = 40;
    Mat points, one, many, apart;
    seen.measure(seen.pixels, seen.views(), Mat(), points, one, apart, 1e-3, 0);
    seen.measure(repeat(seen.pixels, count, 1), std::vector<int>(count, 0), Mat(), points, many, apart, 1e-3, 0);
    for (int i = 0; i < 3; ++i) // the robot's millimetre stays, whatever the number of pixels
        EXPECT_GE(covarianceOf(many)(i, i), 1e-6);
    EXPECT_LT(cv::trace(covarianceOf(many)), cv::trace(covarianceOf(one)));
}

TEST(ActiveHandEye_MeasurePoints, a_wrong_pixel_disagrees)
{
    const SeenPoint seen(5, 0.25, 6);
    Mat wrong = seen.pixels.clone(), points, covariances, apart;
    wrong.at<double>(2, 1) += 20 * pixelSigma;
    seen.measure(wrong, seen.views(), Mat(), points, covariances, apart);
    double most;
    Point where;
    minMaxLoc(apart, nullptr, &most, nullptr, &where);
    EXPECT_EQ(2, where.y);
    EXPECT_GT(most, 100);
}

TEST(ActiveHandEye_MeasurePoints, points_are_returned_in_the_order_of_their_ids)
{
    const SeenPoint seen(3, 0.2, 7);
    Mat points, covariances, apart;
    const std::vector<int> ids = {1, 0, 1};
    measureStripePoints(seen.R, seen.t, seen.pixels, seen.views(), ids, seen.tool.K, seen.tool.D, seen.tool.light,
                        seen.tool.R_cam2gripper, seen.tool.t_cam2gripper, points, covariances, apart, Mat(),
                        SeenPoint::pixelCovariances(3), robotTranslation, robotRotation);
    ASSERT_EQ(2, points.rows);
    EXPECT_LT(cv::norm(Vec3d(points.ptr<double>(0)) - seen.X), 1e-10);
    EXPECT_EQ(0, apart.at<double>(1));
    EXPECT_LT(cv::trace(Matx33d(covariances.ptr<double>(1))), cv::trace(Matx33d(covariances.ptr<double>(0))));
}

TEST(ActiveHandEye_MeasurePoints, a_parameter_that_was_not_observed_leaves_infinite_variance)
{
    const SeenPoint seen(3, 0.2, 8);
    Mat C = calibrationCovariance(seen.tool.light), points, covariances, apart;
    C.at<double>(13, 13) = infinity; // t_cam2gripper x
    seen.measure(seen.pixels, seen.views(), C, points, covariances, apart);
    EXPECT_EQ(infinity, covarianceOf(covariances)(0, 0));
    EXPECT_LT(cv::norm(pointOf(points) - seen.X), 1e-10);
}

TEST(ActiveHandEye_MeasurePoints, wrong_input_is_named)
{
    const SeenPoint seen(2, 0.2, 9);
    Mat X, C, apart;
    const auto call = [&](const std::vector<int>& views, const std::vector<int>& ids, const Mat& pixelCovariances)
    {
        measureStripePoints(seen.R, seen.t, seen.pixels, views, ids, seen.tool.K, seen.tool.D, seen.tool.light,
                            seen.tool.R_cam2gripper, seen.tool.t_cam2gripper, X, C, apart, Mat(), pixelCovariances);
    };
    const Mat good = SeenPoint::pixelCovariances(2);
    const auto changed = [&](int row, int column, double value)
    {
        Mat result = good.clone();
        result.at<double>(1, row, column) = value;
        return result;
    };
    expectError([&] { call({0, 2}, {0, 0}, good); }, Error::StsOutOfRange, {"stripeViews[1]", "given 2"});
    expectError([&] { call({0, 1}, {0}, good); }, Error::StsBadSize, {"pointIds", "2 pixels, given 1"});
    expectError([&] { call({0, 1}, {1, 1}, good); }, Error::StsBadArg, {"pointIds", "given none that is 0"});
    expectError([&] { call({0, 1}, {0, -1}, good); }, Error::StsOutOfRange, {"pointIds[1]", "given -1"});
    expectError([&] { call({0, 1}, {0, 1}, good.reshape(1, 4)(Rect(0, 0, 2, 2))); }, Error::StsBadSize,
                {"pixelCovariances", "2 x 2 x 2"});
    for (const Mat& wrong : {changed(0, 1, 1), changed(1, 1, -1), changed(0, 0, std::nan("")), Mat(0 * good)})
        expectError([&] { call({0, 1}, {0, 1}, wrong); }, Error::StsBadArg, {"pixelCovariances["});
    expectError(
        [&]
        {
            Mat stray = seen.pixels.clone();
            stray.at<double>(0, 1) = stray.at<double>(0, 1) > 0 ? -9e6 : 9e6;
            stray.at<double>(1, 1) = -stray.at<double>(0, 1);
            seen.measure(stray, seen.views(), Mat(), X, C, apart);
        },
        Error::StsOutOfRange, {"stripePoints", "1 of 2 points"});
}

}} // namespace opencv_test
