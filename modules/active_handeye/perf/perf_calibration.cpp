// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "perf_precomp.hpp"
#include "../test/planned_scene.hpp"

namespace opencv_test { namespace {

using namespace refine;

typedef TestBaseWithParam<int> Points;

//! Nineteen views of seven orientations, with the noise of a good camera and a good robot.
RefineScene scene(int points)
{
    RefineScene result(1, points);
    result.addSurfaces();
    result.addViews();
    result.measure(0.1, 0.02, 0.005, 0.05);
    return result;
}

PERF_TEST_P(Points, estimateFOE, testing::Values(100, 1000))
{
    RefineScene recorded = scene(GetParam());
    Mat second = recorded.imagePoints[3];
    for (int j = 0; j < GetParam(); j += 4) // a quarter of the matches is wrong
        second.at<double>(j, 0) += recorded.rng.uniform(5., 50.);
    Mat foe, mask;
    int inliers = 0;
    TEST_CYCLE() inliers = estimateFOE(recorded.imagePoints[0], second, foe, mask);
    EXPECT_GE(inliers, GetParam() / 2);
    SANITY_CHECK_NOTHING();
}

PERF_TEST_P(Points, calibrateHandEyeTranslations, testing::Values(50, 200))
{
    const RefineScene recorded = scene(GetParam());
    Mat turn;
    double rms = 0;
    TEST_CYCLE()
    {
        Mat K;
        rms = calibrateHandEyeTranslations(recorded.reportedR, recorded.reportedT, recorded.imagePoints, K, noArray(),
                                           turn);
    }
    EXPECT_LT(rms, 5);
    SANITY_CHECK_NOTHING();
}

PERF_TEST_P(Points, calibrateHandEyeRotation, testing::Values(50, 200))
{
    const RefineScene recorded = scene(GetParam());
    Mat translation;
    double rms = 0;
    TEST_CYCLE()
    rms = calibrateHandEyeRotation(recorded.reportedR, recorded.reportedT, recorded.imagePoints, recorded.K, noArray(),
                                   recorded.R_cam2gripper, translation);
    EXPECT_LT(rms, 5);
    SANITY_CHECK_NOTHING();
}

PERF_TEST_P(Points, refineHandEye, testing::Values(50, 200))
{
    const RefineScene recorded = scene(GetParam());
    double rms = 0;
    TEST_CYCLE() rms = recorded.refined().rms;
    EXPECT_LT(rms, 1);
    SANITY_CHECK_NOTHING();
}

PERF_TEST_P(Points, predictHandEyeCovariance, testing::Values(50, 200))
{
    Planned planned(scene(GetParam()));
    TEST_CYCLE() planned.predict();
    EXPECT_GT(planned.sigma, 0);
    SANITY_CHECK_NOTHING();
}

PERF_TEST_P(Points, verifyHandEye, testing::Values(50, 200))
{
    const RefineScene recorded = scene(GetParam());
    const Refinement calibration = recorded.refined();
    VerifySummary summary;
    TEST_CYCLE()
    verifyHandEye(recorded.reportedR, recorded.reportedT, recorded.imagePoints, calibration.K, calibration.D,
                  calibration.R_cam2gripper, calibration.t_cam2gripper, calibration.summary.covariance, summary);
    SANITY_CHECK_NOTHING();
}

}} // namespace opencv_test
