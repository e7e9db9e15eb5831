// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Which views the refinement believes, when it begins without believing some of them.
#include "../test/refine_scene.hpp"

#include "../src/precomp.hpp"
#include "../src/refinement.hpp"

namespace opencv_test { namespace {

using namespace cv::active_handeye;
using refine::RefineScene;

//! Two groups of four translations and four single views.
RefineScene fewViews(uint64 seed, double millimetres = 0.02)
{
    RefineScene scene(seed, 150);
    const vector<Vec3d> offsets = {Vec3d(0, 0, 0), Vec3d(60, 0, 0), Vec3d(0, 60, 20), Vec3d(-30, -30, -60)};
    scene.addGroup(Vec3d(0, 0, 0), offsets);
    scene.addGroup(Vec3d(0.3, 0.1, 2.1), offsets);
    for (const Vec3d& turn : {Vec3d(0, 0.4, 1), Vec3d(-0.4, -0.2, -1), Vec3d(0.2, -0.4, 2.5), Vec3d(-0.4, 0.2, -2.1)})
        scene.addGroup(turn, vector<Vec3d>(1, Vec3d()));
    scene.measure(0.03, millimetres, 0.005);
    return scene;
}

RefineMeasurements measurementsOf(const RefineScene& scene)
{
    RefineMeasurements m;
    m.gripper2base = readRobotPoses(scene.reportedR, scene.reportedT);
    m.imagePoints = readImagePoints(scene.imagePoints, m.gripper2base.size());
    return m;
}

HandEyeCalibration truthOf(const RefineScene& scene)
{
    HandEyeCalibration truth;
    truth.camera = readCamera(Mat(scene.K), scene.dist());
    truth.cam2gripper.R = readRotation(Mat(scene.R_cam2gripper), "R_cam2gripper");
    truth.cam2gripper.t = readVector3(Mat(scene.t_cam2gripper), "t_cam2gripper");
    return truth;
}

vector<int> rejectedViews(const RefineScene& scene, const vector<int>& doubted)
{
    const RefineMeasurements measurements = measurementsOf(scene);
    RefineParams params;
    params.lensModel = LENS_FIXED;
    HandEyeRefinement refinement(measurements, params, truthOf(scene), doubted);
    refinement.findScene();
    refinement.fitPoints();
    refinement.requireAnswer();
    RefineSummary summary;
    refinement.summarize(summary);
    return summary.rejectedViews;
}

TEST(ActiveHandEye_ViewDoubts, a_group_of_good_views_is_believed_again)
{
    for (uint64 seed = 1; seed <= 8; ++seed)
        EXPECT_EQ(vector<int>(), rejectedViews(fewViews(seed), {0, 1, 2, 3})) << seed;
}

// The likeliest translation noise of eight views may be none at all. Held against that, good views would be outliers.
TEST(ActiveHandEye_ViewDoubts, a_group_is_believed_again_though_the_other_positions_happen_to_be_exact)
{
    for (uint64 seed : {6, 10})
    {
        RefineScene scene = fewViews(seed, 0.05);
        for (size_t view = 4; view < scene.R.size(); ++view)
            scene.reportedT[view] = scene.t[view].clone();
        EXPECT_EQ(vector<int>(), rejectedViews(scene, {0, 1, 2, 3})) << seed;
    }
}

TEST(ActiveHandEye_ViewDoubts, of_a_group_that_was_doubted_only_the_slipped_view_is_left_out)
{
    for (uint64 seed = 1; seed <= 8; ++seed)
    {
        RefineScene scene = fewViews(seed);
        scene.reportedT[2] += Mat(Vec3d(0.4, 0.3, 0));
        EXPECT_EQ(vector<int>(1, 2), rejectedViews(scene, {0, 1, 2, 3})) << seed;
    }
}

}} // namespace opencv_test
