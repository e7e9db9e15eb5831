// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "refine_scene.hpp"

namespace opencv_test { namespace {

using namespace refine;

double translationError(const RefineScene& scene, const Refinement& found)
{
    return cv::norm(found.translation() - scene.t_cam2gripper);
}

//! One sentence of the summary names the view.
void expectCulprit(const Refinement& found, int view)
{
    const string name = cv::format("view %d:", view);
    bool isNamed = false;
    for (const string& culprit : found.summary.culprits)
        isNamed = isNamed || culprit.find(name) == 0 || culprit.find(cv::format("%d", view)) != string::npos;
    EXPECT_TRUE(isNamed) << name;
    const vector<int>& views = found.summary.rejectedViews;
    EXPECT_EQ(1, std::count(views.begin(), views.end(), view)) << name;
}

TEST(ActiveHandEye_RefineRobust, a_wrong_match_is_left_out_and_marked)
{
    RefineScene scene = RefineScene::noisy(1);
    const Refinement clean = scene.refined();
    const double wrong[] = {1.2, 5, 60, 400};
    const int views[] = {3, 8, 0, 17}, points[] = {7, 11, 30, 2};
    for (int k = 0; k < 4; ++k)
        scene.imagePoints[views[k]].at<double>(points[k], k % 2) += wrong[k];
    const Refinement found = scene.refined();
    for (int k = 0; k < 4; ++k)
    {
        EXPECT_EQ(1, found.summary.rejectedObservations.at<uchar>(views[k], points[k])) << wrong[k];
        EXPECT_NEAR(-wrong[k], found.summary.residuals.at<double>(views[k], 2 * points[k] + k % 2), 0.6)
            << "predicted - measured";
    }
    EXPECT_LE(cv::countNonZero(found.summary.rejectedObservations), 6);
    EXPECT_LE(cv::norm(found.K, clean.K), 0.5 * clean.deviation("fx"));
    EXPECT_LE(cv::norm(found.translation() - clean.translation()), 0.5 * clean.deviation("tz"));
    EXPECT_NEAR(clean.rms, found.rms, 0.01);
    EXPECT_NEAR(1, found.summary.pointSigma / clean.summary.pointSigma, 0.05);
    EXPECT_TRUE(found.summary.usable);
}

TEST(ActiveHandEye_RefineRobust, a_fifth_of_the_tracks_may_be_wrong)
{
    double clean = 0, spoiled = 0;
    for (int trial = 0; trial < 6; ++trial)
    {
        RefineScene scene = RefineScene::noisy(300 + trial, 0.1, 0.02, 0.005, 60);
        clean += std::pow(translationError(scene, scene.refined()), 2);
        RNG rng(trial);
        for (int j = 0; j < 60; j += 5) // from some view on it is another point
            for (size_t view = rng.uniform(3, 16); view < scene.imagePoints.size(); ++view)
                for (int i = 0; i < 2; ++i)
                    scene.imagePoints[view].at<double>(j, i) += 40 * (i ? -1 : 1) + rng.gaussian(5);
        const Refinement found = scene.refined();
        spoiled += std::pow(translationError(scene, found), 2);
        EXPECT_LE(scene.worstError(found), 5) << trial;
        EXPECT_GE(cv::countNonZero(found.summary.rejectedObservations), 30);
    }
    EXPECT_LE(std::sqrt(spoiled / clean), 1.5);
}

TEST(ActiveHandEye_RefineRobust, swapped_poses_are_named)
{
    for (uint64 seed = 1; seed <= 4; ++seed)
    {
        RefineScene scene = RefineScene::noisy(seed);
        const Refinement clean = scene.refined();
        const int one = int(seed), other = 10 + int(seed); // of two groups
        std::swap(scene.reportedR[one], scene.reportedR[other]);
        std::swap(scene.reportedT[one], scene.reportedT[other]);
        const Refinement found = scene.refined();
        EXPECT_EQ((vector<int>{one, other}), found.summary.rejectedViews);
        expectCulprit(found, one);
        expectCulprit(found, other);
        EXPECT_LE(scene.worstError(found), 4.5);
        EXPECT_LE(cv::norm(found.translation() - clean.translation()), 2 * clean.deviation("tz"));
    }
}

TEST(ActiveHandEye_RefineRobust, a_slipped_view_is_named)
{
    for (uint64 seed = 1; seed <= 4; ++seed)
    {
        RefineScene scene = RefineScene::noisy(seed, 0.1, 0.02, 0.005, 100);
        const Refinement clean = scene.refined();
        const int slipped = 3 * int(seed);
        scene.reportedT[slipped] +=
            Mat(Vec3d(Matx33d(scene.R[slipped]) * Vec3d(0.35, 0.35, 0))); // 0.5 mm, across the optical axis
        const Refinement found = scene.refined();
        EXPECT_EQ(vector<int>(1, slipped), found.summary.rejectedViews) << "seed " << seed;
        expectCulprit(found, slipped);
        EXPECT_LE(scene.worstError(found), 4.5);
        const Vec6d correction(found.summary.poseCorrections.ptr<double>(slipped));
        EXPECT_NEAR(0.5, cv::norm(Vec3d(correction[3], correction[4], correction[5])), 0.15);
    }
}

TEST(ActiveHandEye_RefineRobust, a_good_recording_has_no_culprits)
{
    int doubted = 0;
    for (int trial = 0; trial < 20; ++trial)
    {
        const Refinement found = RefineScene::noisy(400 + trial).refined();
        doubted += int(found.summary.rejectedViews.size());
        EXPECT_EQ(found.summary.rejectedViews.size(), found.summary.culprits.size());
        EXPECT_TRUE(found.summary.usable) << found.summary.message;
    }
    EXPECT_LE(doubted, 2); // 380 views
}

TEST(ActiveHandEye_RefineRobust, a_segment_on_another_surface_is_left_out)
{
    RefineScene scene(2);
    scene.addViews();
    scene.addSurfaces();
    scene.measure(0.1, 0.02, 0.005, 0.05);
    const Refinement clean = scene.refined();
    Mat rows = scene.stripes[13].col(1);
    rows += 3; // px
    std::swap(scene.surfaceIds[30], scene.surfaceIds[31]);
    const Refinement found = scene.refined();
    EXPECT_EQ((vector<int>{13, 30, 31}), found.summary.rejectedSegments);
    EXPECT_LE(cv::norm(found.light.rowRange(0, 3) - clean.light.rowRange(0, 3)), clean.deviation("nz"));
    EXPECT_TRUE(std::isnan(found.summary.stripeResiduals.at<double>(13, 0)));
    EXPECT_LE(scene.worstError(found), 4.5);
}

//! What is said of the views fits what was done.
TEST(ActiveHandEye_RefineRobust, summaries_hang_together)
{
    RefineScene scene = RefineScene::noisy(3);
    scene.imagePoints[5].row(9).setTo(std::numeric_limits<double>::quiet_NaN());
    scene.imagePoints[2].at<double>(4, 0) += 20;
    const Refinement found = scene.refined();
    const RefineSummary& s = found.summary;
    const int views = int(scene.R.size()), points = int(scene.X.size());
    ASSERT_EQ(Size(2 * points, views), s.residuals.size());
    ASSERT_EQ(Size(points, views), s.rejectedObservations.size());
    EXPECT_TRUE(std::isnan(s.residuals.at<double>(5, 18)));
    EXPECT_EQ(0, s.rejectedObservations.at<uchar>(5, 9)) << "not seen is not left out";
    double sum = 0;
    int used = 0;
    for (int view = 0; view < views; ++view)
    {
        double ofView = 0;
        int usedInView = 0;
        for (int j = 0; j < points; ++j)
        {
            const double dx = s.residuals.at<double>(view, 2 * j), dy = s.residuals.at<double>(view, 2 * j + 1);
            if (std::isnan(dx) || s.rejectedObservations.at<uchar>(view, j))
                continue;
            ofView += dx * dx + dy * dy;
            ++usedInView;
        }
        EXPECT_NEAR(std::sqrt(ofView / usedInView), s.viewRms.at<double>(view), 1e-12);
        sum += ofView;
        used += usedInView;
    }
    EXPECT_NEAR(std::sqrt(sum / used), s.rms, 1e-12);
    EXPECT_EQ(found.rms, s.rms);
    EXPECT_EQ(Size(6, views), s.poseCorrections.size());
    EXPECT_EQ(Size(3, points), s.scenePoints.size());
    EXPECT_GT(s.iterations, 0);
    EXPECT_NE(string::npos, s.stopReason.find("converged"));
    EXPECT_NE(string::npos, s.message.find("usable"));
    EXPECT_NEAR(550, s.workingDistance, 40);
}

}} // namespace opencv_test
