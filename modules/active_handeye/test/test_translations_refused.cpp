// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "translations_scene.hpp"

namespace opencv_test { namespace {

using namespace translations;

TEST(ActiveHandEye_Translations, motion_that_cannot_answer_is_refused_with_what_is_missing)
{
    const PointScene full = oneGroup(PointScene::fourTranslations());
    PointScene turning(2);
    for (int k = 0; k < 4; ++k)
        turning.addGroup(Vec3d(0.1 * k * k, 0, 0), vector<Vec3d>(1, Vec3d()));
    turning.project();
    expectError([&] { calibrate(turning); }, Error::StsNoConv,
                {"R_gripper2base: no two views have equal orientation", "orientationTolerance = 0.05 deg",
                 "views 0 and 1 come nearest with 5.730 deg"});

    const Matx33d cameraToBase = Matx33d(full.R[0]) * full.R_cam2gripper;
    const auto column = [&](int k)
    { return cv::format("(%.2f, %.2f, %.2f)", cameraToBase(0, k), cameraToBase(1, k), cameraToBase(2, k)); };
    const PointScene still = oneGroup(vector<Vec3d>(3, Vec3d()));
    expectError([&] { calibrate(still); }, Error::StsNoConv, {"t_gripper2base", "all at one place", "given none"});
    const PointScene parallel = oneGroup(vector<Vec3d>{Vec3d(), Vec3d(50, 0, 0), Vec3d(-30, 0, 0)});
    expectError([&] { calibrate(parallel, TRANSLATIONS_METRIC, TRANSLATIONS_FIX_K, Mat(full.K)); }, Error::StsNoConv,
                {"all translations are parallel", "two that are not parallel", "in base coordinates: add one along"});
    const PointScene coplanar = oneGroup(vector<Vec3d>{Vec3d(), Vec3d(50, 0, 0), Vec3d(-30, 50, 0), Vec3d(10, -40, 0)});
    for (int method : {TRANSLATIONS_METRIC, TRANSLATIONS_FOE})
        expectError([&] { calibrate(coplanar, TranslationsMethod(method)); }, Error::StsNoConv,
                    {"all translations are coplanar", "three that are not coplanar", "add one along",
                     "in base coordinates"});
    string text;
    try
    {
        calibrate(coplanar);
    }
    catch (const cv::Exception& e)
    {
        text = e.what();
    }
    const Matx33d minus = -1 * cameraToBase;
    const string opposite = cv::format("(%.2f, %.2f, %.2f)", minus(0, 2), minus(1, 2), minus(2, 2));
    EXPECT_TRUE(text.find(column(2)) != string::npos || text.find(opposite) != string::npos)
        << text << "\nneeded +-" << column(2);

    vector<Vec3d> three = PointScene::fourTranslations();
    three.pop_back();
    expectError([&] { calibrate(oneGroup(three), TRANSLATIONS_FOE); }, Error::StsNoConv,
                {"TRANSLATIONS_FOE", "at least four translations", "TRANSLATIONS_METRIC, which needs three"});
}

TEST(ActiveHandEye_Translations, images_that_cannot_answer_are_refused)
{
    const PointScene full = PointScene::complete();
    PointScene lost = full;
    for (Mat& pixels : lost.imagePoints)
        pixels.rowRange(1, pixels.rows).setTo(std::numeric_limits<double>::quiet_NaN());
    expectError([&] { calibrate(lost); }, Error::StsNoConv,
                {"too few points in common", "given 1 such points", "out of 30 points in 12 views"});
    PointScene frozen = full;
    for (Mat& pixels : frozen.imagePoints)
        pixels = full.imagePoints[0];
    expectError([&] { calibrate(frozen); }, Error::StsNoConv, {"no parallax", "median displacement of 0 px"});
    RNG rng(4);
    for (Mat& pixels : frozen.imagePoints)
    {
        Mat noise(pixels.size(), CV_64F);
        rng.fill(noise, RNG::NORMAL, 0, 0.1);
        pixels = full.imagePoints[0] + noise;
    }
    expectError([&] { calibrate(frozen); }, Error::StsNoConv, {"parallax"});
    PointScene inverted = full;
    for (size_t view = 0; view < full.R.size(); ++view)
    {
        inverted.R[view] = full.R[view].t();
        inverted.t[view] = -full.R[view].t() * full.t[view];
    }
    expectError([&] { calibrate(inverted); }, Error::StsNoConv, {"needed", "poses"});
}

TEST(ActiveHandEye_Translations, wrong_input_is_named)
{
    const PointScene good = PointScene::complete();
    PointScene bad = good;
    const double nan = std::numeric_limits<double>::quiet_NaN();
    bad.t[3] = (Mat_<double>(3, 1) << 1., nan, 3.);
    expectError([&] { calibrate(bad); }, Error::StsBadArg, {"t_gripper2base[3]", "finite"});
    bad = good;
    bad.R[1] = Mat(2 * good.R[1]);
    expectError([&] { calibrate(bad); }, Error::StsBadArg, {"R_gripper2base[1]", "needed a rotation", "given"});
    bad.R[1] = Mat(-good.R[1]);
    expectError([&] { calibrate(bad); }, Error::StsBadArg, {"R_gripper2base[1]", "left-handed"});
    bad.R[1] = Mat::eye(4, 4, CV_64F);
    expectError([&] { calibrate(bad); }, Error::StsBadSize, {"R_gripper2base[1]", "3 x 3", "given 4 x 4"});
    bad = good;
    bad.t.pop_back();
    expectError([&] { calibrate(bad); }, Error::StsBadSize, {"t_gripper2base", "12", "given 11"});
    bad = good;
    bad.t[5] = good.t[5] * 1000;
    expectError([&] { calibrate(bad); }, Error::StsBadArg, {"t_gripper2base[5]", "millimetres and metres"});
    bad.t[5] = good.t[5] * 0.001;
    expectError([&] { calibrate(bad); }, Error::StsBadArg, {"t_gripper2base[5]", "millimetres and metres"});
    bad = good;
    bad.imagePoints.pop_back();
    expectError([&] { calibrate(bad); }, Error::StsBadSize, {"imagePoints", "12 views", "given 11"});
    bad = good;
    bad.imagePoints[4] = good.imagePoints[4].rowRange(0, 29);
    expectError([&] { calibrate(bad); }, Error::StsBadSize, {"imagePoints[4]", "30 pixels", "given 29"});
    bad.imagePoints[4] = good.imagePoints[4].t();
    expectError([&] { calibrate(bad); }, Error::StsBadSize, {"imagePoints[4]", "N x 2", "given 2 x 30"});
    bad.imagePoints[4] = good.imagePoints[4].clone();
    bad.imagePoints[4].at<double>(7, 0) = infinity;
    expectError([&] { calibrate(bad); }, Error::StsBadArg, {"imagePoints[4]", "at point 7"});
    bad.imagePoints[4].at<double>(7, 0) = nan;
    expectError([&] { calibrate(bad); }, Error::StsBadArg, {"imagePoints[4]", "(NaN, NaN)", "at point 7"});

    expectError([&] { calibrate(good, TranslationsMethod(5)); }, Error::StsBadArg, {"method", "given 5"});
    expectError([&] { calibrate(good, TRANSLATIONS_METRIC, 8); }, Error::StsBadArg, {"flags", "given 8"});
    expectError([&] { calibrate(good, TRANSLATIONS_METRIC, TRANSLATIONS_FIX_K); }, Error::StsBadSize,
                {"cameraMatrix", "3 x 3", "given none"});
    expectError([&] { calibrate(good, TRANSLATIONS_METRIC, TRANSLATIONS_FIX_K, Mat::ones(3, 3, CV_64F)); },
                Error::StsBadArg, {"cameraMatrix", "fx, skew, cx"});
    expectError([&] { calibrate(good, TRANSLATIONS_METRIC, 0, Mat(), Mat::zeros(1, 8, CV_64F)); }, Error::StsBadSize,
                {"distCoeffs", "given 8"});
    const Mat folding = (Mat_<double>(1, 4) << -30., 0., 0., 0.);
    expectError([&] { calibrate(good, TRANSLATIONS_METRIC, TRANSLATIONS_FIX_K, Mat(good.K), folding); },
                Error::StsOutOfRange, {"distCoeffs", "cannot be inverted at pixel"});
}

}} // namespace opencv_test
