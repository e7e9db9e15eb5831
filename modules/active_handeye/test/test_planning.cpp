// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "planned_scene.hpp"

#include <functional>

namespace opencv_test { namespace {

using namespace refine;

const double NaN = std::numeric_limits<double>::quiet_NaN();

//! The points' pixels where the planned views see them, as refineHandEye() takes them.
void hideUnseen(RefineScene& scene, Size imageSize)
{
    for (Mat& pixels : scene.imagePoints)
        for (int j = 0; j < pixels.rows; ++j)
        {
            double* x = pixels.ptr<double>(j);
            if (x[0] < 0 || x[1] < 0 || x[0] > imageSize.width - 1 || x[1] > imageSize.height - 1)
                x[0] = x[1] = NaN;
        }
}

TEST(ActiveHandEye_Planning, prediction_equals_the_covariance_of_the_refinement_without_noise)
{
    for (const int flags : {0, int(REFINE_FIX_K), int(REFINE_SKEW), int(REFINE_FIX_ROTATION)})
    {
        RefineScene scene = RefineScene::exact(3);
        Planned planned(scene);
        planned.params = levels(flags, flags ? LENS_FIXED : LENS_K1_K2);
        hideUnseen(scene, planned.imageSize);
        Refinement refined = scene.call();
        refined.params = planned.params;
        refined.K = planned.K.clone();
        refined.R_cam2gripper = planned.R_cam2gripper.clone();
        refined.t_cam2gripper = planned.t_cam2gripper.clone();
        refined.run();
        planned.predict();
        for (int i = 0; i < 20; ++i)
            for (int j = 0; j < 20; ++j)
                EXPECT_NEAR(refined.summary.covariance.at<double>(i, j), planned.covariance.at<double>(i, j),
                            1e-5 * std::sqrt(planned.variance(i) * planned.variance(j)))
                    << "flags " << flags << ", " << refined.summary.parameterNames[i] << " "
                    << refined.summary.parameterNames[j];
        EXPECT_NEAR(planned.sigma, std::sqrt(planned.variance(13) + planned.variance(14) + planned.variance(15)),
                    1e-12);
        EXPECT_EQ(refined.summary.weakDirections, planned.weak) << "flags " << flags;
    }
}

TEST(ActiveHandEye_Planning, every_view_more_makes_no_variance_larger)
{
    const RefineScene scene = RefineScene::exact(5);
    Planned planned(scene);
    planned.predict();
    Mat before = planned.covariance.diag().clone();
    const size_t least = 12;
    while (planned.R.size() > least)
    {
        planned.R.erase(planned.R.begin() + 7);
        planned.t.erase(planned.t.begin() + 7);
        planned.predict();
        for (int i = 0; i < 20; ++i)
            EXPECT_GE(planned.variance(i), before.at<double>(i) * (1 - 1e-9)) << i;
        before = planned.covariance.diag().clone();
    }
}

TEST(ActiveHandEye_Planning, turns_about_one_axis_leave_the_translation_along_it_infinite)
{
    RefineScene scene(1);
    for (const double angle : {0., 0.3, -0.3})
        scene.addGroup(Vec3d(angle, 0, 0), PointScene::fourTranslations());
    Planned planned(scene);
    EXPECT_EQ(infinity, planned.predict());
    ASSERT_FALSE(planned.weak.empty());
    EXPECT_NE(string::npos, planned.weak.back().find("t_cam2gripper along gripper")) << planned.weak.back();
    for (int i = 0; i < 13; ++i)
        EXPECT_TRUE(std::isfinite(planned.variance(i))) << i;
}

TEST(ActiveHandEye_Planning, translations_without_turns_leave_all_of_the_translation_infinite)
{
    RefineScene scene(1);
    scene.addGroup(Vec3d(0, 0, 0), PointScene::fourTranslations());
    Planned planned(scene);
    planned.predict();
    for (int i = 0; i < 20; ++i)
        EXPECT_EQ(i < 13 || i >= 16, std::isfinite(planned.variance(i))) << i;
}

TEST(ActiveHandEye_Planning, two_views_leave_the_camera_infinite_and_fixed_parameters_zero)
{
    RefineScene scene(1);
    scene.addGroup(Vec3d(0, 0, 0), {Vec3d(), Vec3d(50, 0, 0)});
    Planned planned(scene);
    planned.predict();
    EXPECT_TRUE(std::isinf(planned.variance(0)) && std::isinf(planned.variance(2)));
    EXPECT_EQ(0, planned.variance(4));
    EXPECT_EQ(0, planned.variance(5));
}

TEST(ActiveHandEye_Planning, lens_model_of_its_own_is_that_of_the_coefficients)
{
    RefineScene scene = RefineScene::exact(2);
    Planned planned(scene);
    planned.params.lensModel = LENS_AUTO;
    planned.predict();
    EXPECT_EQ(0, planned.variance(5));
    planned.D.at<double>(1) = 0.05;
    planned.predict();
    EXPECT_GT(planned.variance(5), 0);
    EXPECT_GT(planned.variance(6), 0);
    EXPECT_EQ(0, planned.variance(7));
    planned.params.flags = REFINE_FIX_K;
    planned.predict();
    EXPECT_EQ(0, planned.variance(5));
}

TEST(ActiveHandEye_Planning, points_outside_of_the_image_behind_the_camera_or_on_the_back_of_a_plane_are_not_seen)
{
    const RefineScene scene = RefineScene::exact(2);
    Planned planned(scene);
    planned.imageSize = Size(4000, 3000);
    planned.points = (Mat_<double>(4, 3) << 300, 0, 0, 310, 10, 0, 300, 0, 2000, 5000, 0, 0);
    planned.predict();
    EXPECT_EQ(0, cv::norm(planned.seen, Mat(planned.seen.size(), CV_32S, Scalar(2)), NORM_INF));
    planned.surfaces = (Mat_<double>(1, 4) << 0, 0, 2, 0);
    planned.predict();
    EXPECT_EQ(2, planned.seen.at<int>(0)) << "seen from the front";
    planned.surfaces = -planned.surfaces;
    expectError([&] { planned.predict(); }, Error::StsNoConv, {"scenePoints", "given 4 points of which none is"});
}

TEST(ActiveHandEye_Planning, stripes_tell_the_light_plane)
{
    const RefineScene scene = RefineScene::exact(2);
    Planned planned(scene);
    const double without = planned.predict();
    EXPECT_EQ(0, planned.variance(19));
    planned.light = scene.trueLight();
    planned.surfaces = (Mat_<double>(1, 4) << 0, 0, 1, 0);
    EXPECT_LE(planned.predict(), without);
    const double one = planned.variance(19);
    EXPECT_GT(one, 0);
    planned.surfaces = (Mat_<double>(2, 4) << 0, 0, 1, 0, 0.3, 0, 1, 60);
    planned.predict();
    EXPECT_LT(planned.variance(19), one);
    planned.R.resize(1, planned.R[0]);
    planned.t.resize(1);
    planned.R.push_back(planned.R[0]);
    planned.t.push_back(planned.t[0]);
    planned.predict();
    EXPECT_TRUE(std::isinf(planned.variance(19))) << "one place";
}

TEST(ActiveHandEye_Planning, refused_arguments_are_named)
{
    const RefineScene scene = RefineScene::exact(2);
    const auto expectRefused = [&](const std::function<void(Planned&)>& spoil, int code, const vector<string>& parts)
    {
        Planned planned(scene);
        spoil(planned);
        expectError([&] { planned.predict(); }, code, parts);
    };
    expectRefused([](Planned& p) { p.params.pointSigma = -1; }, Error::StsOutOfRange,
                  {"params.pointSigma", "positive", "-1"});
    expectRefused([](Planned& p) { p.params.robotTranslationSigma = p.params.robotRotationSigma = -1; },
                  Error::StsOutOfRange, {"params.robotTranslationSigma", "0 = exact", "-1"});
    expectRefused([](Planned& p) { p.imageSize.width = 0; }, Error::StsOutOfRange, {"imageSize", "0 x 480"});
    expectRefused([](Planned& p) { p.points = Mat(); }, Error::StsBadSize, {"scenePoints", "none"});
    expectRefused([](Planned& p) { p.points = Mat::zeros(5, 2, CV_64F); }, Error::StsBadSize, {"scenePoints"});
    expectRefused([](Planned& p) { p.surfaces = Mat::zeros(2, 3, CV_64F); }, Error::StsBadSize, {"surfaces", "S x 4"});
    expectRefused([](Planned& p) { p.surfaces = Mat::zeros(2, 4, CV_64F); }, Error::StsBadArg, {"surfaces", "normal"});
    expectRefused([&](Planned& p) { p.light = scene.trueLight(); }, Error::StsBadArg, {"surfaces", "lightPlane"});
    expectRefused(
        [&](Planned& p)
        {
            p.light = scene.trueLight();
            p.surfaces = (Mat_<double>(1, 4) << 0, 0, 1, 0);
            p.params.stripeSigma = -1;
        },
        Error::StsOutOfRange, {"params.stripeSigma"});
    expectRefused(
        [](Planned& p)
        {
            p.R.resize(1);
            p.t.resize(1);
        },
        Error::StsBadSize, {"R_gripper2base", "given 1"});
}

}} // namespace opencv_test
