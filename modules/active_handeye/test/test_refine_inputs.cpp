// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "refine_scene.hpp"

namespace opencv_test { namespace {

using namespace refine;

RefineScene stripedScene(uint64 seed = 1)
{
    RefineScene scene(seed);
    scene.D[0] = -0.1;
    scene.addViews();
    scene.addSurfaces();
    scene.measure(0.1, 0.02, 0.005, 0.05);
    return scene;
}

void expectSame(const Refinement& a, const Refinement& b, double tolerance)
{
    EXPECT_LE(cv::norm(a.K, b.K), tolerance * b.deviation("fx"));
    EXPECT_LE(angleDeg(a.R_cam2gripper, b.R_cam2gripper) * CV_PI / 180, tolerance * b.deviation("rx"));
    EXPECT_LE(cv::norm(a.translation() - b.translation()), tolerance * b.deviation("tx"));
    EXPECT_LE(cv::norm(a.light, b.light), tolerance * b.deviation("d"));
    for (int i = 0; i < 20; ++i)
        EXPECT_NEAR(b.summary.standardDeviations.at<double>(i), a.summary.standardDeviations.at<double>(i),
                    tolerance * b.summary.standardDeviations.at<double>(i));
}

TEST(ActiveHandEye_RefineInput, nothing_of_the_callers_is_modified)
{
    const RefineScene scene = stripedScene();
    Refinement call = scene.call();
    call.pointSigmas.assign(call.R.size(), Mat());
    for (Mat& sigmas : call.pointSigmas)
        sigmas = Mat::ones(40, 1, CV_64F);
    call.stripeSigmas = Mat(int(call.stripes.size()), 1, CV_64F, Scalar(0.05));
    call.objectPoints = Mat(40, 3, CV_64F, Scalar(std::numeric_limits<double>::quiet_NaN()));
    for (int j = 0; j < 10; ++j)
        Mat(scene.X[j]).reshape(1, 1).copyTo(call.objectPoints.row(j));
    const Mat sigmas = call.stripeSigmas.clone(), known = call.objectPoints.clone();
    call.K = Mat(scene.K).clone();
    call.K.at<double>(0, 0) += 3;
    const Mat start = call.K, startNumbers = start.clone();
    call.run();
    EXPECT_TRUE(sameBits(startNumbers, start));
    EXPECT_GT(cv::norm(call.K, start), 1);
    const Refinement given = scene.call();
    for (size_t view = 0; view < given.R.size(); ++view)
    {
        EXPECT_TRUE(sameBits(given.R[view], call.R[view]) && sameBits(given.t[view], call.t[view]));
        EXPECT_TRUE(sameBits(given.imagePoints[view], call.imagePoints[view]));
        EXPECT_TRUE(sameBits(Mat::ones(40, 1, CV_64F), call.pointSigmas[view]));
    }
    for (size_t i = 0; i < given.stripes.size(); ++i)
        EXPECT_TRUE(sameBits(given.stripes[i], call.stripes[i]));
    EXPECT_TRUE(given.stripeViews == call.stripeViews && given.surfaceIds == call.surfaceIds);
    EXPECT_TRUE(sameBits(sigmas, call.stripeSigmas) && sameBits(known, call.objectPoints));
}

//! Every array inside a larger one, so that no row follows the other in memory.
Mat spread(const Mat& m)
{
    Mat larger(m.rows + 2, m.cols + 3, m.type(), Scalar(-7));
    Mat inside = larger(Rect(1, 1, m.cols, m.rows));
    m.copyTo(inside);
    EXPECT_FALSE(m.rows > 1 && inside.isContinuous());
    return inside;
}

TEST(ActiveHandEye_RefineInput, layout_and_kind_of_the_arrays_do_not_matter)
{
    const RefineScene scene = stripedScene();
    const Refinement reference = scene.refined();
    Refinement other = scene.call();
    for (vector<Mat>* list : {&other.R, &other.t, &other.imagePoints, &other.stripes})
        for (Mat& m : *list)
            m = spread(m);
    other.run();
    expectSame(other, reference, 0);

    Refinement pairs = scene.call(); // two channels; rotation vectors; rows instead of columns
    for (vector<Mat>* list : {&pairs.imagePoints, &pairs.stripes})
        for (Mat& m : *list)
            m = m.reshape(2, 1);
    for (Mat& t : pairs.t)
        t = t.t();
    pairs.run();
    expectSame(pairs, reference, 0);
}

TEST(ActiveHandEye_RefineInput, single_precision_is_accepted)
{
    const RefineScene scene = stripedScene();
    Refinement other = scene.call(), rounded = scene.call();
    for (vector<Mat>* list : {&other.t, &other.imagePoints, &other.stripes})
        for (Mat& m : *list)
            m.convertTo(m, CV_32F);
    for (vector<Mat>* list : {&rounded.t, &rounded.imagePoints, &rounded.stripes})
        for (Mat& m : *list)
        {
            m.convertTo(m, CV_32F);
            m.convertTo(m, CV_64F);
        }
    other.run();
    rounded.run();
    expectSame(other, rounded, 0);
    EXPECT_LE(scene.worstError(other), 4.5);
    EXPECT_EQ(CV_64F, other.K.type());
}

TEST(ActiveHandEye_RefineInput, starts_may_have_any_shape_and_are_replaced)
{
    const RefineScene scene = stripedScene();
    Refinement call = scene.call();
    Matx33f K = scene.K;
    call.K = Mat(K);
    call.D = (Mat_<float>(1, 4) << -0.1, 0, 0, 0);
    call.R_cam2gripper = Mat(Vec3d(0.05, -0.03, 1.5)); // rotation vector
    call.t_cam2gripper = Mat(Vec3f(-5, 103, 104)).t();
    call.light = scene.trueLight().t();
    call.params.lensModel = LENS_K1;
    call.run();
    EXPECT_EQ(Size(3, 3), call.K.size());
    EXPECT_EQ(Size(1, 5), call.D.size());
    EXPECT_EQ(Size(3, 3), call.R_cam2gripper.size());
    EXPECT_EQ(Size(1, 3), call.t_cam2gripper.size());
    EXPECT_EQ(Size(1, 4), call.light.size());
    for (const Mat* m : {&call.K, &call.D, &call.R_cam2gripper, &call.t_cam2gripper, &call.light})
        EXPECT_EQ(CV_64F, m->type());
    Refinement reference = scene.call();
    reference.params.lensModel = LENS_K1;
    reference.run();
    expectSame(call, reference, 0.02);
}

/** A camera beside the robot and an object in the gripper: inverted poses in, camera to base out.

Written out by itself: P of the gripper frame is seen at K R_cam2base^T (R_gripper2base P + t_gripper2base - t_cam2base).
*/
TEST(ActiveHandEye_RefineInput, eye_to_hand_is_the_same_with_inverted_poses)
{
    RNG rng(12);
    const Matx33d K(1413, 0, 316, 0, 1420, 243, 0, 0, 1), R_cam2base = rotation(Vec3d(1.9, -0.4, 0.3));
    const Vec3d t_cam2base(800, -250, 400);
    vector<Vec3d> P;
    for (int j = 0; j < 40; ++j)
        P.push_back(Vec3d(rng.uniform(-80., 80.), 20 + rng.uniform(-60., 60.), 150 + rng.uniform(-60., 60.)));
    Refinement call;
    for (const Vec3d& turn : {Vec3d(0.1, 0, 0), Vec3d(-0.3, 0.2, 0.4), Vec3d(0.2, 0.35, -0.5)})
        for (const Vec3d& offset : PointScene::fourTranslations())
        {
            const Matx33d R_gripper2base = R_cam2base * rotation(turn);
            const Vec3d t_gripper2base =
                t_cam2base + R_cam2base * (Vec3d(0, 0, 550) + offset) - R_gripper2base * Vec3d(0, 20, 150);
            Mat pixels(40, 2, CV_64F);
            for (int j = 0; j < 40; ++j)
            {
                const Vec3d x = K * (R_cam2base.t() * (R_gripper2base * P[j] + t_gripper2base - t_cam2base));
                pixels.at<double>(j, 0) = x[0] / x[2];
                pixels.at<double>(j, 1) = x[1] / x[2];
            }
            call.imagePoints.push_back(pixels);
            call.R.push_back(Mat(R_gripper2base.t()));
            call.t.push_back(Mat(Vec3d(-(R_gripper2base.t() * t_gripper2base))));
        }
    call.run();
    EXPECT_LE(cv::norm(Matx33d(call.K) - K), 1e-6);
    EXPECT_LE(angleDeg(call.R_cam2gripper, R_cam2base), 1e-8) << "is R_cam2base";
    EXPECT_LE(cv::norm(call.translation() - t_cam2base), 1e-6);
    for (int j = 0; j < 40; ++j)
        EXPECT_LE(cv::norm(Vec3d(call.summary.scenePoints.ptr<double>(j)) - P[j]), 1e-6) << "in the gripper frame";
}

TEST(ActiveHandEye_RefineInput, order_of_views_points_and_segments_does_not_matter)
{
    const RefineScene scene = stripedScene();
    Refinement reversed = scene.call();
    const int views = int(reversed.R.size());
    for (vector<Mat>* list : {&reversed.R, &reversed.t, &reversed.imagePoints, &reversed.stripes})
        std::reverse(list->begin(), list->end());
    for (Mat& image : reversed.imagePoints)
        cv::flip(image.clone(), image, 0);
    std::reverse(reversed.stripeViews.begin(), reversed.stripeViews.end());
    std::reverse(reversed.surfaceIds.begin(), reversed.surfaceIds.end());
    for (int& view : reversed.stripeViews)
        view = views - 1 - view;
    reversed.run();
    const Refinement reference = scene.refined();
    expectSame(reversed, reference, 0.01);
    Mat backwards;
    cv::flip(reversed.summary.poseCorrections, backwards, 0);
    EXPECT_LE(cv::norm(backwards, reference.summary.poseCorrections, NORM_INF),
              0.01 * reference.summary.robotTranslationSigma);
}

TEST(ActiveHandEye_RefineInput, surfaces_that_are_not_known_are_not_used)
{
    const RefineScene scene = stripedScene();
    Refinement some = scene.call(), fewer = scene.call();
    fewer.stripes.clear();
    fewer.stripeViews.clear();
    fewer.surfaceIds.clear();
    for (size_t i = 0; i < some.stripes.size(); ++i)
        if (i % 7 == 0)
            some.surfaceIds[i] = -1;
        else
        {
            fewer.stripes.push_back(some.stripes[i]);
            fewer.stripeViews.push_back(some.stripeViews[i]);
            fewer.surfaceIds.push_back(some.surfaceIds[i]);
        }
    some.run();
    fewer.run();
    expectSame(some, fewer, 1e-3);
    EXPECT_TRUE(std::isnan(some.summary.stripeResiduals.at<double>(7, 0)));
    EXPECT_FALSE(std::isnan(some.summary.stripeResiduals.at<double>(8, 0)));
}

}} // namespace opencv_test
