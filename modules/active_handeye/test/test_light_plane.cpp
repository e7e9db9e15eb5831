// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "stripe_scene.hpp"

namespace opencv_test { namespace {

TEST(ActiveHandEye_calibrateLightPlane, ExactDataGiveTheExactPlane)
{
    StripeScene scene = StripeScene::standard();
    scene.shine();
    Vec4d plane;
    Mat covariance(4, 4, CV_64F);
    const double rms = scene.calibrate(plane, covariance);
    EXPECT_LE(rms, 1e-9);
    EXPECT_LE(cv::norm(plane, Vec4d(scene.n[0], scene.n[1], scene.n[2], scene.d), NORM_INF), 1e-9);
    EXPECT_NEAR(1, cv::norm(Vec3d(plane[0], plane[1], plane[2])), 1e-15);
}

TEST(ActiveHandEye_calibrateLightPlane, OneSurfaceInTwoGroups)
{
    StripeScene scene = StripeScene::standard();
    scene.surfaces.resize(1);
    scene.shine();
    Vec4d plane;
    scene.calibrate(plane);
    EXPECT_LE(cv::norm(plane, Vec4d(scene.n[0], scene.n[1], scene.n[2], scene.d), NORM_INF), 1e-9);
}

TEST(ActiveHandEye_calibrateLightPlane, ThreeSurfacesInOneGroup)
{
    StripeScene scene = StripeScene::standard();
    scene.R.resize(5);
    scene.t.resize(5);
    scene.shine();
    Vec4d plane;
    scene.calibrate(plane);
    EXPECT_LE(cv::norm(plane, Vec4d(scene.n[0], scene.n[1], scene.n[2], scene.d), NORM_INF), 1e-9);
}

}} // namespace opencv_test
