// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "translations_scene.hpp"

namespace opencv_test { namespace {

using namespace translations;

Vec3d randomVector(RNG& rng, double sigma)
{
    Vec3d v;
    for (int k = 0; k < 3; ++k)
        v[k] = rng.gaussian(sigma);
    return v;
}

//! A camera of any orientation on the flange, moved by any `count` translations; `flatness` scales one direction of them.
PointScene randomScene(uint64 seed, int count, double flatness, double noise)
{
    PointScene scene(seed);
    scene.R_cam2gripper = rotation(randomVector(scene.rng, 1.5));
    const Matx33d frame = rotation(randomVector(scene.rng, 1.5));
    vector<Vec3d> offsets(1, Vec3d());
    for (int k = 0; k < count; ++k)
    {
        Vec3d offset = randomVector(scene.rng, 30);
        offset[2] *= flatness;
        offsets.push_back(frame * offset);
    }
    scene.addGroup(Vec3d(), offsets);
    scene.project(noise);
    return scene;
}

TEST(ActiveHandEye_TranslationsFixK, two_or_three_FOEs_find_every_rotation)
{
    for (int trial = 0; trial < 40; ++trial)
    {
        const PointScene scene = randomScene(100 + trial, 2 + trial % 2, 1, 0);
        const Estimate estimate = calibrate(scene, TRANSLATIONS_FOE, TRANSLATIONS_FIX_K, Mat(scene.K));
        EXPECT_LE(cv::norm(estimate.R - scene.R_cam2gripper, NORM_INF), 1e-7) << "trial " << trial;
    }
}

TEST(ActiveHandEye_TranslationsFixK, translations_of_almost_one_plane_are_met_exactly)
{
    for (int trial = 0; trial < 40; ++trial)
    {
        const PointScene scene = randomScene(200 + trial, 3, 0.008, 0);
        const Estimate estimate = calibrate(scene, TRANSLATIONS_METRIC, TRANSLATIONS_FIX_K, Mat(scene.K));
        EXPECT_LE(cv::norm(estimate.R - scene.R_cam2gripper, NORM_INF), 1e-7) << "trial " << trial;
    }
}

//! e^T C^-1 e of the rotation error e has the mean 3, and over 60 trials the standard deviation 0.32.
TEST(ActiveHandEye_TranslationsFixK, covariance_predicts_the_error_for_translations_of_almost_one_plane)
{
    const int trials = 60;
    double sum = 0;
    for (int trial = 0; trial < trials; ++trial)
    {
        const PointScene scene = randomScene(300 + trial, 6, 0.008, 0.1);
        const Estimate estimate = calibrate(scene, TRANSLATIONS_METRIC, TRANSLATIONS_FIX_K, Mat(scene.K));
        const Matx33d dR = scene.R_cam2gripper * estimate.R.t();
        const Mat error(Vec3d(dR(2, 1) - dR(1, 2), dR(0, 2) - dR(2, 0), dR(1, 0) - dR(0, 1)) * 0.5);
        const Mat covariance = estimate.covariance(Range(5, 8), Range(5, 8));
        sum += error.dot(covariance.inv(DECOMP_CHOLESKY) * error);
    }
    EXPECT_NEAR(3, sum / trials, 1.3); // 4 standard deviations
}

}} // namespace opencv_test
