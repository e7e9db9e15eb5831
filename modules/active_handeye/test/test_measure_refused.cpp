// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "measure_scene.hpp"

#include <limits>

namespace opencv_test { namespace {

TEST(ActiveHandEye_Measure, pixels_that_do_not_see_the_light_plane_are_named)
{
    Measurement m(litScene());
    m.D = Mat();
    m.pixels = (Mat_<double>(4, 2) << 320, 240, 300, -3e5, 310, 200, 320, 9e5);
    const double slope =
        m.light[0] * (300 - m.K(0, 2)) / m.K(0, 0) + m.light[1] * (-3e5 - m.K(1, 2)) / m.K(1, 1) + m.light[2];
    m.pixels.at<double>(slope < 0 ? 3 : 1, 1) = 250;
    expectError([&] { m.points(Measurement::CAMERA); }, Error::StsOutOfRange,
                {"stripePoints", "1 of 4 points", slope < 0 ? "not: 1;" : "not: 3;",
                 "light plane in front of the camera"});
}

TEST(ActiveHandEye_Measure, pixels_that_do_not_see_the_light_plane_are_NaN_where_that_is_allowed)
{
    const Measurement m(litScene());
    const Mat pixels = (Mat_<double>(3, 2) << 320, 240, 300, -3e5, 310, 200);
    const Vec3d ray((300 - m.K(0, 2)) / m.K(0, 0), (-3e5 - m.K(1, 2)) / m.K(1, 1), 1);
    const double sign = m.light[0] * ray[0] + m.light[1] * ray[1] + m.light[2] < 0 ? 1 : -1;
    Mat stray = pixels.clone(), X, C, clean, cleanC;
    stray.at<double>(1, 1) *= sign;
    const double sigma = 0.1;
    const Mat sigmas(1, 1, CV_64F, Scalar(sigma)), kept = (Mat_<double>(2, 2) << 320, 240, 310, 200);
    reprojectStripe(stray, m.K, noArray(), m.light, X, C, noArray(), noArray(), noArray(), noArray(), noArray(), sigmas,
                    0, 0, true);
    reprojectStripe(kept, m.K, noArray(), m.light, clean, cleanC, noArray(), noArray(), noArray(), noArray(), noArray(),
                    sigmas);
    EXPECT_TRUE(std::isnan(X.at<double>(1, 0)) && std::isnan(C.at<double>(1, 2, 2)));
    EXPECT_EQ(0, cv::norm(X.row(0), clean.row(0)) + cv::norm(X.row(2), clean.row(1)));
    EXPECT_EQ(cleanC.at<double>(1, 2, 2), C.at<double>(2, 2, 2));
}

TEST(ActiveHandEye_Measure, wrong_input_is_named)
{
    const Measurement good(litScene());
    Mat X;
    const auto call = [&](const Vec4d& light, const Mat& t_cam2gripper)
    { reprojectStripe(good.pixels, good.K, good.D, light, X, noArray(), good.R_cam2gripper, t_cam2gripper); };
    expectError([&] { call(Vec4d(0, 1, 1, 0.5), Mat(good.t_cam2gripper)); }, Error::StsBadArg,
                {"lightPlane", "|n| = 1", "given |n| = 1.41421"});
    expectError([&] { call(Vec4d(0, 1, 0, -0.5), Mat(good.t_cam2gripper)); }, Error::StsBadArg,
                {"lightPlane", "d > 0"});
    expectError([&] { call(good.light, Mat()); }, Error::StsBadArg, {"t_cam2gripper", "together with R_cam2gripper"});
    expectError([&] { reprojectStripe(good.pixels, good.K, good.D, Mat(), X); }, Error::StsBadSize,
                {"lightPlane", "4 numbers"});
    expectError(
        [&]
        {
            reprojectStripe(good.pixels, good.K, good.D, good.light, X, noArray(), noArray(), noArray(),
                            good.R_gripper2base, good.t_gripper2base);
        },
        Error::StsBadArg, {"R_cam2gripper", "together with R_gripper2base"});
}

TEST(ActiveHandEye_Measure, wrong_error_sources_are_named)
{
    const Measurement m(litScene());
    const auto call = [&](InputArray C, InputArray sigmas, double robot, Measurement::Frame frame)
    { m.covariances(frame, C, sigmas, robot); };
    Mat C = Mat::eye(20, 20, CV_64F);
    C.at<double>(3, 1) = 0.5;
    expectError([&] { call(C, noArray(), 0, Measurement::BASE); }, Error::StsBadArg,
                {"calibrationCovariance", "symmetric", "c_3,1 = 0.5, c_1,3 = 0"});
    C.at<double>(1, 3) = C.at<double>(3, 1) = 2;
    expectError([&] { call(C, noArray(), 0, Measurement::BASE); }, Error::StsBadArg, {"calibrationCovariance", "= 2"});
    C.at<double>(1, 3) = C.at<double>(3, 1) = 0;
    C.at<double>(4, 4) = std::numeric_limits<double>::quiet_NaN();
    expectError([&] { call(C, noArray(), 0, Measurement::BASE); }, Error::StsBadArg, {"calibrationCovariance", "nan"});
    expectError([&] { call(Mat::eye(4, 4, CV_64F), noArray(), 0, Measurement::BASE); }, Error::StsBadSize,
                {"calibrationCovariance", "20 x 20", "given 4 x 4"});
    expectError([&] { call(noArray(), Mat(3, 1, CV_64F, Scalar(0.1)), 0, Measurement::BASE); }, Error::StsBadSize,
                {"pixelSigmas", "7 points", "given 3"});
    expectError([&] { call(noArray(), -0.1, 0, Measurement::BASE); }, Error::StsOutOfRange,
                {"pixelSigmas", "given -0.1"});
    expectError([&] { call(noArray(), noArray(), -1, Measurement::BASE); }, Error::StsOutOfRange,
                {"robotTranslationSigma", "given -1"});
    expectError([&] { call(noArray(), noArray(), 1e-5, Measurement::GRIPPER); }, Error::StsBadArg,
                {"robotTranslationSigma", "R_gripper2base"});
}

}} // namespace opencv_test
