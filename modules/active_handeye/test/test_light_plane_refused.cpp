// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "stripe_scene.hpp"

namespace opencv_test { namespace {

void expectRefused(const StripeScene& scene, int code, const vector<string>& parts)
{
    Vec4d plane;
    expectError([&] { scene.calibrate(plane); }, code, parts);
}

TEST(ActiveHandEye_calibrateLightPlane, TooFewViewsOfEverySurface)
{
    StripeScene scene = StripeScene::standard();
    scene.R.resize(2);
    scene.t.resize(2);
    scene.shine();
    expectRefused(scene, Error::StsNoConv,
                  {"surfaceIds: no surface has its stripe in enough views", "at least 3 views",
                   "surface 2 in the group of view 0: 2"});
    scene.ids.assign(scene.ids.size(), -1);
    expectRefused(scene, Error::StsNoConv, {"given no segment with a surface id"});
}

TEST(ActiveHandEye_calibrateLightPlane, NoTwoViewsOfEqualOrientation)
{
    StripeScene scene;
    for (int i = 0; i < 4; ++i)
        scene.addGroup(Vec3d(1, 0.2 * i, 0), 3 * i, {Vec3d(0, 0, 0.5)});
    scene.addSurface(Vec3d(0, 0, 1), 0, 40, 600);
    scene.shine();
    expectRefused(scene, Error::StsNoConv, {"R_gripper2base: no two views have equal orientation", "views 0 and 1"});
}

TEST(ActiveHandEye_calibrateLightPlane, MislabelledSurfaceIsNamed)
{
    StripeScene scene;
    scene.addGroup(Vec3d(1, 0, 0), 0, StripeScene::star(0.05));
    scene.R.pop_back();
    scene.t.pop_back();
    for (double tilt : {-0.5, 0., 0.5})
        scene.addSurface(Vec3d(tilt, 0.3 * tilt * tilt, 1), 0.05 * std::abs(tilt - 0.2), 40, 600);
    scene.shine();
    for (size_t i = 0; i < scene.ids.size(); ++i)
        scene.ids[i] = scene.ids[i] == scene.views[i] % 3 ? 4 : -1; // each view another surface
    expectRefused(scene, Error::StsNoConv,
                  {"surfaceIds: stripes of one surface in one group do not share a vanishing direction",
                   "a mislabelled surface", "(view 1, surface 4) by"});
}

TEST(ActiveHandEye_calibrateLightPlane, TranslationsAlongTheStripeOnly)
{
    StripeScene scene;
    const Vec3d centre(0, 0, 0.5);
    // the plane n.X = d and the table meet along x of the base frame when n has no x component
    scene.n = Vec3d(0, -0.5, 0.13) / std::sqrt(0.25 + 0.0169);
    scene.d = scene.n[2] * 0.5;
    scene.addGroup(Vec3d(1, 0, 0), 0,
                   {centre, centre + Vec3d(0.05, 0, 0), centre + Vec3d(-0.05, 0, 0), centre + Vec3d(0.02, 0, 0)});
    scene.addSurface(Vec3d(0, 0.2, 1), 0, 40, 600);
    scene.shine();
    expectRefused(scene, Error::StsNoConv,
                  {"t_gripper2base: the camera was moved along the stripe only", "in base coordinates"});
}

TEST(ActiveHandEye_calibrateLightPlane, TranslationsAlongTheSurfaceOnly)
{
    StripeScene scene;
    const Vec3d centre(0, 0, 0.5);
    scene.addGroup(Vec3d(1, 0, 0), 0,
                   {centre, centre + Vec3d(0.05, 0, 0), centre + Vec3d(0, 0.05, 0), centre + Vec3d(0.03, -0.03, 0)});
    scene.addSurface(Vec3d(0, 0, 1), 0, 40, 600);
    scene.shine();
    expectRefused(scene, Error::StsNoConv,
                  {"stripePoints: the stripes stand still", "e.g. along (0.00, 0.00, -1.00) in base coordinates"});
}

TEST(ActiveHandEye_calibrateLightPlane, OneDirectionAcrossTheStripeNamesTheMissingOne)
{
    StripeScene scene;
    scene.n = Vec3d(0, -0.5, 0.13) / std::sqrt(0.25 + 0.0169);
    scene.d = scene.n[2] * 0.5;
    const Vec3d centre(0, 0, 0.5);
    for (int group = 0; group < 2; ++group)
        scene.addGroup(Vec3d(1, 0, 0), 15 * group,
                       {centre, centre + Vec3d(0.05, 0, 0.02), centre + Vec3d(0, 0, 0.05),
                        centre + Vec3d(0.03, 0, -0.03)});
    scene.addSurface(Vec3d(0, 0, 1), 0, 40, 600);
    scene.shine();
    expectRefused(scene, Error::StsNoConv,
                  {"t_gripper2base: the translations have one direction only across the stripe",
                   "(0.00, 1.00, 0.00) in base coordinates"});
}

TEST(ActiveHandEye_calibrateLightPlane, OneCommonStripeDirectionNamesAnAxisToTurnAbout)
{
    StripeScene scene;
    scene.n = Vec3d(0, -0.5, 0.13) / std::sqrt(0.25 + 0.0169);
    scene.d = scene.n[2] * 0.5;
    const Vec3d centre(0, 0, 0.5);
    scene.addGroup(Vec3d(1, 0, 0), 0, {centre, centre + Vec3d(0, 0.01, 0.01), centre + Vec3d(0, -0.01, 0.01)});
    scene.addSurface(Vec3d(0, 0.1, 1), 0, 40, 600);
    scene.shine();
    expectRefused(scene, Error::StsNoConv,
                  {"stripePoints: all groups share the stripe direction (", "1.00, 0.00, 0.00) in base coordinates",
                   "turn the gripper about an axis across the stripe, e.g. about (0.00, 1.00, 0.00)"});
}

TEST(ActiveHandEye_calibrateLightPlane, WeakAnswerIsRefusedWithItsUncertainty)
{
    StripeScene scene = StripeScene::standard();
    scene.surfaces.resize(1);
    scene.R.clear();
    scene.t.clear();
    scene.addGroup(Vec3d(1, 0, 0), 0, StripeScene::star(0.02));
    scene.shine(0.05);
    expectRefused(scene, Error::StsNoConv,
                  {"stripePoints: all groups share the stripe direction", "standard deviations would be"});
}

//! Two groups of three views of one surface: 12 numbers for 9 unknowns, so that often very different planes fit as well.
StripeScene scantScene(uint64 seed)
{
    StripeScene scene;
    RNG rng(seed);
    const auto vector3 = [&rng](double size)
    {
        Vec3d v;
        for (int k = 0; k < 3; ++k)
            v[k] = rng.uniform(-size, size);
        return v;
    };
    const Vec3d normal = Vec3d(0, -0.5, 0.25) + vector3(0.15), table = Vec3d(0, 0, 1) + vector3(0.6);
    scene.n = normal / cv::norm(normal);
    scene.d = scene.n[2] * 0.5;
    scene.D.assign(5, 0);
    for (int group = 0; group < 2; ++group)
    {
        const Vec3d centre(0, 0, 0.5);
        scene.addGroup(vector3(1), group * rng.uniform(3., 20.),
                       {centre, centre + vector3(0.05), centre + vector3(0.05)});
    }
    scene.addSurface(table, 0, 40, 600);
    scene.columnStep = 8;
    scene.shine(0.1, seed);
    return scene;
}

TEST(ActiveHandEye_calibrateLightPlane, ScantStripesGiveAPlaneWithinItsUncertaintyOrNone)
{
    int answers = 0;
    for (uint64 seed = 1; seed <= 200; ++seed)
    {
        const StripeScene scene = scantScene(seed);
        Vec4d plane;
        Matx44d covariance;
        Mat given(covariance, false);
        try
        {
            scene.calibrate(plane, given);
        }
        catch (const cv::Exception& e)
        {
            EXPECT_EQ(int(Error::StsNoConv), e.code) << e.what();
            continue;
        }
        ++answers;
        const double deviation = std::sqrt(covariance(0, 0) + covariance(1, 1) + covariance(2, 2)) * 180 / CV_PI;
        EXPECT_LE(scene.normalError(plane), 5 * deviation) << "seed " << seed;
    }
    EXPECT_GE(answers, 60);
}

TEST(ActiveHandEye_calibrateLightPlane, InvertedPosesPutThePlaneBehindTheCamera)
{
    StripeScene scene = StripeScene::standard();
    scene.shine();
    for (Mat& t : scene.t)
        t = -t;
    expectRefused(scene, Error::StsNoConv, {"t_gripper2base: the stripes move against the camera's translations"});
}

TEST(ActiveHandEye_calibrateLightPlane, ContradictingSegmentsAreNamed)
{
    StripeScene scene = StripeScene::standard();
    scene.shine(0.05);
    RNG rng(3);
    for (size_t i = 0; i < scene.points.size(); i += 2)
        scene.points[i].col(1) += rng.uniform(-60., 60.);
    expectRefused(scene, Error::StsNoConv, {"surfaceIds:", "stripePoints[", "px"});
}

TEST(ActiveHandEye_calibrateLightPlane, WrongInputNamesTheArgument)
{
    StripeScene good = StripeScene::standard();
    good.shine();
    StripeScene scene = good.copy();
    scene.views.pop_back();
    expectRefused(scene, Error::StsBadSize, {"stripeViews: needed one view for each of the 30 segments", "given 29"});
    scene = good.copy();
    scene.views[3] = 10;
    expectRefused(scene, Error::StsOutOfRange, {"stripeViews[3]: needed a view from 0 to 9, given 10"});
    scene = good.copy();
    scene.ids.push_back(1);
    expectRefused(scene, Error::StsBadSize, {"surfaceIds: needed one id for each of the 30 segments", "given 31"});
    scene = good.copy();
    scene.ids[5] = -2;
    expectRefused(scene, Error::StsOutOfRange, {"surfaceIds[5]: needed an id from 0 on, or -1", "given -2"});
    scene = good.copy();
    scene.points[2].at<double>(4, 1) = std::numeric_limits<double>::quiet_NaN();
    expectRefused(scene, Error::StsBadArg, {"stripePoints[2]: needed finite numbers", "nan"});
    scene = good.copy();
    scene.points[2] = scene.points[2].rowRange(0, 1).clone();
    expectRefused(scene, Error::StsBadSize, {"stripePoints[2]: needed at least 2 points, given 1"});
    scene = good.copy();
    scene.points[1] = Mat(5, 2, CV_64F, Scalar(7));
    expectRefused(scene, Error::StsBadArg, {"stripePoints[1]: needed a straight segment"});
    scene = good.copy();
    scene.t.pop_back();
    expectRefused(scene, Error::StsBadSize, {"t_gripper2base"});
    scene = good.copy();
    scene.R[0] = scene.R[0] * 2;
    expectRefused(scene, Error::StsBadArg, {"R_gripper2base[0]: needed a rotation"});
    scene = good.copy();
    scene.K(0, 0) = -1;
    expectRefused(scene, Error::StsBadArg, {"cameraMatrix"});
    scene = good.copy();
    scene.D.push_back(1);
    expectRefused(scene, Error::StsBadSize, {"distCoeffs"});
    Vec4d plane;
    expectError([&] { good.calibrate(plane, Mat(), Mat(2, 2, CV_64F, Scalar(1))); }, Error::StsBadSize,
                {"knownPoints: needed M x 3"});
}

}} // namespace opencv_test
