// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "planned_scene.hpp"

#include <set>

namespace opencv_test { namespace {

using namespace refine;

//! Possible views: `offsets` at every orientation.
RefineScene candidates()
{
    RefineScene scene(4);
    vector<Vec3d> offsets;
    for (int i = 0; i < 12; ++i)
        offsets.push_back(Vec3d(i % 3 - 1, (i / 3) % 2 - 0.5, i / 6 - 0.5) * 60);
    for (const Vec3d& turn : {Vec3d(0, 0, 0), Vec3d(0.3, 0, 0), Vec3d(-0.3, 0, 0.7), Vec3d(0, 0.3, 1.5),
                              Vec3d(0, -0.3, -1.5), Vec3d(0.2, 0.2, 3)})
        scene.addGroup(turn, offsets);
    return scene;
}

double sigmaOf(const Planned& all, const vector<int>& views)
{
    Planned some = all;
    some.R.clear();
    some.t.clear();
    for (const int view : views)
    {
        some.R.push_back(all.R[view]);
        some.t.push_back(all.t[view]);
    }
    return some.predict();
}

TEST(ActiveHandEye_PlannedViews, chosen_views_beat_random_ones_and_hold_two_groups)
{
    Planned planned(candidates());
    const int stops = 14;
    const double sigma = planned.plan(stops);
    ASSERT_EQ(size_t(stops), std::set<int>(planned.chosen.begin(), planned.chosen.end()).size());
    EXPECT_DOUBLE_EQ(sigmaOf(planned, planned.chosen), sigma);
    std::vector<int> count(6);
    for (const int view : planned.chosen)
        ++count[view / 12];
    EXPECT_GE(std::count_if(count.begin(), count.end(), [](int n) { return n >= 4; }), 2);
    for (int i = 0; i + 1 < stops; ++i)
        EXPECT_GE(count[planned.chosen[i] / 12], count[planned.chosen[i + 1] / 12]) << "largest groups first";
    RNG rng(1);
    for (int trial = 0; trial < 50; ++trial)
    {
        std::set<int> random;
        while (int(random.size()) < stops)
            random.insert(rng.uniform(0, 72));
        EXPECT_GT(sigmaOf(planned, vector<int>(random.begin(), random.end())), sigma) << trial;
    }
}

TEST(ActiveHandEye_PlannedViews, exchange_makes_a_greedy_choice_better)
{
    Planned planned(candidates());
    planned.planParams.exchanges = 0;
    const double greedy = planned.plan(12);
    planned.planParams.exchanges = 3;
    EXPECT_LT(planned.plan(12), greedy);
}

TEST(ActiveHandEye_PlannedViews, views_taken_are_kept_and_counted)
{
    Planned planned(candidates());
    planned.plan(10);
    const vector<int> before(planned.chosen.begin(), planned.chosen.begin() + 5);
    planned.taken = Mat(before, true);
    const double sigma = planned.plan(12);
    ASSERT_EQ(7u, planned.chosen.size());
    vector<int> all = before;
    for (const int view : planned.chosen)
    {
        EXPECT_EQ(0, std::count(before.begin(), before.end(), view));
        all.push_back(view);
    }
    EXPECT_DOUBLE_EQ(sigmaOf(planned, all), sigma);
}

TEST(ActiveHandEye_PlannedViews, known_camera_asks_for_less_translation)
{
    Planned planned(candidates());
    expectError([&] { planned.plan(7); }, Error::StsOutOfRange, {"stops: needed 8 or more for 2 groups of 4"});
    planned.params.flags = REFINE_FIX_K;
    EXPECT_GT(planned.plan(7), 0);
}

TEST(ActiveHandEye_PlannedViews, views_that_see_little_are_not_chosen)
{
    RefineScene scene = candidates();
    for (int view = 0; view < 6; ++view) // of the first group, aside
        scene.t[view] += Mat(Vec3d(0, 200, 0));
    Planned planned(scene);
    planned.planParams.seenShare = 0.5;
    planned.plan(20);
    for (const int view : planned.chosen)
        EXPECT_GE(view, 6);
    planned.planParams.seenShare = 1;
    expectError([&] { planned.plan(20); }, Error::StsNoConv, {"which see enough of the scene"});
    planned.imageSize = Size(64, 48);
    expectError([&] { planned.plan(20); }, Error::StsNoConv, {"planParams.seenShare", "40 points"});
}

TEST(ActiveHandEye_PlannedViews, refused_choices_are_named)
{
    Planned planned(candidates());
    expectError([&] { planned.plan(73); }, Error::StsOutOfRange, {"stops", "at most all 72", "given 73"});
    planned.taken = (Mat_<int>(2, 1) << 3, 3);
    expectError([&] { planned.plan(10); }, Error::StsOutOfRange, {"taken", "given 3"});
    planned.taken = Mat();
    planned.planParams.viewsPerGroup = 3;
    expectError([&] { planned.plan(10); }, Error::StsOutOfRange, {"planParams.viewsPerGroup", "4 or more", "given 3"});
    planned.planParams.viewsPerGroup = 13;
    expectError([&] { planned.plan(40); }, Error::StsNoConv, {"2 orientations with 13 views", "hold 0"});
    planned.planParams = PlanParams();
    planned.params.flags = REFINE_FIX_TRANSLATION;
    expectError([&] { planned.plan(10); }, Error::StsBadArg, {"REFINE_FIX_TRANSLATION"});
    planned.params.flags = 0;
    planned.R.resize(24);
    planned.t.resize(24);
    expectError([&] { planned.plan(10); }, Error::StsNoConv, {"t_cam2gripper", "not observed"});
}

}} // namespace opencv_test
