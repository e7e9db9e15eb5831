// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "refine_scene.hpp"

#include <functional>

namespace opencv_test { namespace {

using namespace refine;

const double NaN = std::numeric_limits<double>::quiet_NaN();

//! A good call with a start, spoiled by `spoil`, is refused with this text, and no argument of the caller's changes.
void expectRefused(const std::function<void(Refinement&)>& spoil, int code, const vector<string>& parts)
{
    static const RefineScene scene = []
    {
        RefineScene made(1);
        made.addViews();
        made.addSurfaces();
        made.measure(0.1, 0.02, 0.005, 0.05);
        return made;
    }();
    Refinement call = scene.call();
    call.K = Mat(scene.K).clone();
    call.D = Mat::zeros(5, 1, CV_64F);
    call.R_cam2gripper = Mat(scene.R_cam2gripper).clone();
    call.t_cam2gripper = Mat(scene.t_cam2gripper).clone();
    call.light = scene.trueLight();
    spoil(call);
    const Mat K = call.K.clone(), t = call.t_cam2gripper.clone();
    expectError([&] { call.run(); }, code, parts);
    EXPECT_TRUE(sameBits(K, call.K) && sameBits(t, call.t_cam2gripper)) << parts[0];
}

TEST(ActiveHandEye_RefineRefused, poses_and_points)
{
    expectRefused([](Refinement& c) { c.R[3] = c.R[3] * 1.01; }, Error::StsBadArg,
                  {"R_gripper2base[3]", "needed a rotation"});
    expectRefused([](Refinement& c) { c.R[3] = -c.R[3]; }, Error::StsBadArg, {"R_gripper2base[3]", "left-handed"});
    expectRefused([](Refinement& c) { c.R.pop_back(); }, Error::StsBadSize, {"t_gripper2base", "18", "19"});
    expectRefused([](Refinement& c) { c.t[5] = Mat::zeros(2, 1, CV_64F); }, Error::StsBadSize,
                  {"t_gripper2base[5]", "3 numbers"});
    expectRefused([](Refinement& c) { c.t[5].at<double>(1) = NaN; }, Error::StsBadArg, {"t_gripper2base[5]", "finite"});
    expectRefused([](Refinement& c) { c.t[5] *= 1000; }, Error::StsBadArg,
                  {"t_gripper2base[5]", "millimetres and metres"});
    expectRefused([](Refinement& c) { c.imagePoints.pop_back(); }, Error::StsBadSize,
                  {"imagePoints", "19 views", "given 18"});
    expectRefused([](Refinement& c) { c.imagePoints[2] = c.imagePoints[2].rowRange(0, 39); }, Error::StsBadSize,
                  {"imagePoints[2]", "40", "39"});
    expectRefused([](Refinement& c) { c.imagePoints[2] = Mat::ones(40, 3, CV_64F); }, Error::StsBadSize,
                  {"imagePoints[2]", "N x 2"});
    expectRefused([](Refinement& c) { c.imagePoints[2].at<double>(7, 0) = NaN; }, Error::StsBadArg,
                  {"imagePoints[2]", "point 7"});
    expectRefused([](Refinement& c) { c.imagePoints[2].at<double>(7, 0) = infinity; }, Error::StsBadArg,
                  {"imagePoints[2]", "inf", "point 7"});
}

TEST(ActiveHandEye_RefineRefused, starts)
{
    expectRefused([](Refinement& c) { c.K = Mat::eye(2, 2, CV_64F); }, Error::StsBadSize, {"cameraMatrix", "3 x 3"});
    expectRefused([](Refinement& c) { c.K.at<double>(1, 1) = -1; }, Error::StsBadArg, {"cameraMatrix", "fx, fy > 0"});
    expectRefused([](Refinement& c) { c.K.at<double>(0, 2) = NaN; }, Error::StsBadArg, {"cameraMatrix", "finite"});
    expectRefused([](Refinement& c) { c.D = Mat::zeros(3, 1, CV_64F); }, Error::StsBadSize, {"distCoeffs", "given 3"});
    expectRefused([](Refinement& c) { c.D.at<double>(0) = infinity; }, Error::StsBadArg, {"distCoeffs", "finite"});
    expectRefused([](Refinement& c) { c.R_cam2gripper *= 1.1; }, Error::StsBadArg,
                  {"R_cam2gripper", "needed a rotation"});
    expectRefused([](Refinement& c) { c.t_cam2gripper = Mat::zeros(4, 1, CV_64F); }, Error::StsBadSize,
                  {"t_cam2gripper", "3 numbers"});
    expectRefused([](Refinement& c) { c.t_cam2gripper.at<double>(0) = NaN; }, Error::StsBadArg,
                  {"t_cam2gripper", "finite"});
    expectRefused([](Refinement& c) { c.light = Mat::ones(3, 1, CV_64F); }, Error::StsBadSize,
                  {"lightPlane", "4 numbers"});
    expectRefused([](Refinement& c) { c.light *= 2; }, Error::StsBadArg, {"lightPlane", "|n| = 1"});
    expectRefused([](Refinement& c) { c.light.at<double>(3) = -5; }, Error::StsBadArg, {"lightPlane", "d > 0", "-5"});
    expectRefused([](Refinement& c) { c.light.at<double>(1) = NaN; }, Error::StsBadArg, {"lightPlane"});
    const auto withoutStart = [](int flag)
    {
        return [flag](Refinement& c)
        {
            c.params.flags = flag;
            c.K = c.D = c.R_cam2gripper = c.t_cam2gripper = c.light = Mat();
        };
    };
    expectRefused(withoutStart(REFINE_FIX_K), Error::StsBadArg, {"cameraMatrix", "REFINE_FIX_K", "given none"});
    expectRefused(withoutStart(REFINE_FIX_ROTATION), Error::StsBadArg,
                  {"R_cam2gripper", "REFINE_FIX_ROTATION", "given none"});
    expectRefused(withoutStart(REFINE_FIX_TRANSLATION), Error::StsBadArg,
                  {"t_cam2gripper", "REFINE_FIX_TRANSLATION", "given none"});
    expectRefused(withoutStart(REFINE_FIX_LIGHT_PLANE), Error::StsBadArg,
                  {"lightPlane", "REFINE_FIX_LIGHT_PLANE", "given none"});
}

TEST(ActiveHandEye_RefineRefused, stripes)
{
    expectRefused([](Refinement& c) { c.stripeViews.pop_back(); }, Error::StsBadSize, {"stripeViews", "57"});
    expectRefused([](Refinement& c) { c.stripeViews[4] = 19; }, Error::StsOutOfRange, {"stripeViews[4]", "19"});
    expectRefused([](Refinement& c) { c.stripeViews[4] = -1; }, Error::StsOutOfRange, {"stripeViews[4]", "-1"});
    expectRefused([](Refinement& c) { c.surfaceIds.pop_back(); }, Error::StsBadSize, {"surfaceIds", "57"});
    expectRefused([](Refinement& c) { c.surfaceIds[6] = -2; }, Error::StsOutOfRange, {"surfaceIds[6]", "-2"});
    expectRefused([](Refinement& c) { c.stripes[9].at<double>(3, 1) = NaN; }, Error::StsBadArg,
                  {"stripePoints[9]", "finite"});
    expectRefused([](Refinement& c) { c.stripes[9] = Mat::ones(5, 3, CV_64F); }, Error::StsBadSize,
                  {"stripePoints[9]", "N x 2"});
    expectRefused([](Refinement& c) { c.stripes[9] = c.stripes[9].rowRange(0, 1); }, Error::StsBadSize,
                  {"stripePoints[9]", "at least 2", "given 1"});
    expectRefused([](Refinement& c) { c.stripeSigmas = Mat::ones(3, 1, CV_64F); }, Error::StsBadSize,
                  {"stripeSigmas", "57", "given 3"});
    expectRefused([](Refinement& c) { c.stripeSigmas = Mat::zeros(57, 1, CV_64F); }, Error::StsOutOfRange,
                  {"stripeSigmas[0]", "positive"});
    expectRefused([](Refinement& c) { c.surfaceIds.assign(57, -1); }, Error::StsNoConv, {"stripePoints", "surfaceIds"});
    expectRefused(
        [](Refinement& c)
        {
            for (int i = 0; i < 57; ++i)
                c.surfaceIds[i] = i; // each on a plane of its own
        },
        Error::StsNoConv, {"stripePoints", "surfaceIds"});
}

TEST(ActiveHandEye_RefineRefused, known_points_and_sigmas)
{
    expectRefused([](Refinement& c) { c.objectPoints = Mat::ones(39, 3, CV_64F); }, Error::StsBadSize,
                  {"objectPoints", "40 x 3", "39"});
    expectRefused([](Refinement& c) { c.objectPoints = Mat::ones(60, 2, CV_64F); }, Error::StsBadSize,
                  {"objectPoints", "40 x 3"});
    expectRefused(
        [](Refinement& c)
        {
            c.objectPoints = Mat::ones(40, 3, CV_64F);
            c.objectPoints.at<double>(8, 1) = NaN;
        },
        Error::StsBadArg, {"objectPoints", "three NaN", "point 8"});
    expectRefused(
        [](Refinement& c)
        {
            c.objectPoints = Mat(40, 3, CV_64F, Scalar(NaN));
            c.objectPoints.rowRange(0, 2).setTo(1);
        },
        Error::StsNoConv, {"objectPoints", "3 or more", "given 2"});
    expectRefused([](Refinement& c) { c.pointSigmas.assign(18, Mat::ones(40, 1, CV_64F)); }, Error::StsBadSize,
                  {"pointSigmas", "19", "18"});
    expectRefused([](Refinement& c) { c.pointSigmas.assign(19, Mat::ones(41, 1, CV_64F)); }, Error::StsBadSize,
                  {"pointSigmas[0]", "40", "41"});
    expectRefused([](Refinement& c) { c.pointSigmas.assign(19, Mat::zeros(40, 1, CV_64F)); }, Error::StsOutOfRange,
                  {"pointSigmas[0]", "positive", "point 0"});
}

TEST(ActiveHandEye_RefineRefused, settings)
{
    expectRefused([](Refinement& c) { c.params.flags = 128; }, Error::StsBadArg, {"params.flags", "128"});
    expectRefused([](Refinement& c) { c.params.flags = -1; }, Error::StsBadArg, {"params.flags", "-1"});
    expectRefused([](Refinement& c) { c.params.lensModel = 5; }, Error::StsBadArg, {"params.lensModel", "5"});
    expectRefused([](Refinement& c) { c.params.lensModel = -2; }, Error::StsBadArg, {"params.lensModel", "-2"});
    expectRefused([](Refinement& c) { c.params.pointSigma = 0; }, Error::StsOutOfRange,
                  {"params.pointSigma", "given 0"});
    expectRefused([](Refinement& c) { c.params.stripeSigma = 0; }, Error::StsOutOfRange,
                  {"params.stripeSigma", "given 0"});
    expectRefused([](Refinement& c) { c.params.robotRotationSigma = NaN; }, Error::StsOutOfRange,
                  {"params", "noise levels"});
    expectRefused([](Refinement& c) { c.params.pointSigma = infinity; }, Error::StsOutOfRange,
                  {"params", "noise levels", "inf"});
    expectRefused([](Refinement& c) { c.params.robotTranslationSigma = 0; }, Error::StsBadArg,
                  {"params.robotTranslationSigma", "both 0"});
    expectRefused([](Refinement& c) { c.params.huberThreshold = 0; }, Error::StsOutOfRange,
                  {"params.huberThreshold", "given 0"});
    expectRefused([](Refinement& c) { c.params.rejectThreshold = NaN; }, Error::StsOutOfRange,
                  {"params.rejectThreshold"});
    expectRefused([](Refinement& c) { c.params.maxIterations = 0; }, Error::StsOutOfRange, {"params.maxIterations"});
    expectRefused([](Refinement& c) { c.params.orientationTolerance = -1; }, Error::StsOutOfRange,
                  {"params.orientationTolerance"});
}

TEST(ActiveHandEye_RefineRefused, iterations_that_ran_out_are_told)
{
    const RefineScene scene = RefineScene::noisy();
    Refinement call = scene.call();
    call.params.maxIterations = 1;
    expectError([&] { call.run(); }, Error::StsNoConv, {"no convergence", "maxIterations = 1"});
}

//! Views of these turns and offsets; what the call without a start says.
void expectUndetermined(const vector<Vec3d>& turns, const vector<Vec3d>& offsets, const vector<string>& parts,
                        int flags = 0)
{
    RefineScene scene(1);
    for (const Vec3d& turn : turns)
        scene.addGroup(turn, offsets);
    scene.measure(0.05, 0, 0);
    Refinement call = scene.call();
    call.params.flags = flags;
    expectError([&] { call.run(); }, Error::StsNoConv, parts);
}

TEST(ActiveHandEye_RefineRefused, motions_that_do_not_determine_the_result)
{
    const vector<Vec3d> turns = {Vec3d(0, 0, 0), Vec3d(0.35, 0, 0), Vec3d(0, 0.3, 0.4)};
    expectUndetermined(turns, {Vec3d(0, 0, 0)},
                       {"R_gripper2base", "no two views have equal orientation", "views 0 and 1 come nearest"});
    expectUndetermined({turns[0]}, vector<Vec3d>(6, Vec3d()), {"the gripper did not move", "given one pose"});
    expectUndetermined({turns[0]}, {Vec3d(0, 0, 0), Vec3d(40, 0, 0)},
                       {"t_gripper2base", "parallel", "in base coordinates", "add"});
    expectUndetermined({turns[0]}, {Vec3d(0, 0, 0), Vec3d(50, 5, 20), Vec3d(-10, 45, -25)}, {"coplanar", "add"});
    expectUndetermined({turns[0]}, PointScene::fourTranslations(),
                       {"R_gripper2base", "about two axes that are not parallel"});
}

//! The same with a start: the refinement itself sees what is missing.
TEST(ActiveHandEye_RefineRefused, a_start_does_not_replace_motion)
{
    RefineScene scene(1);
    scene.addGroup(Vec3d(), PointScene::fourTranslations());
    scene.measure(0.05, 0.01, 0.002);
    const auto started = [&]
    {
        Refinement call = scene.call();
        call.K = Mat(scene.K).clone();
        call.R_cam2gripper = Mat(scene.R_cam2gripper).clone();
        call.t_cam2gripper = Mat(scene.t_cam2gripper).clone();
        return call;
    };
    Refinement straight = started();
    for (Mat& R : straight.R) // reports that turn by noise only do not turn
        R = straight.R[0].clone();
    expectError([&] { straight.run(); }, Error::StsNoConv,
                {"t_cam2gripper", "not observed", "about two axes", "REFINE_ALLOW_PARTIAL"});

    RefineScene still(1); // turns only: nothing gives the scale
    for (const Vec3d& turn :
         {Vec3d(0, 0, 0), Vec3d(0.1, 0, 0), Vec3d(0, 0.1, 0), Vec3d(0, 0, 0.2), Vec3d(-0.1, 0, 0.1)})
    {
        still.R.push_back(Mat(rotation(turn) * rotation(Vec3d(3.1, 0.1, 0.05))));
        still.t.push_back(Mat(Vec3d(300, 0, 600)));
    }
    still.measure(0.05, 0.01, 0.002);
    Refinement turned = still.call();
    turned.K = Mat(still.K).clone();
    turned.R_cam2gripper = Mat(still.R_cam2gripper).clone();
    turned.t_cam2gripper = Mat(still.t_cam2gripper).clone();
    expectError([&] { turned.run(); }, Error::StsNoConv, {"t_cam2gripper", "add a translation"});
}

TEST(ActiveHandEye_RefineRefused, too_few_points)
{
    RefineScene scene = RefineScene::noisy(2, 0.1, 0.02, 0.005, 3);
    for (size_t view = 2; view < scene.imagePoints.size(); ++view)
        scene.imagePoints[view].setTo(NaN);
    Refinement call = scene.call();
    call.K = Mat(scene.K).clone();
    call.R_cam2gripper = Mat(scene.R_cam2gripper).clone();
    call.t_cam2gripper = Mat(scene.t_cam2gripper).clone();
    expectError([&] { call.run(); }, Error::StsNoConv, {"imagePoints", "too few points"});
    for (Mat& image : call.imagePoints)
        image.setTo(NaN);
    expectError([&] { call.run(); }, Error::StsNoConv, {"imagePoints", "too few points", "given 0"});
    expectError([&] { scene.refined(); }, Error::StsNoConv, {"too few points"});
}

}} // namespace opencv_test
