// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#ifndef OPENCV_TEST_ACTIVE_HANDEYE_PLANNED_SCENE_HPP
#define OPENCV_TEST_ACTIVE_HANDEYE_PLANNED_SCENE_HPP

#include "refine_scene.hpp"

namespace opencv_test { namespace refine {

//! Noise levels of a prediction.
inline RefineParams levels(int flags = 0, int lensModel = LENS_FIXED)
{
    RefineParams params;
    params.flags = flags;
    params.lensModel = lensModel;
    params.pointSigma = 0.1;
    params.stripeSigma = 0.05;
    params.robotTranslationSigma = 0.02;
    params.robotRotationSigma = 0.005 * CV_PI / 180;
    return params;
}

//! Arguments and results of one call of predictHandEyeCovariance() or planHandEyeViews().
struct Planned
{
    explicit Planned(const RefineScene& scene)
        : points(int(scene.X.size()), 3, CV_64F), K(scene.K), D(scene.dist()), R_cam2gripper(scene.R_cam2gripper),
          t_cam2gripper(scene.t_cam2gripper)
    {
        for (size_t view = 0; view < scene.R.size(); ++view)
        {
            R.push_back(scene.R[view].clone());
            t.push_back(scene.t[view].clone());
        }
        for (size_t j = 0; j < scene.X.size(); ++j)
            for (int k = 0; k < 3; ++k)
                points.at<double>(int(j), k) = scene.X[j][k];
    }

    double predict()
    {
        sigma = predictHandEyeCovariance(R, t, points, imageSize, K, D, R_cam2gripper, t_cam2gripper, covariance, weak,
                                         seen, light, surfaces, params);
        return sigma;
    }

    double plan(int stops)
    {
        sigma = planHandEyeViews(R, t, points, imageSize, K, D, R_cam2gripper, t_cam2gripper, stops, chosen, taken,
                                 params, planParams);
        return sigma;
    }

    double variance(int i) const { return covariance.at<double>(i, i); }

    vector<Mat> R, t;
    Mat points, K, D, R_cam2gripper, t_cam2gripper, light, surfaces, taken;
    Size imageSize = Size(640, 480);
    RefineParams params = levels();
    PlanParams planParams;
    Mat covariance, seen;
    vector<string> weak;
    vector<int> chosen;
    double sigma = -1;
};

}} // namespace opencv_test::refine

#endif
