// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "point_scene.hpp"

namespace opencv_test { namespace {

struct RotationEstimate
{
    double rms;
    Vec3d t;
    Matx33d covariance;
};

RotationEstimate calibrateRotation(const PointScene& scene, int flags = 0)
{
    RotationEstimate estimate;
    estimate.rms = calibrateHandEyeRotation(scene.R, scene.t, scene.imagePoints, scene.K, scene.dist(),
                                            scene.R_cam2gripper, estimate.t, estimate.covariance, flags);
    return estimate;
}

//! Translations, and turns about one axis of the gripper.
PointScene turningAbout(const Vec3d& axis)
{
    PointScene scene(6);
    for (double angle : {0., 0.3, -0.25})
    {
        const Matx33d start = rotation(Vec3d(3.1, 0.1, 0.05));
        const Matx33d R = start * rotation(axis * angle);
        for (const Vec3d& offset : {Vec3d(0, 0, 0), Vec3d(50, 10, 0)})
        {
            const Matx33d cameraToBase = R * scene.R_cam2gripper;
            const Vec3d camera = Vec3d(300, 0, 0) - cameraToBase * (Vec3d(0, 0, 550) - offset);
            scene.R.push_back(Mat(R));
            scene.t.push_back(Mat(Vec3d(camera - R * scene.t_cam2gripper)));
        }
    }
    scene.project();
    return scene;
}

TEST(ActiveHandEye_Rotation, exact_data_give_the_truth)
{
    PointScene scene = PointScene::complete();
    const RotationEstimate plain = calibrateRotation(scene);
    EXPECT_LE(plain.rms, 1e-8);
    EXPECT_LE(cv::norm(plain.t - scene.t_cam2gripper), 1e-9 * cv::norm(scene.t_cam2gripper));
    const double D[5] = {-0.2, 0.1, 0.001, -0.002, 0.05};
    std::copy(D, D + 5, scene.D);
    scene.project();
    EXPECT_LE(cv::norm(calibrateRotation(scene).t - scene.t_cam2gripper), 1e-9 * cv::norm(scene.t_cam2gripper));
}

TEST(ActiveHandEye_Rotation, eye_to_hand_with_inverted_poses_gives_camera_to_base)
{
    // A fixed camera looks at an object in the gripper: with inverted poses gripper and base change places.
    const PointScene scene = PointScene::complete();
    Mat K, R;
    calibrateHandEyeTranslations(scene.R, scene.t, scene.imagePoints, K, noArray(), R);
    PointScene hand = scene; // the same numbers read as an object carried by the gripper in front of the camera
    for (size_t view = 0; view < scene.R.size(); ++view)
    {
        const Mat base2gripper = scene.R[view].t();
        hand.R[view] = base2gripper; // what such a robot reports: R_gripper2base
        hand.t[view] = -base2gripper * scene.t[view];
    }
    vector<Mat> R_base2gripper, t_base2gripper; // what the user passes
    for (size_t view = 0; view < hand.R.size(); ++view)
    {
        R_base2gripper.push_back(hand.R[view].t());
        t_base2gripper.push_back(-hand.R[view].t() * hand.t[view]);
    }
    Mat K_hand, R_cam2base;
    Vec3d t_cam2base;
    calibrateHandEyeTranslations(R_base2gripper, t_base2gripper, scene.imagePoints, K_hand, noArray(), R_cam2base);
    calibrateHandEyeRotation(R_base2gripper, t_base2gripper, scene.imagePoints, K_hand, noArray(), R_cam2base,
                             t_cam2base);
    // An object point P of the gripper frame is seen at K R_cam2base^T (R_gripper2base P + t_gripper2base - t_cam2base).
    for (int view : {0, 4, 11})
    {
        const Vec3d P = scene.X[2];
        const Vec3d inBase = Matx33d(hand.R[view]) * P + Vec3d(hand.t[view]);
        const Vec3d image = Matx33d(K_hand) * (Matx33d(R_cam2base).t() * (inBase - t_cam2base));
        EXPECT_LE(cv::norm(Vec2d(image[0] / image[2], image[1] / image[2]) - scene.project(P, view)), 1e-6);
    }
}

TEST(ActiveHandEye_Rotation, result_scales_with_the_unit_and_ignores_frame_and_order)
{
    PointScene scene = PointScene::complete();
    scene.project(0.1);
    const RotationEstimate reference = calibrateRotation(scene);
    PointScene metres = scene, moved = scene, reversed = scene;
    const Matx33d turn = rotation(Vec3d(0.3, -1.2, 0.7));
    for (size_t view = 0; view < scene.R.size(); ++view)
    {
        metres.t[view] = scene.t[view] * 0.001;
        moved.R[view] = Mat(turn) * scene.R[view];
        moved.t[view] = Mat(turn) * scene.t[view] + Mat(Vec3d(100, -2000, 50));
        cv::flip(scene.imagePoints[view], reversed.imagePoints[view], 0);
    }
    std::reverse(reversed.R.begin(), reversed.R.end());
    std::reverse(reversed.t.begin(), reversed.t.end());
    std::reverse(reversed.imagePoints.begin(), reversed.imagePoints.end());
    EXPECT_LE(cv::norm(calibrateRotation(metres).t * 1000 - reference.t), 1e-9 * cv::norm(reference.t));
    EXPECT_LE(cv::norm(calibrateRotation(metres).covariance * 1e6 - reference.covariance),
              1e-6 * cv::norm(reference.covariance));
    EXPECT_LE(cv::norm(calibrateRotation(moved).t - reference.t), 1e-9 * cv::norm(reference.t));
    EXPECT_LE(cv::norm(calibrateRotation(reversed).t - reference.t), 1e-9 * cv::norm(reference.t));
}

TEST(ActiveHandEye_Rotation, covariance_predicts_the_error)
{
    const int trials = 200;
    double sums[3] = {0, 0, 0};
    for (int trial = 0; trial < trials; ++trial)
    {
        PointScene scene = PointScene::complete(2000 + trial);
        scene.project(0.1);
        const RotationEstimate estimate = calibrateRotation(scene);
        const Vec3d error = estimate.t - scene.t_cam2gripper;
        for (int k = 0; k < 3; ++k)
            sums[k] += error[k] * error[k] / estimate.covariance(k, k);
    }
    for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(1, std::sqrt(sums[k] / trials), 0.2) << "axis " << k; // 4 standard deviations
}

TEST(ActiveHandEye_Rotation, wrong_matches_and_swapped_poses_are_left_out)
{
    PointScene scene = PointScene::complete(3, 60);
    scene.project(0.1);
    RNG rng(17);
    for (int k = 0; k < 30; ++k)
        scene.imagePoints[rng.uniform(0, 12)].at<double>(rng.uniform(0, 60), 0) += rng.uniform(20., 80.);
    EXPECT_LE(cv::norm(calibrateRotation(scene).t - scene.t_cam2gripper), 0.1);
    std::swap(scene.t[1], scene.t[3]);
    EXPECT_LE(cv::norm(calibrateRotation(scene).t - scene.t_cam2gripper), 0.2);
}

TEST(ActiveHandEye_Rotation, one_axis_is_refused_or_marked)
{
    const Vec3d axis = Vec3d(1, 2, -1) * (1 / std::sqrt(6.));
    const PointScene scene = turningAbout(axis);
    expectError([&] { calibrateRotation(scene); }, Error::StsNoConv,
                {"all rotation axes are parallel", "(0.41, 0.82, -0.41) in the gripper frame",
                 "base coordinates: add a turn", "ROTATION_ALLOW_PARTIAL"});
    const RotationEstimate partial = calibrateRotation(scene, ROTATION_ALLOW_PARTIAL);
    const Vec3d across = scene.t_cam2gripper - axis * axis.dot(scene.t_cam2gripper);
    EXPECT_LE(cv::norm(partial.t - across), 1e-7);
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            EXPECT_EQ(std::copysign(infinity, axis[i] * axis[j]), partial.covariance(i, j));
    const RotationEstimate simple = calibrateRotation(turningAbout(Vec3d(0, 0, 1)), ROTATION_ALLOW_PARTIAL);
    EXPECT_TRUE(std::isinf(simple.covariance(2, 2)));
    EXPECT_LE(simple.covariance(0, 0), 1e-12);
    EXPECT_LE(std::abs(simple.covariance(0, 2)), 1e-12);
}

TEST(ActiveHandEye_Rotation, motion_that_cannot_answer_is_refused)
{
    PointScene straight(1);
    straight.addGroup(Vec3d(), PointScene::fourTranslations());
    straight.project();
    for (int flags : {0, int(ROTATION_ALLOW_PARTIAL)})
        expectError([&] { calibrateRotation(straight, flags); }, Error::StsNoConv,
                    {"no change of orientation", "two axes that are not parallel", "at most 0.000 deg"});

    PointScene still(1);
    for (const Vec3d& turn : {Vec3d(0, 0, 0), Vec3d(0.1, 0, 0), Vec3d(0, 0.1, 0), Vec3d(0, 0, 0.2)})
    {
        still.R.push_back(Mat(rotation(turn) * rotation(Vec3d(3.1, 0.1, 0.05))));
        still.t.push_back(Mat(Vec3d(300, 0, 600)));
    }
    still.project();
    expectError([&] { calibrateRotation(still); }, Error::StsNoConv,
                {"the gripper only turned", "scale", "add a translation"});
    RNG rng(2);
    for (Mat& t : still.t) // the robot repeats to 0.02 mm: that is no translation either
        t += Mat(Vec3d(rng.gaussian(0.02), rng.gaussian(0.02), rng.gaussian(0.02)));
    EXPECT_THROW(calibrateRotation(still), cv::Exception);

    PointScene unlinked = PointScene::complete();
    for (size_t view = 5; view < unlinked.imagePoints.size(); ++view)
        unlinked.imagePoints[view].setTo(std::numeric_limits<double>::quiet_NaN());
    expectError([&] { calibrateRotation(unlinked); }, Error::StsNoConv,
                {"too few points in common", "different orientation", "given 0 out of 30 points"});
}

TEST(ActiveHandEye_Rotation, wrong_input_is_named)
{
    const PointScene scene = PointScene::complete();
    const auto call = [&](const Mat& K, const Mat& R, int flags)
    {
        Mat t;
        calibrateHandEyeRotation(scene.R, scene.t, scene.imagePoints, K, noArray(), R, t, noArray(), flags);
    };
    expectError([&] { call(Mat(), Mat(scene.R_cam2gripper), 0); }, Error::StsBadSize, {"cameraMatrix", "given none"});
    expectError([&] { call(Mat(scene.K), 1.01 * Mat(scene.R_cam2gripper), 0); }, Error::StsBadArg,
                {"R_cam2gripper", "needed a rotation"});
    expectError([&] { call(Mat(scene.K), Mat(), 0); }, Error::StsBadSize, {"R_cam2gripper"});
    expectError([&] { call(Mat(scene.K), Mat(scene.R_cam2gripper), 4); }, Error::StsBadArg, {"flags", "given 4"});
}

}} // namespace opencv_test
