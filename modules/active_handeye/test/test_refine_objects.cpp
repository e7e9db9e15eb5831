// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "refine_scene.hpp"

namespace opencv_test { namespace {

using namespace refine;

//! Motion of the frame in which the known points are given.
const Matx33d objectTurn = rotation(Vec3d(0.3, -0.7, 1.9));
const Vec3d objectShift(-120, 45, 30);

//! Coordinates of the points from `first` on in a frame of their own; the others are not known.
Mat knownPoints(const RefineScene& scene, int first = 0)
{
    Mat points(int(scene.X.size()), 3, CV_64F, Scalar(std::numeric_limits<double>::quiet_NaN()));
    for (int j = first; j < points.rows; ++j)
        Mat(Vec3d(objectTurn * scene.X[j] + objectShift)).reshape(1, 1).copyTo(points.row(j));
    return points;
}

//! A flat board of 9 x 6 corners, 15 mm apart.
RefineScene boardScene(uint64 seed, double noise)
{
    RefineScene scene(seed, 54);
    const Matx33d tilt = rotation(Vec3d(0.1, -0.15, 0.3));
    for (int j = 0; j < 54; ++j)
        scene.X[j] = Vec3d(300, 0, 0) + tilt * Vec3d(15 * (j % 9 - 4), 15 * (j / 9 - 2.5), 0);
    scene.addViews();
    scene.measure(0.1 * noise, 0.02 * noise, 0.005 * noise);
    return scene;
}

TEST(ActiveHandEye_RefineObject, a_board_gives_the_truth)
{
    const RefineScene scene = boardScene(1, 0);
    Refinement found = scene.call();
    found.objectPoints = knownPoints(scene);
    found.run();
    EXPECT_TRUE(found.summary.usable) << found.summary.message;
    EXPECT_LE(cv::norm(Matx33d(found.K) - scene.K), 1e-6);
    EXPECT_LE(cv::norm(found.translation() - scene.t_cam2gripper), 1e-7);
    EXPECT_LE(angleDeg(found.R_cam2gripper, scene.R_cam2gripper), 1e-8);
    for (int j = 0; j < 54; ++j)
        EXPECT_LE(cv::norm(Vec3d(found.summary.scenePoints.ptr<double>(j)) - scene.X[j]), 1e-6) << "in the base frame";
}

TEST(ActiveHandEye_RefineObject, a_board_that_is_known_says_more)
{
    const RefineScene scene = boardScene(2, 1);
    const Refinement unknown = scene.refined();
    Refinement known = scene.call();
    known.objectPoints = knownPoints(scene);
    known.run();
    EXPECT_LE(scene.worstError(unknown), 4.5);
    EXPECT_LE(scene.worstError(known), 4.5);
    EXPECT_LT(known.deviation("cx"), unknown.deviation("cx"));
    EXPECT_LT(known.deviation("fx"), unknown.deviation("fx"));
    EXPECT_LT(known.deviation("tz"), unknown.deviation("tz"));
    for (int j = 0; j < 54; ++j)
    {
        const Vec3d a(known.summary.scenePoints.ptr<double>(j)), b(known.summary.scenePoints.ptr<double>(0));
        EXPECT_NEAR(cv::norm(scene.X[j] - scene.X[0]), cv::norm(a - b), 1e-9) << "the object is rigid";
    }
}

TEST(ActiveHandEye_RefineObject, some_points_may_be_known)
{
    const RefineScene exact = RefineScene::exact(3), scene = RefineScene::noisy(3);
    Refinement truth = exact.call(), some = scene.call(), all = scene.call();
    truth.objectPoints = knownPoints(exact, 30);
    some.objectPoints = knownPoints(scene, 30);
    all.objectPoints = knownPoints(scene);
    for (Refinement* call : {&truth, &some, &all})
        call->run();
    EXPECT_LE(cv::norm(truth.translation() - exact.t_cam2gripper), 1e-7);
    EXPECT_LE(scene.worstError(some), 4.5);
    const double free = scene.refined().deviation("tz");
    EXPECT_LT(some.deviation("tz"), free);
    EXPECT_LT(all.deviation("tz"), some.deviation("tz"));
}

TEST(ActiveHandEye_RefineObject, the_frame_of_the_object_does_not_matter)
{
    const RefineScene scene = boardScene(4, 1);
    Refinement here = scene.call(), there = scene.call();
    here.objectPoints = knownPoints(scene);
    there.objectPoints = knownPoints(scene);
    for (int j = 0; j < 54; ++j)
        there.objectPoints.row(j) =
            there.objectPoints.row(j) * Mat(rotation(Vec3d(-1, 0.4, 0.2))) + Mat(Vec3d(500, -20, 1000)).t();
    here.run();
    there.run();
    EXPECT_LE(cv::norm(here.K, there.K), 1e-5 * here.deviation("fx"));
    EXPECT_LE(cv::norm(here.translation() - there.translation()), 1e-5 * here.deviation("tz"));
    EXPECT_LE(cv::norm(here.summary.scenePoints, there.summary.scenePoints, NORM_INF), 1e-4);
}

TEST(ActiveHandEye_RefineObject, a_known_point_may_be_seen_once)
{
    RefineScene scene = RefineScene::exact(5);
    Refinement call = scene.call();
    call.objectPoints = knownPoints(scene, 20);
    for (size_t view = 1; view < call.imagePoints.size(); ++view)
        call.imagePoints[view].row(39).setTo(std::numeric_limits<double>::quiet_NaN()); // known
    for (size_t view = 1; view < call.imagePoints.size(); ++view)
        call.imagePoints[view].row(3).setTo(std::numeric_limits<double>::quiet_NaN()); // not known
    call.run();
    EXPECT_LE(cv::norm(Vec3d(call.summary.scenePoints.ptr<double>(39)) - scene.X[39]), 1e-6);
    EXPECT_TRUE(std::isnan(call.summary.scenePoints.at<double>(3, 0)));
    EXPECT_LE(std::abs(call.summary.residuals.at<double>(0, 2 * 39)), 1e-7);
    EXPECT_TRUE(std::isnan(call.summary.residuals.at<double>(1, 2 * 39)));
}

TEST(ActiveHandEye_RefineObject, a_board_of_another_size_is_told)
{
    const RefineScene scene = boardScene(6, 1);
    Refinement call = scene.call();
    call.objectPoints = knownPoints(scene) * 1.02;
    call.params.pointSigma = 0.1;
    call.params.robotTranslationSigma = 0.02;
    call.params.robotRotationSigma = 0.005 * CV_PI / 180;
    call.run();
    EXPECT_FALSE(call.summary.usable);
    EXPECT_LT(call.summary.chiSquarePValue, 1e-6);
}

//! Sigmas of 2 for half of the points and 0.5 for the others, and noise accordingly.
TEST(ActiveHandEye_RefineObject, sigmas_of_the_points_are_weights)
{
    RefineScene scene(7, 60);
    scene.addViews();
    scene.measure(0, 0.02, 0.005);
    RNG rng(71);
    Refinement weighted = scene.call();
    for (Mat& image : weighted.imagePoints)
    {
        Mat sigmas(60, 1, CV_64F);
        for (int j = 0; j < 60; ++j)
        {
            sigmas.at<double>(j) = j % 2 ? 2 : 0.5;
            for (int i = 0; i < 2; ++i)
                image.at<double>(j, i) += rng.gaussian(0.15 * sigmas.at<double>(j));
        }
        weighted.pointSigmas.push_back(sigmas);
    }
    Refinement plain = weighted;
    plain.pointSigmas.clear();
    plain.run();
    weighted.run();
    EXPECT_NEAR(0.15, weighted.summary.pointSigma, 0.01) << "the common factor";
    EXPECT_LE(scene.worstError(weighted), 4.5);
    EXPECT_LT(weighted.deviation("fx"), 0.8 * plain.deviation("fx"));
}

TEST(ActiveHandEye_RefineObject, only_the_ratio_of_the_sigmas_matters)
{
    const RefineScene scene = RefineScene::noisy(8);
    const Refinement plain = scene.refined();
    Refinement doubled = scene.call(), certain = scene.call(), fewer = scene.call();
    for (size_t view = 0; view < doubled.imagePoints.size(); ++view)
    {
        doubled.pointSigmas.push_back(Mat(40, 1, CV_64F, Scalar(2)));
        certain.pointSigmas.push_back(Mat(40, 1, CV_64F, Scalar(1)));
        certain.pointSigmas.back().rowRange(0, 5).setTo(1e7); // as good as not seen
        fewer.imagePoints[view].rowRange(0, 5).setTo(std::numeric_limits<double>::quiet_NaN());
    }
    doubled.run();
    EXPECT_LE(cv::norm(doubled.K, plain.K), 1e-3 * plain.deviation("fx"));
    EXPECT_NEAR(0.5 * plain.summary.pointSigma, doubled.summary.pointSigma, 1e-4 * plain.summary.pointSigma);
    EXPECT_NEAR(plain.deviation("tz"), doubled.deviation("tz"), 1e-3 * plain.deviation("tz"));
    for (Refinement* call : {&certain, &fewer})
    {
        call->params.pointSigma = 0.1;
        call->params.robotTranslationSigma = 0.02;
        call->params.robotRotationSigma = 0.005 * CV_PI / 180;
        call->run();
    }
    EXPECT_LE(cv::norm(certain.K, fewer.K), 1e-3 * fewer.deviation("fx"));
    EXPECT_NEAR(fewer.deviation("tz"), certain.deviation("tz"), 1e-3 * fewer.deviation("tz"));
}

}} // namespace opencv_test
