// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "translations_scene.hpp"

namespace opencv_test { namespace {

using namespace translations;

void expectExact(const PointScene& scene, const Estimate& estimate, double tolerance = 1e-9)
{
    EXPECT_LE(estimate.rms, tolerance * 100);
    EXPECT_LE(cv::norm(estimate.K - scene.K, NORM_INF), tolerance * scene.K(0, 0));
    EXPECT_LE(cv::norm(estimate.R - scene.R_cam2gripper, NORM_INF), tolerance);
}

TEST(ActiveHandEye_Translations, exact_data_give_the_truth)
{
    const PointScene scene = PointScene::complete();
    expectExact(scene, calibrate(scene));
    expectExact(scene, calibrate(scene, TRANSLATIONS_FOE), 1e-7); // directions alone amplify rounding
    expectExact(scene, calibrate(scene, TRANSLATIONS_METRIC, TRANSLATIONS_FIX_K, Mat(scene.K)));
    expectExact(scene, calibrate(scene, TRANSLATIONS_FOE, TRANSLATIONS_FIX_K, Mat(scene.K)), 1e-7);
}

TEST(ActiveHandEye_Translations, three_translations_suffice_for_metric)
{
    vector<Vec3d> offsets = PointScene::fourTranslations();
    offsets.pop_back();
    const PointScene scene = oneGroup(offsets);
    expectExact(scene, calibrate(scene));
}

TEST(ActiveHandEye_Translations, two_translations_suffice_with_known_K)
{
    const PointScene scene = oneGroup(vector<Vec3d>{Vec3d(), Vec3d(50, 5, 0), Vec3d(-10, 45, 0)});
    expectExact(scene, calibrate(scene, TRANSLATIONS_METRIC, TRANSLATIONS_FIX_K, Mat(scene.K)));
    expectExact(scene, calibrate(scene, TRANSLATIONS_FOE, TRANSLATIONS_FIX_K, Mat(scene.K)), 1e-7);
}

TEST(ActiveHandEye_Translations, constrained_cameras_are_met_exactly)
{
    PointScene scene = PointScene::complete();
    scene.K(0, 1) = 0;
    scene.project();
    expectExact(scene, calibrate(scene, TRANSLATIONS_METRIC, TRANSLATIONS_ZERO_SKEW));
    scene.K(1, 1) = scene.K(0, 0);
    scene.project();
    expectExact(scene, calibrate(scene, TRANSLATIONS_METRIC, TRANSLATIONS_SQUARE_PIXELS));
    scene.project(0.1);
    const Estimate square = calibrate(scene, TRANSLATIONS_METRIC, TRANSLATIONS_SQUARE_PIXELS);
    EXPECT_EQ(square.K(0, 0), square.K(1, 1));
    EXPECT_EQ(0, square.K(0, 1));
    EXPECT_EQ(0, cv::norm(square.covariance.row(4)));
    EXPECT_GT(square.covariance.at<double>(0, 0), 0);
}

TEST(ActiveHandEye_Translations, known_distortion_is_removed)
{
    PointScene scene = PointScene::complete();
    const double D[5] = {-0.2, 0.1, 0.001, -0.002, 0.05};
    std::copy(D, D + 5, scene.D);
    scene.project();
    expectExact(scene, calibrate(scene, TRANSLATIONS_METRIC, 0, Mat(), scene.dist()), 1e-8);
    expectExact(scene, calibrate(scene, TRANSLATIONS_METRIC, TRANSLATIONS_FIX_K, Mat(scene.K), scene.dist()));
    const Matx33d guess(1000, 0, 320, 0, 1000, 240, 0, 0, 1);
    expectExact(scene, calibrate(scene, TRANSLATIONS_METRIC, 0, Mat(guess), scene.dist()), 1e-8);
}

TEST(ActiveHandEye_Translations, reported_orientation_differences_within_the_tolerance_are_used)
{
    PointScene scene(4);
    scene.t_cam2gripper = Vec3d(); // its lever arm is not known to this step
    RNG rng(8);
    for (const Vec3d& offset : PointScene::fourTranslations())
        scene.addGroup(Vec3d(rng.gaussian(1), rng.gaussian(1), rng.gaussian(1)) * 1e-4, vector<Vec3d>(1, offset));
    scene.project();
    expectExact(scene, calibrate(scene));
}

TEST(ActiveHandEye_Translations, points_may_be_missing)
{
    PointScene scene = PointScene::complete();
    const double nan = std::numeric_limits<double>::quiet_NaN();
    RNG rng(5);
    for (Mat& pixels : scene.imagePoints)
        for (int j = 0; j < pixels.rows; ++j)
            if (rng.uniform(0., 1.) < 0.4)
                pixels.row(j).setTo(nan);
    expectExact(scene, calibrate(scene));
}

TEST(ActiveHandEye_Translations, result_does_not_depend_on_unit_base_frame_or_order)
{
    PointScene scene = PointScene::complete();
    scene.project(0.1);
    const Estimate reference = calibrate(scene);
    const auto expectSame = [&](const PointScene& other)
    {
        const Estimate estimate = calibrate(other);
        EXPECT_LE(cv::norm(estimate.K - reference.K, NORM_INF), 1e-9 * reference.K(0, 0));
        EXPECT_LE(cv::norm(estimate.R - reference.R, NORM_INF), 1e-9);
        EXPECT_LE(cv::norm(estimate.covariance - reference.covariance), 1e-6 * cv::norm(reference.covariance));
        EXPECT_NEAR(reference.rms, estimate.rms, 1e-9);
    };
    PointScene metres = scene, moved = scene, reordered = scene;
    const Matx33d turn = rotation(Vec3d(0.3, -1.2, 0.7));
    const int points = int(scene.X.size()), views = int(scene.R.size());
    for (int view = 0; view < views; ++view)
    {
        metres.t[view] = scene.t[view] * 0.001;
        moved.R[view] = Mat(turn) * scene.R[view];
        moved.t[view] = Mat(turn) * scene.t[view] + Mat(Vec3d(100, -2000, 50));
        const int from = (view * 5 + 3) % views; // 5 and 12 have no common divisor
        reordered.R[view] = scene.R[from];
        reordered.t[view] = scene.t[from];
        reordered.imagePoints[view] = Mat(points, 2, CV_64F);
        for (int j = 0; j < points; ++j)
            scene.imagePoints[from].row((7 * j + 2) % points).copyTo(reordered.imagePoints[view].row(j));
    }
    expectSame(metres);
    expectSame(moved);
    expectSame(reordered);
}

TEST(ActiveHandEye_Translations, all_layouts_of_poses_and_points_give_the_same)
{
    PointScene scene = PointScene::complete();
    scene.project(0.1);
    const Estimate reference = calibrate(scene);
    vector<Mat> rotations;
    vector<Vec3d> translations;
    vector<vector<Point2d>> points;
    Mat stacked(vector<int>{int(scene.R.size()), int(scene.X.size()), 2}, CV_64F);
    for (size_t view = 0; view < scene.R.size(); ++view)
    {
        Mat wide = Mat::zeros(3, 5, CV_64F);
        rotations.push_back(wide.colRange(1, 4));
        scene.R[view].copyTo(rotations.back());
        translations.push_back(Vec3d(scene.t[view]));
        points.push_back(vector<Point2d>());
        for (int j = 0; j < scene.imagePoints[view].rows; ++j)
        {
            const Mat row = scene.imagePoints[view].row(j);
            points.back().push_back(Point2d(row.at<double>(0), row.at<double>(1)));
            stacked.ptr<double>(int(view), j)[0] = row.at<double>(0);
            stacked.ptr<double>(int(view), j)[1] = row.at<double>(1);
        }
        scene.t[view] = scene.t[view].reshape(1, 1); // 1 x 3
    }
    Mat K, R;
    const auto expectSame = [&]
    {
        EXPECT_LE(cv::norm(Matx33d(K) - reference.K, NORM_INF), 1e-12);
        EXPECT_LE(cv::norm(Matx33d(R) - reference.R, NORM_INF), 1e-14);
        K.release();
    };
    calibrateHandEyeTranslations(rotations, translations, points, K, noArray(), R);
    expectSame();
    calibrateHandEyeTranslations(scene.R, scene.t, stacked, K, noArray(), R);
    expectSame();
}

//! Errors divided by their predicted standard deviations have RMS 1.
TEST(ActiveHandEye_Translations, covariance_predicts_the_error)
{
    const int trials = 200;
    double sums[8] = {0, 0, 0, 0, 0, 0, 0, 0};
    for (int trial = 0; trial < trials; ++trial)
    {
        const PointScene scene = oneGroup(PointScene::fourTranslations(), 1000 + trial, 0.1);
        const Estimate estimate = calibrate(scene);
        const Matx33d dK = scene.K - estimate.K, dR = scene.R_cam2gripper * estimate.R.t();
        const double errors[8] = {dK(0, 0),
                                  dK(1, 1),
                                  dK(0, 2),
                                  dK(1, 2),
                                  dK(0, 1),
                                  (dR(2, 1) - dR(1, 2)) / 2,
                                  (dR(0, 2) - dR(2, 0)) / 2,
                                  (dR(1, 0) - dR(0, 1)) / 2};
        for (int k = 0; k < 8; ++k)
            sums[k] += errors[k] * errors[k] / estimate.covariance.at<double>(k, k);
    }
    for (int k = 0; k < 8; ++k)
        EXPECT_NEAR(1, std::sqrt(sums[k] / trials), 0.2) << "parameter " << k; // 4 standard deviations
}

//! The robot turns every view by 0.005 deg more or less than it says: 0.12 px, common to all points of the view.
TEST(ActiveHandEye_Translations, jitter_of_the_robot_is_told_from_image_noise)
{
    const int trials = 20;
    const double jitter = 0.005 * CV_PI / 180;
    double squaredAngle = 0, squaredFocal = 0, normalised = 0;
    for (int trial = 0; trial < trials; ++trial)
    {
        PointScene scene = PointScene::complete(3000 + trial, 300);
        const vector<Mat> reported = scene.R;
        for (Mat& R : scene.R)
        {
            Vec3d w;
            for (int k = 0; k < 3; ++k)
                w[k] = scene.rng.gaussian(jitter);
            R = Mat(R * Mat(rotation(w)));
        }
        scene.project(0.05);
        scene.R = reported;
        const Estimate estimate = calibrate(scene);
        EXPECT_LE(estimate.rms, 0.08);
        squaredAngle += std::pow(angleDeg(estimate.R, scene.R_cam2gripper), 2) / trials;
        squaredFocal += std::pow(estimate.K(0, 0) - scene.K(0, 0), 2) / trials;
        normalised += std::pow(estimate.K(0, 2) - scene.K(0, 2), 2) / estimate.covariance.at<double>(2, 2) / trials;
    }
    // Taken for independent noise of every point it gives 0.11 deg, and errors of cx six times larger than predicted.
    EXPECT_LE(std::sqrt(squaredAngle), 0.04);
    EXPECT_LE(std::sqrt(squaredFocal), 2.0);
    EXPECT_LE(std::sqrt(normalised), 2.0);
}

TEST(ActiveHandEye_Translations, wrong_matches_are_left_out)
{
    PointScene scene = PointScene::complete(3, 60);
    scene.project(0.1);
    const Estimate clean = calibrate(scene);
    RNG rng(17);
    for (int k = 0; k < 30; ++k)
    {
        Mat row = scene.imagePoints[rng.uniform(0, 10)].row(rng.uniform(0, 60));
        row.at<double>(0) += rng.uniform(-80., 80.);
        row.at<double>(1) += rng.uniform(20., 60.);
    }
    const Estimate estimate = calibrate(scene);
    EXPECT_NEAR(clean.rms, estimate.rms, 0.02);
    EXPECT_LE(std::abs(estimate.K(0, 0) - clean.K(0, 0)), 2 * std::sqrt(clean.covariance.at<double>(0, 0)));
    EXPECT_LE(angleDeg(estimate.R, clean.R), 0.05);
}

TEST(ActiveHandEye_Translations, swapped_poses_are_found_and_left_out)
{
    PointScene scene = PointScene::complete(3, 60);
    scene.project(0.1);
    std::swap(scene.t[2], scene.t[3]);
    const Estimate estimate = calibrate(scene);
    EXPECT_LE(estimate.rms, 0.15);
    EXPECT_LE(std::abs(estimate.K(0, 0) - scene.K(0, 0)), 5);
    EXPECT_LE(angleDeg(estimate.R, scene.R_cam2gripper), 0.15);
}

TEST(ActiveHandEye_Translations, a_view_of_another_orientation_is_left_out)
{
    PointScene scene = PointScene::complete(3, 60);
    scene.project(0.1);
    scene.R[2] = Mat(rotation(Vec3d(0.02, 0.01, 0))) * scene.R[2]; // reported: joins no group
    const Estimate reported = calibrate(scene);
    EXPECT_LE(angleDeg(reported.R, scene.R_cam2gripper), 0.15);

    PointScene hidden = PointScene::complete(3, 60);
    hidden.R[2] = Mat(rotation(Vec3d(0.02, 0.01, 0))) * hidden.R[2]; // true, but not reported
    hidden.project(0.1);
    hidden.R[2] = hidden.R[1];
    const Estimate unreported = calibrate(hidden);
    EXPECT_LE(unreported.rms, 0.15);
    EXPECT_LE(angleDeg(unreported.R, hidden.R_cam2gripper), 0.15);
}

TEST(ActiveHandEye_Translations, inputs_are_not_modified)
{
    PointScene scene = PointScene::complete();
    vector<Mat> copies;
    for (const vector<Mat>* list : {&scene.R, &scene.t, &scene.imagePoints})
        for (const Mat& m : *list)
            copies.push_back(m.clone());
    calibrate(scene);
    size_t k = 0;
    for (const vector<Mat>* list : {&scene.R, &scene.t, &scene.imagePoints})
        for (const Mat& m : *list)
            EXPECT_EQ(0, cv::norm(m, copies[k++], NORM_INF));
}

TEST(ActiveHandEye_GroupViews, views_join_the_first_group_of_their_orientation)
{
    PointScene scene(1);
    scene.addGroup(Vec3d(0, 0, 0), vector<Vec3d>(1, Vec3d()));
    scene.addGroup(Vec3d(0.2, 0, 0), vector<Vec3d>(2, Vec3d()));
    scene.addGroup(Vec3d(0.0005, 0, 0), vector<Vec3d>(1, Vec3d())); // 0.029 deg from the first
    scene.addGroup(Vec3d(0.002, 0, 0), vector<Vec3d>(1, Vec3d()));  // 0.11 deg
    vector<int> ids;
    groupViews(scene.R, ids);
    EXPECT_EQ((vector<int>{0, 1, 1, 0, 2}), ids);
    groupViews(scene.R, ids, 0.2);
    EXPECT_EQ((vector<int>{0, 1, 1, 0, 0}), ids);
    expectError([&] { groupViews(scene.R, ids, 0); }, Error::StsOutOfRange, {"orientationTolerance", "given 0"});
}

}} // namespace opencv_test
