// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "calibration_state.hpp"

namespace cv { namespace active_handeye {

Pose moved(const Pose& pose, const Vector6d& step)
{
    return Pose{expRotation(step.head<3>()) * pose.R, pose.t + step.tail<3>()};
}

HandEyeCalibration HandEyeCalibration::moved(const CalibrationStep& step) const
{
    HandEyeCalibration result = *this;
    Eigen::Matrix3d& K = result.camera.K;
    K(0, 0) += step(COLUMN_FX);
    K(1, 1) += step(COLUMN_FY);
    K(0, 2) += step(COLUMN_CX);
    K(1, 2) += step(COLUMN_CY);
    K(0, 1) += step(COLUMN_SKEW);
    for (int i = 0; i < 5; ++i)
        result.camera.D[i] += step(COLUMN_DISTORTION + i);
    result.cam2gripper = active_handeye::moved(cam2gripper, step.segment<6>(COLUMN_ROTATION));
    result.light.n = (light.n + tangentBasis(light.n) * step.segment<2>(COLUMN_NORMAL)).normalized();
    result.light.d += step(COLUMN_OFFSET);
    return result;
}

CameraViews CalibrationState::views() const
{
    CameraViews result;
    result.reserve(gripper2base.size());
    for (const Pose& pose : gripper2base)
        result.push_back(CameraView(pose, calibration.cam2gripper));
    return result;
}

}} // namespace cv::active_handeye
