// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#ifndef OPENCV_TEST_ACTIVE_HANDEYE_MEASURE_SCENE_HPP
#define OPENCV_TEST_ACTIVE_HANDEYE_MEASURE_SCENE_HPP

#include "stripe_scene.hpp"

namespace opencv_test {

typedef Matx<double, 20, 20> Matx20d;
typedef Vec<double, 20> Vec20d;

//! What reprojectStripe is called with; metres.
struct Measurement
{
    Mat pixels;
    Matx33d K;
    Mat D;
    Vec4d light;
    Matx33d R_cam2gripper;
    Vec3d t_cam2gripper;
    Matx33d R_gripper2base;
    Vec3d t_gripper2base;

    explicit Measurement(const StripeScene& scene, int segment = 0)
        : pixels(scene.points[segment]), K(scene.K), D(Mat(scene.D).clone()),
          light(scene.n[0], scene.n[1], scene.n[2], scene.d), R_cam2gripper(scene.R_cam2gripper),
          t_cam2gripper(scene.t_cam2gripper), R_gripper2base(scene.R[scene.views[segment]]),
          t_gripper2base(scene.t[scene.views[segment]])
    {}

    //! The true calibration if the errors of the one given are `error`, in the order of RefineSummary::covariance.
    Measurement corrected(const Vec20d& error) const
    {
        Measurement result = *this;
        result.D = D.clone();
        const int row[] = {0, 1, 0, 1, 0}, col[] = {0, 1, 2, 2, 1};
        for (int i = 0; i < 5; ++i)
        {
            result.K(row[i], col[i]) += error[i];
            result.D.ptr<double>()[i] += error[5 + i];
        }
        result.R_cam2gripper = rotation(Vec3d(error[10], error[11], error[12])) * R_cam2gripper;
        result.t_cam2gripper += Vec3d(error[13], error[14], error[15]);
        for (int i = 0; i < 4; ++i)
            result.light[i] += error[16 + i];
        result.light *= 1 / cv::norm(Vec3d(result.light[0], result.light[1], result.light[2])); // the same plane
        return result;
    }

    enum Frame
    {
        CAMERA,
        GRIPPER,
        BASE
    };

    Mat points(Frame frame) const
    {
        Mat result;
        if (frame == CAMERA)
            reprojectStripe(pixels, K, D, light, result);
        else if (frame == GRIPPER)
            reprojectStripe(pixels, K, D, light, result, noArray(), R_cam2gripper, t_cam2gripper);
        else
            reprojectStripe(pixels, K, D, light, result, noArray(), R_cam2gripper, t_cam2gripper, R_gripper2base,
                            t_gripper2base);
        return result;
    }

    Mat covariances(Frame frame, InputArray calibration, InputArray pixelSigmas = noArray(),
                    double robotTranslation = 0, double robotRotation = 0) const
    {
        Mat result, X;
        const bool hand = frame != CAMERA, base = frame == BASE;
        reprojectStripe(pixels, K, D, light, X, result, hand ? Mat(R_cam2gripper) : Mat(),
                        hand ? Mat(t_cam2gripper) : Mat(), base ? Mat(R_gripper2base) : Mat(),
                        base ? Mat(t_gripper2base) : Mat(), calibration, pixelSigmas, robotTranslation, robotRotation);
        return result;
    }
};

inline StripeScene litScene()
{
    StripeScene scene = StripeScene::standard();
    scene.columnStep = 30;
    scene.shine();
    return scene;
}

} // namespace opencv_test

#endif
