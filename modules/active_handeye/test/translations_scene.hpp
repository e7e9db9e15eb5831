// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#ifndef OPENCV_TEST_ACTIVE_HANDEYE_TRANSLATIONS_SCENE_HPP
#define OPENCV_TEST_ACTIVE_HANDEYE_TRANSLATIONS_SCENE_HPP

#include "point_scene.hpp"

namespace opencv_test { namespace translations {

//! What calibrateHandEyeTranslations() returns.
struct Estimate
{
    double rms;
    Matx33d K, R;
    Mat covariance;
};

inline Estimate calibrate(const PointScene& scene, TranslationsMethod method = TRANSLATIONS_METRIC, int flags = 0,
                          const Mat& given = Mat(), const Mat& dist = Mat())
{
    Estimate estimate;
    Mat K = given.clone(), R;
    estimate.rms = calibrateHandEyeTranslations(scene.R, scene.t, scene.imagePoints, K, dist, R, estimate.covariance,
                                                method, flags);
    estimate.K = K;
    estimate.R = R;
    return estimate;
}

//! One group of translations.
inline PointScene oneGroup(const vector<Vec3d>& offsets, uint64 seed = 1, double noise = 0)
{
    PointScene scene(seed);
    scene.addGroup(Vec3d(), offsets);
    scene.project(noise);
    return scene;
}

}} // namespace opencv_test::translations

#endif
