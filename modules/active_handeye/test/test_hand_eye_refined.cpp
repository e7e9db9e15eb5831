// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "hand_eye_scene.hpp"

namespace opencv_test { namespace {

const PoseNoise cameraNoise = {0.002, 0.005}, robotNoise = {0.001, 0.001};

struct Refined
{
    double deviation;
    RigidMotion X;
    HandEyeSummary summary;
};

Refined calibrate(const HandEyeScene& scene, const HandEyeParams& params = HandEyeParams())
{
    Refined refined;
    Mat R, t;
    refined.deviation = calibrateHandEyeExtended(scene.R_gripper2base, scene.t_gripper2base, scene.R_target2cam,
                                                 scene.t_target2cam, R, t, refined.summary, params);
    refined.X = RigidMotion{R, t};
    return refined;
}

HandEyeParams trueLevels()
{
    HandEyeParams params;
    params.targetRotationSigma = cameraNoise.rotation;
    params.targetTranslationSigma = cameraNoise.translation;
    params.robotRotationSigma = robotNoise.rotation;
    params.robotTranslationSigma = robotNoise.translation;
    return params;
}

//! true R = exp(error) R_cam2gripper, true t = t_cam2gripper + error.
Vec6d errorOf(const Refined& refined, const RigidMotion& truth)
{
    const Vec3d w = rotationVector(truth.R * refined.X.R.t()), t = truth.t - refined.X.t;
    return Vec6d(w[0], w[1], w[2], t[0], t[1], t[2]);
}

//! Of all 95 % intervals, the share that holds the truth.
double coverage(int views, int trials, const HandEyeParams& params, double* meanSquare)
{
    int held = 0;
    *meanSquare = 0;
    for (int trial = 0; trial < trials; ++trial)
    {
        HandEyeScene scene(1000 + trial, views);
        scene.addNoise(cameraNoise, robotNoise);
        const Refined refined = calibrate(scene, params);
        const Vec6d error = errorOf(refined, scene.cam2gripper);
        const Mat intervals = refined.summary.intervals95, deviations = refined.summary.standardDeviations;
        for (int i = 0; i < 6; ++i)
        {
            held += std::abs(error[i]) <= 0.5 * (intervals.at<double>(i, 1) - intervals.at<double>(i, 0));
            *meanSquare += std::pow(error[i] / deviations.at<double>(i), 2) / (6 * trials);
        }
    }
    return held / (6. * trials);
}

TEST(ActiveHandEye_HandEyeExtended, covariance_is_that_of_the_errors_with_given_levels)
{
    double meanSquare;
    EXPECT_NEAR(0.95, coverage(10, 150, trueLevels(), &meanSquare), 0.03);
    EXPECT_NEAR(1, meanSquare, 0.25);
}

TEST(ActiveHandEye_HandEyeExtended, intervals_hold_the_truth_with_estimated_levels)
{
    double meanSquare;
    EXPECT_GE(coverage(10, 100, HandEyeParams(), &meanSquare), 0.90);
    EXPECT_GE(coverage(4, 100, HandEyeParams(), &meanSquare), 0.88);
}

TEST(ActiveHandEye_HandEyeExtended, chi_square_of_given_levels_has_its_distribution)
{
    double mean = 0;
    const int trials = 100, views = 8;
    for (int trial = 0; trial < trials; ++trial)
    {
        HandEyeScene scene(trial, views);
        scene.addNoise(cameraNoise, robotNoise);
        const HandEyeSummary summary = calibrate(scene, trueLevels()).summary;
        EXPECT_EQ(6 * views - 12, summary.chiSquareDof);
        mean += summary.chiSquare / trials;
    }
    EXPECT_NEAR(6 * views - 12, mean, 4 * std::sqrt(2. * (6 * views - 12) / trials));

    HandEyeScene scene(1);
    scene.addNoise(PoseNoise{0.02, 0.05}, robotNoise);
    const HandEyeSummary summary = calibrate(scene, trueLevels()).summary;
    EXPECT_FALSE(summary.usable);
    EXPECT_NE(string::npos, summary.message.find("do not fit the noise levels given")) << summary.message;
}

TEST(ActiveHandEye_HandEyeExtended, noise_levels_are_found_and_told_apart)
{
    HandEyeScene cameraErrs(1, 60), robotErrs(1, 60);
    cameraErrs.addNoise(cameraNoise, PoseNoise{0, 0});
    robotErrs.addNoise(PoseNoise{0, 0.001}, PoseNoise{0.002, 0});
    const Mat camera = calibrate(cameraErrs).summary.noiseLevels, robot = calibrate(robotErrs).summary.noiseLevels;
    EXPECT_NEAR(0.002, camera.at<double>(0, 0), 0.0006);
    EXPECT_NEAR(0.005, camera.at<double>(1, 0), 0.001);
    EXPECT_LE(camera.at<double>(2, 0), 0.0008);
    EXPECT_NEAR(0.002, robot.at<double>(2, 0), 0.0006);
    EXPECT_NEAR(0.001, robot.at<double>(1, 0), 0.0005);
    EXPECT_LE(robot.at<double>(0, 0), 0.0008);
    for (const Mat& levels : {camera, robot})
        for (int k = 0; k < 3; ++k)
        {
            EXPECT_LE(levels.at<double>(k, 1), levels.at<double>(k, 0));
            EXPECT_GE(levels.at<double>(k, 2), levels.at<double>(k, 0));
            EXPECT_EQ(1, levels.at<double>(k, 3));
        }
    EXPECT_EQ(0, camera.at<double>(3, 3));
}

TEST(ActiveHandEye_HandEyeExtended, wrong_views_are_left_out_and_named)
{
    HandEyeScene scene(2, 12);
    scene.addNoise(cameraNoise, robotNoise);
    const Refined clean = calibrate(scene);
    EXPECT_TRUE(clean.summary.rejectedViews.empty());
    std::swap(scene.R_target2cam[3], scene.R_target2cam[8]);
    std::swap(scene.t_target2cam[3], scene.t_target2cam[8]);
    scene.t_gripper2base[5] = scene.t_gripper2base[5] + Mat(Vec3d(0.3, 0, 0));
    const Refined refined = calibrate(scene);
    EXPECT_EQ((vector<int>{3, 5, 8}), refined.summary.rejectedViews);
    ASSERT_EQ(3u, refined.summary.culprits.size());
    EXPECT_NE(string::npos, refined.summary.culprits[1].find("view 5: its poses of gripper and target contradict"));
    EXPECT_NE(string::npos, refined.summary.message.find("3 of 12 views contradict the others"));
    EXPECT_LE(cv::norm(refined.X.t - scene.cam2gripper.t), 4 * refined.deviation);
    EXPECT_LE(refined.summary.viewPValues.at<double>(5, 1), 1e-6);
}

TEST(ActiveHandEye_HandEyeExtended, good_views_are_kept)
{
    int rejected = 0;
    for (int trial = 0; trial < 100; ++trial)
    {
        HandEyeScene scene(trial, 6);
        scene.addNoise(cameraNoise, robotNoise);
        rejected += int(calibrate(scene).summary.rejectedViews.size());
    }
    EXPECT_LE(rejected, 3);
}

TEST(ActiveHandEye_HandEyeExtended, result_does_not_depend_on_unit_and_base_frame)
{
    HandEyeScene scene(3);
    scene.addNoise(cameraNoise, robotNoise);
    HandEyeScene millimetres = scene, moved = scene;
    const RigidMotion base = {rotation(Vec3d(0.3, -1.2, 0.7)), Vec3d(5, -20, 3)};
    for (size_t i = 0; i < scene.R_gripper2base.size(); ++i)
    {
        millimetres.t_gripper2base[i] = 1000 * scene.t_gripper2base[i];
        millimetres.t_target2cam[i] = 1000 * scene.t_target2cam[i];
        const RigidMotion pose = base * RigidMotion{scene.R_gripper2base[i], scene.t_gripper2base[i]};
        moved.R_gripper2base[i] = Mat(pose.R);
        moved.t_gripper2base[i] = Mat(pose.t);
    }
    const Refined a = calibrate(scene), b = calibrate(millimetres), c = calibrate(moved);
    EXPECT_LE(cv::norm(a.X.R - b.X.R), 1e-9);
    EXPECT_LE(cv::norm(a.X.t - b.X.t * 0.001), 1e-9);
    EXPECT_NEAR(1000 * a.deviation, b.deviation, 1e-6 * b.deviation);
    EXPECT_LE(cv::norm(a.X.t - c.X.t), 1e-9);
    EXPECT_NEAR(a.deviation, c.deviation, 1e-6 * a.deviation);
}

TEST(ActiveHandEye_HandEyeExtended, target_and_residuals_belong_to_the_result)
{
    HandEyeScene scene(4);
    scene.addNoise(cameraNoise, robotNoise);
    const Refined refined = calibrate(scene);
    const RigidMotion target = {refined.summary.R_target2base, Vec3d(refined.summary.t_target2base)};
    EXPECT_LE(cv::norm(target.t - scene.target2base.t), 0.05);
    for (int view = 0; view < 10; ++view)
    {
        const RigidMotion gripper = {scene.R_gripper2base[view], scene.t_gripper2base[view]};
        const RigidMotion seen = (gripper * refined.X).inverse() * target;
        const Vec3d w = rotationVector(seen.R * Matx33d(scene.R_target2cam[view]).t()),
                    t = seen.t - Vec3d(scene.t_target2cam[view]);
        const Mat expected = (Mat_<double>(1, 6) << w[0], w[1], w[2], t[0], t[1], t[2]);
        EXPECT_LE(cv::norm(refined.summary.residuals.row(view) - expected), 1e-9);
    }
}

TEST(ActiveHandEye_HandEyeExtended, noise_that_leaves_the_result_open_is_refused)
{
    HandEyeScene scene(7, 8, 0.2, 0.4);
    scene.addNoise(PoseNoise{0.002, 0.005}, PoseNoise{0, 0});
    expectError([&] { calibrate(scene); }, Error::StsNoConv, {"R_gripper2base"});
}

TEST(ActiveHandEye_HandEyeExtended, wrong_levels_are_refused_by_name)
{
    const HandEyeScene scene(1);
    HandEyeParams params = trueLevels();
    params.robotRotationSigma = std::numeric_limits<double>::quiet_NaN();
    expectError([&] { calibrate(scene, params); }, Error::StsOutOfRange,
                {"params.robotRotationSigma: needed a finite"});
    params = trueLevels();
    params.targetRotationSigma = params.robotRotationSigma = 0;
    expectError([&] { calibrate(scene, params); }, Error::StsOutOfRange,
                {"params.targetRotationSigma, params.robotRotationSigma: needed one that is not 0"});
    params = HandEyeParams();
    params.robotTranslationSigma = -1;
    expectError([&] { calibrate(scene, params); }, Error::StsBadArg,
                {"params.robotTranslationSigma: needed 0 or more"});
}

}} // namespace opencv_test
