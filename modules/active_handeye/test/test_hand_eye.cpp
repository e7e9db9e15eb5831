// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "hand_eye_scene.hpp"

#include <functional>

namespace opencv_test { namespace {

RigidMotion calibrate(const HandEyeScene& scene, int method)
{
    Mat R, t;
    calibrateHandEye(scene.R_gripper2base, scene.t_gripper2base, scene.R_target2cam, scene.t_target2cam, R, t,
                     HandEyeMethod(method));
    return RigidMotion{R, t};
}

double rotationError(const RigidMotion& a, const RigidMotion& b)
{
    return angleDeg(a.R, b.R) * CV_PI / 180;
}

class ActiveHandEye_HandEye : public ::testing::TestWithParam<int>
{
protected:
    void expectTruth(const HandEyeScene& scene, double tolerance) const
    {
        const RigidMotion X = calibrate(scene, GetParam());
        EXPECT_LE(rotationError(X, scene.cam2gripper), tolerance);
        EXPECT_LE(cv::norm(X.t - scene.cam2gripper.t), tolerance);
        EXPECT_NEAR(1, cv::determinant(X.R), 1e-12);
    }
};

TEST_P(ActiveHandEye_HandEye, exact_poses_give_the_truth)
{
    for (int trial = 0; trial < 100; ++trial)
        expectTruth(HandEyeScene(trial), 1e-8);
}

TEST_P(ActiveHandEye_HandEye, inverted_robot_poses_give_the_camera_beside_the_robot)
{
    for (int trial = 0; trial < 100; ++trial)
    {
        HandEyeScene scene(trial);
        const RigidMotion cam2base = scene.cam2gripper, target2gripper = scene.target2base;
        for (size_t i = 0; i < scene.R_gripper2base.size(); ++i)
        {
            const RigidMotion gripper2base = {scene.R_gripper2base[i], scene.t_gripper2base[i]};
            const RigidMotion seen = cam2base.inverse() * gripper2base * target2gripper;
            scene.R_target2cam[i] = Mat(seen.R);
            scene.t_target2cam[i] = Mat(seen.t);
            scene.R_gripper2base[i] = Mat(gripper2base.inverse().R);
            scene.t_gripper2base[i] = Mat(gripper2base.inverse().t);
        }
        expectTruth(scene, 1e-8);
    }
}

// The noise and, for the largest error of 100 trials, two thirds of the tolerance of OpenCV's test.
TEST_P(ActiveHandEye_HandEye, noisy_poses_give_the_truth_within_tolerance)
{
    const PoseNoise camera = {0.002, 0.005}, robot = {0.001, 0.001};
    double largestAngle = 0, largestDistance = 0;
    for (int trial = 0; trial < 100; ++trial)
    {
        HandEyeScene scene(trial);
        scene.addNoise(camera, robot);
        const RigidMotion X = calibrate(scene, GetParam());
        largestAngle = std::max(largestAngle, rotationError(X, scene.cam2gripper));
        largestDistance = std::max(largestDistance, cv::norm(X.t - scene.cam2gripper.t));
    }
    EXPECT_LE(largestAngle, GetParam() == CALIB_HAND_EYE_REFINED ? 0.007 : 0.0135);
    EXPECT_LE(largestDistance, GetParam() == CALIB_HAND_EYE_REFINED ? 0.03 : 0.047);
    EXPECT_GE(largestDistance, 0.005) << "the noise has no effect";
}

TEST_P(ActiveHandEye_HandEye, large_turns_give_the_truth)
{
    for (int trial = 0; trial < 100; ++trial)
        if (GetParam() != CALIB_HAND_EYE_TSAI)
            expectTruth(HandEyeScene(trial, 4, 60, 170), 1e-8);
}

TEST_P(ActiveHandEye_HandEye, small_turns_give_the_truth_or_are_refused_by_name)
{
    HandEyeScene scene(5, 10, 1, 4);
    if (GetParam() == CALIB_HAND_EYE_TSAI)
        expectError([&] { calibrate(scene, GetParam()); }, Error::StsNoConv,
                    {"CALIB_HAND_EYE_TSAI needs two or more turns of 17 to 116 deg, given 0", "use another method"});
    else
        expectTruth(scene, 1e-8);
}

TEST_P(ActiveHandEye_HandEye, camera_turned_by_180_degrees_gives_the_truth_or_is_refused_by_name)
{
    HandEyeScene scene(5, 0);
    scene.cam2gripper.R = Matx33d(1, 0, 0, 0, -1, 0, 0, 0, -1);
    for (int i = 0; i < 10; ++i)
        scene.addView(scene.draw(5, 45, 0.5, 1.5));
    if (GetParam() == CALIB_HAND_EYE_TSAI)
        expectError([&] { calibrate(scene, GetParam()); }, Error::StsNoConv, {"not turned by 180 deg"});
    else
        expectTruth(scene, 1e-8);
}

TEST_P(ActiveHandEye_HandEye, every_layout_of_the_input_gives_the_same)
{
    const HandEyeScene scene(3);
    const RigidMotion X = calibrate(scene, GetParam());
    HandEyeScene rows = scene, vectors = scene, floats = scene;
    for (size_t i = 0; i < scene.t_gripper2base.size(); ++i)
    {
        rows.t_gripper2base[i] = scene.t_gripper2base[i].t();
        rows.t_target2cam[i] = scene.t_target2cam[i].t();
        for (vector<Mat>* list :
             {&floats.R_gripper2base, &floats.t_gripper2base, &floats.R_target2cam, &floats.t_target2cam})
        {
            Mat single;
            (*list)[i].convertTo(single, CV_32F);
            (*list)[i] = single;
        }
    }
    for (vector<Mat>* list : {&vectors.R_gripper2base, &vectors.R_target2cam})
        for (Mat& R : *list)
            R = Mat(rotationVector(R));
    EXPECT_EQ(0, cv::norm(calibrate(rows, GetParam()).t - X.t));
    EXPECT_LE(cv::norm(calibrate(vectors, GetParam()).t - X.t), 1e-9);
    EXPECT_LE(cv::norm(calibrate(floats, GetParam()).t - X.t), 1e-5);
}

TEST_P(ActiveHandEye_HandEye, motions_that_cannot_answer_are_refused_with_what_is_missing)
{
    HandEyeScene scene(4, 0);
    const auto refused = [&](const vector<string>& parts)
    {
        expectError([&] { calibrate(scene, GetParam()); }, Error::StsNoConv, parts);
        scene.clearViews();
    };
    for (int i = 0; i < 6; ++i)
        scene.addView(RigidMotion{Matx33d::eye(), scene.draw(0, 1, 0.1, 1).t});
    refused({"R_gripper2base: needed turns", "translations alone"});
    for (int i = 0; i < 6; ++i)
        scene.addView(RigidMotion{Matx33d::eye(), Vec3d(1, 2, 3)});
    refused({"R_gripper2base: needed turns", "no motion at all"});
    for (int i = 0; i < 6; ++i)
        scene.addView(RigidMotion{rotation(Vec3d(0, 0.3 * i, 0)), scene.draw(0, 1, 0.1, 1).t});
    refused({"R_gripper2base: needed turns", "about one axis, (0.00, 1.00, 0.00) in the gripper frame", "such as"});
}

TEST_P(ActiveHandEye_HandEye, poses_that_contradict_each_other_are_refused)
{
    const HandEyeScene scene(6);
    HandEyeScene inverted = scene, blind = scene, shifted = scene, millimetres = scene;
    for (size_t i = 0; i < scene.R_gripper2base.size(); ++i)
    {
        inverted.R_gripper2base[i] = scene.R_gripper2base[i].t();
        inverted.t_gripper2base[i] = -scene.R_gripper2base[i].t() * scene.t_gripper2base[i];
        blind.R_target2cam[i] = scene.R_target2cam[0];
        millimetres.t_gripper2base[i] = 1000 * scene.t_gripper2base[i];
    }
    std::rotate(shifted.R_target2cam.begin(), shifted.R_target2cam.begin() + 1, shifted.R_target2cam.end());
    std::rotate(shifted.t_target2cam.begin(), shifted.t_target2cam.begin() + 1, shifted.t_target2cam.end());
    expectError([&] { calibrate(inverted, GetParam()); }, Error::StsNoConv, {"contradict", "are inverted"});
    expectError([&] { calibrate(shifted, GetParam()); }, Error::StsNoConv, {"contradict"});
    expectError([&] { calibrate(blind, GetParam()); }, Error::StsNoConv, {"R_target2cam: needed turns"});
    expectError([&] { calibrate(millimetres, GetParam()); }, Error::StsBadArg,
                {"t_target2cam: millimetres and metres seem to be mixed", "multiplied by 1000"});
}

INSTANTIATE_TEST_CASE_P(Methods, ActiveHandEye_HandEye,
                        ::testing::Values(int(CALIB_HAND_EYE_TSAI), int(CALIB_HAND_EYE_PARK),
                                          int(CALIB_HAND_EYE_HORAUD), int(CALIB_HAND_EYE_ANDREFF),
                                          int(CALIB_HAND_EYE_DANIILIDIS), int(CALIB_HAND_EYE_REFINED)));

TEST(ActiveHandEye_HandEyeInput, wrong_input_is_refused_by_name)
{
    const HandEyeScene scene(1);
    const auto refused = [&](int code, const vector<string>& parts, const std::function<void(HandEyeScene&)>& spoil)
    {
        HandEyeScene spoilt = scene;
        spoil(spoilt);
        expectError([&] { calibrate(spoilt, CALIB_HAND_EYE_TSAI); }, code, parts);
    };
    expectError([&] { calibrate(scene, 99); }, Error::StsOutOfRange, {"method: needed", "given 99"});
    refused(Error::StsBadSize, {"t_gripper2base: needed one translation", "given 9"},
            [](HandEyeScene& s) { s.t_gripper2base.pop_back(); });
    refused(Error::StsBadSize, {"t_target2cam: needed one translation", "given 9"},
            [](HandEyeScene& s) { s.t_target2cam.pop_back(); });
    refused(Error::StsBadSize, {"R_target2cam: needed one rotation for each of the 10", "given 9"},
            [](HandEyeScene& s)
            {
                s.R_target2cam.pop_back();
                s.t_target2cam.pop_back();
            });
    refused(Error::StsBadArg, {"R_target2cam[3]: needed a rotation", "left-handed"},
            [](HandEyeScene& s) { s.R_target2cam[3] = -s.R_target2cam[3]; });
    refused(Error::StsBadArg, {"R_gripper2base[2]: needed a rotation"},
            [](HandEyeScene& s) { s.R_gripper2base[2] = 2 * s.R_gripper2base[2]; });
    refused(Error::StsBadArg, {"t_target2cam[1]: needed finite numbers"},
            [](HandEyeScene& s) { s.t_target2cam[1] = Mat(Vec3d(0, std::numeric_limits<double>::quiet_NaN(), 0)); });
    refused(Error::StsBadSize, {"t_gripper2base[0]: needed 3 numbers"},
            [](HandEyeScene& s) { s.t_gripper2base[0] = Mat(Vec4d(1, 2, 3, 4)); });
    refused(Error::StsBadSize, {"R_gripper2base: needed at least 3 views, given 0"},
            [](HandEyeScene& s) { s.clearViews(); });
}

}} // namespace opencv_test
