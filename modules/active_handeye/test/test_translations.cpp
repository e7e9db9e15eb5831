// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "point_scene.hpp"

namespace opencv_test { namespace {

struct Estimate
{
    double rms;
    Matx33d K, R;
    Mat covariance;
};

Estimate calibrate(const PointScene& scene, TranslationsMethod method = TRANSLATIONS_METRIC, int flags = 0, const Mat& given = Mat(),
                   const Mat& dist = Mat())
{
    Estimate estimate;
    Mat K = given.clone(), R;
    estimate.rms = calibrateHandEyeTranslations(scene.R, scene.t, scene.imagePoints, K, dist, R, estimate.covariance, method, flags);
    estimate.K = K;
    estimate.R = R;
    return estimate;
}

void expectExact(const PointScene& scene, const Estimate& estimate, double tolerance = 1e-9)
{
    EXPECT_LE(estimate.rms, tolerance * 100);
    EXPECT_LE(cv::norm(estimate.K - scene.K, NORM_INF), tolerance * scene.K(0, 0));
    EXPECT_LE(cv::norm(estimate.R - scene.R_cam2gripper, NORM_INF), tolerance);
}

PointScene oneGroup(const vector<Vec3d>& offsets, uint64 seed = 1, double noise = 0)
{
    PointScene scene(seed);
    scene.addGroup(Vec3d(), offsets);
    scene.project(noise);
    return scene;
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
    vector<Matx33d> rotations;
    vector<Vec3d> translations;
    vector<vector<Point2d> > points;
    Mat stacked(vector<int>{int(scene.R.size()), int(scene.X.size()), 2}, CV_64F);
    for (size_t view = 0; view < scene.R.size(); ++view)
    {
        rotations.push_back(Matx33d(scene.R[view]));
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
        const double errors[8] = {dK(0, 0), dK(1, 1), dK(0, 2), dK(1, 2), dK(0, 1), (dR(2, 1) - dR(1, 2)) / 2, (dR(0, 2) - dR(2, 0)) / 2,
                                  (dR(1, 0) - dR(0, 1)) / 2};
        for (int k = 0; k < 8; ++k)
            sums[k] += errors[k] * errors[k] / estimate.covariance.at<double>(k, k);
    }
    for (int k = 0; k < 8; ++k)
        EXPECT_NEAR(1, std::sqrt(sums[k] / trials), 0.2) << "parameter " << k; // 4 standard deviations
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

TEST(ActiveHandEye_Translations, motion_that_cannot_answer_is_refused_with_what_is_missing)
{
    const PointScene full = oneGroup(PointScene::fourTranslations());
    PointScene turning(2);
    for (int k = 0; k < 4; ++k)
        turning.addGroup(Vec3d(0.1 * k * k, 0, 0), vector<Vec3d>(1, Vec3d()));
    turning.project();
    expectError([&] { calibrate(turning); }, Error::StsNoConv,
                {"R_gripper2base: no two views have equal orientation", "orientationTolerance = 0.05 deg", "views 0 and 1 come nearest with 5.730 deg"});

    const Matx33d cameraToBase = Matx33d(full.R[0]) * full.R_cam2gripper;
    const auto column = [&](int k) { return cv::format("(%.2f, %.2f, %.2f)", cameraToBase(0, k), cameraToBase(1, k), cameraToBase(2, k)); };
    const PointScene still = oneGroup(vector<Vec3d>(3, Vec3d()));
    expectError([&] { calibrate(still); }, Error::StsNoConv, {"t_gripper2base", "all at one place", "given none"});
    const PointScene parallel = oneGroup(vector<Vec3d>{Vec3d(), Vec3d(50, 0, 0), Vec3d(-30, 0, 0)});
    expectError([&] { calibrate(parallel, TRANSLATIONS_METRIC, TRANSLATIONS_FIX_K, Mat(full.K)); }, Error::StsNoConv,
                {"all translations are parallel", "two that are not parallel", "in base coordinates: add one along"});
    const PointScene coplanar = oneGroup(vector<Vec3d>{Vec3d(), Vec3d(50, 0, 0), Vec3d(-30, 50, 0), Vec3d(10, -40, 0)});
    for (int method : {TRANSLATIONS_METRIC, TRANSLATIONS_FOE})
        expectError([&] { calibrate(coplanar, TranslationsMethod(method)); }, Error::StsNoConv,
                    {"all translations are coplanar", "three that are not coplanar", "add one along", "in base coordinates"});
    string text;
    try { calibrate(coplanar); } catch (const cv::Exception& e) { text = e.what(); }
    const Matx33d minus = -1 * cameraToBase;
    const string opposite = cv::format("(%.2f, %.2f, %.2f)", minus(0, 2), minus(1, 2), minus(2, 2));
    EXPECT_TRUE(text.find(column(2)) != string::npos || text.find(opposite) != string::npos) << text << "\nneeded +-" << column(2);

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
    expectError([&] { calibrate(lost); }, Error::StsNoConv, {"too few points in common", "given 1 such points", "out of 30 points in 12 views"});
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
    const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
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
    bad.imagePoints[4].at<double>(7, 0) = inf;
    expectError([&] { calibrate(bad); }, Error::StsBadArg, {"imagePoints[4]", "at point 7"});
    bad.imagePoints[4].at<double>(7, 0) = nan;
    expectError([&] { calibrate(bad); }, Error::StsBadArg, {"imagePoints[4]", "(NaN, NaN)", "at point 7"});

    expectError([&] { calibrate(good, TranslationsMethod(5)); }, Error::StsBadArg, {"method", "given 5"});
    expectError([&] { calibrate(good, TRANSLATIONS_METRIC, 8); }, Error::StsBadArg, {"flags", "given 8"});
    expectError([&] { calibrate(good, TRANSLATIONS_METRIC, TRANSLATIONS_FIX_K); }, Error::StsBadSize, {"cameraMatrix", "3 x 3", "given none"});
    expectError([&] { calibrate(good, TRANSLATIONS_METRIC, TRANSLATIONS_FIX_K, Mat::ones(3, 3, CV_64F)); }, Error::StsBadArg,
                {"cameraMatrix", "fx, skew, cx"});
    expectError([&] { calibrate(good, TRANSLATIONS_METRIC, 0, Mat(), Mat::zeros(1, 8, CV_64F)); }, Error::StsBadSize, {"distCoeffs", "given 8"});
    const Mat folding = (Mat_<double>(1, 4) << -30., 0., 0., 0.);
    expectError([&] { calibrate(good, TRANSLATIONS_METRIC, TRANSLATIONS_FIX_K, Mat(good.K), folding); }, Error::StsOutOfRange,
                {"distCoeffs", "cannot be inverted at pixel"});
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
