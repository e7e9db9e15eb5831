// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "refine_scene.hpp"

namespace opencv_test { namespace {

using namespace refine;

//! The call with everything as start.
Refinement started(const RefineScene& scene, int flags)
{
    Refinement call = scene.call();
    call.K = Mat(scene.K).clone();
    call.D = scene.dist().clone();
    call.R_cam2gripper = Mat(scene.R_cam2gripper).clone();
    call.t_cam2gripper = Mat(scene.t_cam2gripper).clone();
    call.light = scene.surfaces.empty() ? Mat() : scene.trueLight();
    call.params.flags = flags;
    return call;
}

RefineScene distortedStripedScene()
{
    RefineScene scene(2);
    scene.D[0] = -0.1;
    scene.addViews();
    scene.addSurfaces();
    scene.measure(0.1, 0.02, 0.005, 0.05);
    return scene;
}

TEST(ActiveHandEye_RefineFlags, what_is_fixed_keeps_its_bits)
{
    const RefineScene scene = distortedStripedScene();
    const vector<string> K = {"fx", "fy", "cx", "cy", "skew"}, D = {"k1", "k2", "p1", "p2", "k3"},
                         R = {"rx", "ry", "rz"}, t = {"tx", "ty", "tz"}, light = {"nx", "ny", "nz", "d"};
    const Refinement given = started(scene, 0);

    Refinement camera = started(scene, REFINE_FIX_K);
    camera.run();
    EXPECT_TRUE(sameBits(given.K, camera.K));
    EXPECT_TRUE(sameBits(given.D.t(), camera.D)) << "LENS_AUTO is LENS_FIXED with REFINE_FIX_K";
    EXPECT_EQ(int(LENS_FIXED), camera.summary.lensModel);
    expectFixed(camera, K);
    expectFixed(camera, D);
    expectFree(camera, {"rx", "tz", "nx", "d"});

    Refinement rotation = started(scene, REFINE_FIX_ROTATION);
    rotation.run();
    EXPECT_TRUE(sameBits(given.R_cam2gripper, rotation.R_cam2gripper));
    expectFixed(rotation, R);
    expectFree(rotation, {"fx", "cx", "tx", "ny"});

    Refinement translation = started(scene, REFINE_FIX_TRANSLATION);
    translation.run();
    EXPECT_TRUE(sameBits(given.t_cam2gripper, translation.t_cam2gripper));
    expectFixed(translation, t);
    expectFree(translation, {"fy", "cy", "ry", "nz"});

    Refinement plane = started(scene, REFINE_FIX_LIGHT_PLANE);
    plane.run();
    EXPECT_TRUE(sameBits(given.light, plane.light));
    expectFixed(plane, light);
    expectFree(plane, {"fx", "rz", "ty"});
}

TEST(ActiveHandEye_RefineFlags, pixels_that_are_not_square_as_they_should_be_are_not_usable)
{
    const RefineScene scene = RefineScene::noisy(4);
    for (const double wrong : {0.0, 2e-3})
    {
        Refinement call = started(scene, REFINE_FIX_ASPECT);
        call.K.at<double>(1, 1) *= 1 + wrong;
        call.run();
        EXPECT_EQ(wrong == 0, call.summary.usable) << call.summary.message;
        EXPECT_NEAR(scene.K(1, 1) / scene.K(0, 0) * (1 + wrong), call.K.at<double>(1, 1) / call.K.at<double>(0, 0),
                    1e-12);
        EXPECT_EQ(wrong > 0, call.summary.message.find("REFINE_FIX_ASPECT") != string::npos);
    }
}

TEST(ActiveHandEye_RefineFlags, fixing_what_is_true_makes_the_rest_better)
{
    const RefineScene scene = RefineScene::noisy(4);
    Refinement free = started(scene, 0), fixed = started(scene, REFINE_FIX_K | REFINE_FIX_ROTATION);
    for (Refinement* call : {&free, &fixed})
    {
        call->params.pointSigma = 0.1;
        call->params.robotTranslationSigma = 0.02;
        call->params.robotRotationSigma = 0.005 * CV_PI / 180;
        call->params.lensModel = LENS_FIXED;
        call->run();
        EXPECT_LE(scene.worstError(*call), 4);
    }
    for (const char* name : {"tx", "ty", "tz"})
        EXPECT_LT(fixed.deviation(name), 0.95 * free.deviation(name));
}

TEST(ActiveHandEye_RefineFlags, aspect_stays)
{
    RefineScene scene = RefineScene::noisy(5);
    Refinement given = started(scene, REFINE_FIX_ASPECT);
    given.K.at<double>(0, 0) *= 1.01;
    given.K.at<double>(1, 1) *= 1.01;
    given.run();
    EXPECT_NEAR(scene.K(1, 1) / scene.K(0, 0), given.K.at<double>(1, 1) / given.K.at<double>(0, 0), 1e-14);
    EXPECT_LE(scene.worstError(given), 4.5);
    const double ratio = scene.K(1, 1) / scene.K(0, 0);
    EXPECT_NEAR(ratio * given.deviation("fx"), given.deviation("fy"), 1e-9);
    EXPECT_NEAR(ratio * given.variance("fx", "fx"), given.variance("fx", "fy"), 1e-9);

    scene.K(1, 1) = scene.K(0, 0);
    scene.measure(0.1, 0.02, 0.005);
    Refinement square = scene.call();
    square.params.flags = REFINE_FIX_ASPECT;
    square.run();
    EXPECT_NEAR(1, square.K.at<double>(1, 1) / square.K.at<double>(0, 0), 1e-14);
    EXPECT_LE(scene.worstError(square), 4.5);
}

TEST(ActiveHandEye_RefineFlags, skew_is_estimated_when_told)
{
    RefineScene scene(6);
    scene.K(0, 1) = 2.5;
    scene.addViews();
    scene.measure(0, 0, 0);
    Refinement exact = scene.call();
    exact.params.flags = REFINE_SKEW;
    exact.run();
    EXPECT_NEAR(2.5, exact.K.at<double>(0, 1), 1e-8);
    expectFree(exact, {"skew"});
    Refinement kept = started(scene, 0);
    kept.run();
    EXPECT_EQ(2.5, kept.K.at<double>(0, 1));
    expectFixed(kept, {"skew"});
    EXPECT_LE(cv::norm(kept.translation() - scene.t_cam2gripper), 1e-7);
    scene.measure(0.1, 0.02, 0.005);
    Refinement noisy = scene.call();
    noisy.params.flags = REFINE_SKEW;
    noisy.run();
    EXPECT_LE(scene.worstError(noisy), 4.5);
    EXPECT_GT(std::abs(noisy.K.at<double>(0, 1)), 3 * noisy.deviation("skew"));
}

TEST(ActiveHandEye_RefineFlags, a_lens_model_estimates_its_coefficients_and_keeps_the_others)
{
    RefineScene scene(7);
    scene.D[3] = 0.001;
    scene.addViews();
    scene.measure(0.1, 0.02, 0.005);
    const int counts[] = {0, 1, 2, 4, 5};
    const char* const names[] = {"k1", "k2", "p1", "p2", "k3"};
    for (int model = LENS_FIXED; model <= LENS_K3; ++model)
    {
        Refinement call = started(scene, 0);
        call.D.at<double>(4) = 1e-3;
        call.params.lensModel = model;
        call.run();
        EXPECT_EQ(model, call.summary.lensModel);
        for (int i = 0; i < 5; ++i)
        {
            EXPECT_EQ(i < counts[model], call.deviation(names[i]) > 0) << names[i] << " of model " << model;
            const double start = i == 3 ? 0.001 : i == 4 ? 1e-3 : 0;
            EXPECT_EQ(i < counts[model], call.D.at<double>(i) != start) << names[i] << " of model " << model;
        }
        EXPECT_EQ(5 - counts[model], int(call.summary.lensTests.at<double>(model, 1)));
    }
}

TEST(ActiveHandEye_RefineFlags, the_lens_model_is_found_and_a_missing_one_is_told)
{
    const double lenses[][5] = {
        {0, 0, 0, 0, 0}, {-0.1, 0, 0, 0, 0}, {-0.2, 0.6, 0, 0, 0}, {-0.1, 0.1, 0.002, -0.003, 0}};
    for (int model = LENS_FIXED; model <= LENS_TANGENTIAL; ++model)
    {
        RefineScene scene(20 + model, 80);
        std::copy(lenses[model], lenses[model] + 5, scene.D);
        scene.addViews();
        scene.measure(0.05, 0.01, 0.002);
        const Refinement found = scene.refined();
        EXPECT_EQ(model, found.summary.lensModel);
        EXPECT_TRUE(found.summary.usable);
        EXPECT_LE(scene.worstError(found), 4.5);
        for (int smaller = LENS_FIXED; smaller < model; ++smaller)
            EXPECT_LT(found.summary.lensTests.at<double>(smaller, 2), 0.01);
        EXPECT_EQ(1, found.summary.lensTests.at<double>(LENS_K3, 2));
        if (model == LENS_FIXED)
            continue;
        Refinement none = started(scene, 0);
        none.D = Mat();
        none.params.lensModel = LENS_FIXED;
        none.run();
        EXPECT_FALSE(none.summary.usable);
        EXPECT_NE(string::npos, none.summary.message.find("lens")) << none.summary.message;
        EXPECT_LT(none.summary.lensTests.at<double>(LENS_FIXED, 2), 1e-4);
    }
}

//! Groups of translations, turned about one axis of the gripper (or none). The reports are exact in this; the robot is not.
RefineScene turningAbout(const Vec3d& axis, double noise)
{
    RefineScene scene(8);
    vector<double> angles(1, 0.);
    if (cv::norm(axis) > 0)
        angles = {0., 0.3, -0.25};
    for (double angle : angles)
    {
        const Matx33d R = rotation(Vec3d(3.1, 0.1, 0.05)) * rotation(axis * angle),
                      cameraToBase = R * scene.R_cam2gripper;
        for (const Vec3d& offset : PointScene::fourTranslations())
        {
            scene.R.push_back(Mat(R));
            scene.t.push_back(Mat(Vec3d(Vec3d(300, 0, 0) - cameraToBase * (Vec3d(0, 0, 550) - offset) -
                                        R * scene.t_cam2gripper)));
        }
    }
    const vector<Mat> R = scene.R, t = scene.t;
    scene.measure(0, 0.02 * noise, 0.005 * noise);
    scene.R = scene.reportedR; // so far true is what was meant to be reported
    scene.t = scene.reportedT;
    scene.project(0.1 * noise);
    scene.reportedR = R;
    scene.reportedT = t;
    return scene;
}

TEST(ActiveHandEye_RefineFlags, one_axis_of_rotation_is_refused_or_marked)
{
    const Vec3d axis = Vec3d(1, 2, -1) * (1 / std::sqrt(6.));
    const RefineScene scene = turningAbout(axis, 0);
    expectError([&] { scene.refined(); }, Error::StsNoConv, {"(0.41, 0.82, -0.41)", "add", "REFINE_ALLOW_PARTIAL"});
    Refinement partial = scene.call();
    partial.params.flags = REFINE_ALLOW_PARTIAL;
    partial.run();
    const Vec3d error = partial.translation() - scene.t_cam2gripper;
    EXPECT_LE(cv::norm(error - axis * axis.dot(error)), 1e-6);
    EXPECT_LE(angleDeg(partial.R_cam2gripper, scene.R_cam2gripper), 1e-7);
    const char* const names[] = {"tx", "ty", "tz"};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            EXPECT_EQ(std::copysign(infinity, axis[i] * axis[j]), partial.variance(names[i], names[j]));
    EXPECT_TRUE(std::isinf(partial.deviation("ty")));
    const double* interval = partial.summary.intervals95.ptr<double>(partial.row("tx"));
    EXPECT_EQ(-infinity, interval[0]);
    EXPECT_EQ(infinity, interval[1]);
    ASSERT_FALSE(partial.summary.weakDirections.empty());
    EXPECT_NE(string::npos, partial.summary.weakDirections.back().find("t_cam2gripper along gripper"));

    const RefineScene noisy = turningAbout(Vec3d(0, 0, 1), 1);
    Refinement scara = noisy.call();
    scara.params.flags = REFINE_ALLOW_PARTIAL;
    scara.run();
    EXPECT_TRUE(std::isinf(scara.variance("tz", "tz")));
    EXPECT_LE(std::abs(scara.variance("tx", "tz")), 1e-12);
    EXPECT_GT(scara.deviation("tx"), 0.01);
    for (int i = 0; i < 2; ++i)
        EXPECT_LE(std::abs(scara.translation()[i] - noisy.t_cam2gripper[i]), 4 * scara.deviation(names[i]));
    EXPECT_LE(std::abs(scara.K.at<double>(0, 0) - noisy.K(0, 0)), 4 * scara.deviation("fx"));
}

TEST(ActiveHandEye_RefineFlags, a_cartesian_robot_gets_all_but_the_translation)
{
    const RefineScene scene = turningAbout(Vec3d(), 0);
    expectError([&] { scene.refined(); }, Error::StsNoConv,
                {"t_cam2gripper", "about two axes that are not parallel", "REFINE_ALLOW_PARTIAL"});
    Refinement partial = scene.call();
    partial.params.flags = REFINE_ALLOW_PARTIAL;
    partial.run();
    EXPECT_LE(cv::norm(Matx33d(partial.K) - scene.K), 1e-6);
    EXPECT_LE(angleDeg(partial.R_cam2gripper, scene.R_cam2gripper), 1e-7);
    for (const char* name : {"tx", "ty", "tz"})
    {
        EXPECT_TRUE(std::isinf(partial.deviation(name))) << name;
        EXPECT_EQ(0, partial.variance(name, "fx")) << name;
    }
    expectFree(partial, {"fx", "cx", "rx"});
    EXPECT_TRUE(std::isfinite(partial.deviation("rx")));
    EXPECT_FALSE(partial.summary.weakDirections.empty());
}

}} // namespace opencv_test
