// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "stripe_scene.hpp"

namespace opencv_test { namespace {

//! Its stripes share one vanishing direction, which leaves the light plane undetermined.
StripeScene oneSurfaceInOneGroup()
{
    StripeScene scene = StripeScene::standard();
    scene.R.resize(5);
    scene.t.resize(5);
    scene.surfaces.resize(1);
    scene.shine();
    return scene;
}

void expectExact(const StripeScene& scene, const std::vector<Vec3d>& known)
{
    Vec4d plane;
    const double rms = scene.calibrate(plane, Mat(), Mat(known).reshape(1, int(known.size())));
    EXPECT_LE(rms, 1e-8);
    EXPECT_LE(cv::norm(plane, Vec4d(scene.n[0], scene.n[1], scene.n[2], scene.d), NORM_INF), 1e-9);
}

TEST(ActiveHandEye_calibrateLightPlane, KnownPointsReplaceTheSecondDirection)
{
    StripeScene scene = oneSurfaceInOneGroup();
    std::vector<Vec3d> known;
    for (double column : {60., 200., 400., 600.})
        for (double row : {100., 300.})
        {
            const Vec3d ray = scene.K.inv() * Vec3d(column, row, 1);
            known.push_back(ray * (scene.d / scene.n.dot(ray)));
        }
    expectExact(scene, known);
}

//! A scene point on the stripe of `view` at an ideal column.
Vec3d pointOnStripe(const StripeScene& scene, int view, double column)
{
    const double row = scene.stripeRow(view, scene.surfaces[0], column, scene.n, scene.d);
    const Vec3d ray = scene.K.inv() * Vec3d(column, row, 1);
    return ray * (scene.d / scene.n.dot(ray)); // camera frame of the view
}

//! The paper's (30), (31): of a pure translation c the depth follows from where a point is seen before and after it.
Vec3d pointFromTranslation(const Vec3d& first, const Vec3d& second, const Vec3d& c)
{
    const Vec3d across = second.cross(first), moved = second.cross(c); // z1 second x first = second x c
    return first * (across.dot(moved) / across.dot(across));
}

TEST(ActiveHandEye_calibrateLightPlane, CharacteristicPointsOfTwoTranslatedViewsReplaceTheSecondDirection)
{
    StripeScene scene = oneSurfaceInOneGroup();
    const Vec3d c = scene.cam2base(0).t() * (scene.cameraPosition(2) - scene.cameraPosition(0));
    std::vector<Vec3d> known;
    for (double column : {50., 120., 200.})
    {
        const Vec3d X = pointOnStripe(scene, 0, column), moved = X - c;
        known.push_back(pointFromTranslation(X / X[2], moved / moved[2], c));
        EXPECT_LE(cv::norm(known.back() - X), 1e-12);
    }
    expectExact(scene, known);

    Vec4d plane;
    Mat alone(4, 4, CV_64F), together(4, 4, CV_64F);
    scene.surfaces = StripeScene::standard().surfaces;
    scene.shine(0.1);
    scene.calibrate(plane, alone);
    scene.calibrate(plane, together, Mat(known).reshape(1, int(known.size())));
    for (int i = 0; i < 4; ++i)
        EXPECT_LT(together.at<double>(i, i), alone.at<double>(i, i));
}

}} // namespace opencv_test
