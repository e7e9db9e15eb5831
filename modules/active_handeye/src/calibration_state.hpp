// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Everything that a joint refinement estimates, and the tangent space in which it takes its steps.
#ifndef OPENCV_ACTIVE_HANDEYE_CALIBRATION_STATE_HPP
#define OPENCV_ACTIVE_HANDEYE_CALIBRATION_STATE_HPP

#include "camera.hpp"
#include "light_plane_problem.hpp"
#include "pose.hpp"

namespace cv { namespace active_handeye {

//! Tangent space of the calibration. R_cam2gripper <- exp(step) R_cam2gripper; the normal of the light plane moves along tangentBasis(n).
enum CalibrationColumn
{
    COLUMN_FX,
    COLUMN_FY,
    COLUMN_CX,
    COLUMN_CY,
    COLUMN_SKEW,
    COLUMN_DISTORTION,
    COLUMN_ROTATION = COLUMN_DISTORTION + 5,
    COLUMN_TRANSLATION = COLUMN_ROTATION + 3,
    POINT_COLUMNS = COLUMN_TRANSLATION + 3, //!< what image points depend on
    COLUMN_NORMAL = POINT_COLUMNS,
    COLUMN_OFFSET = COLUMN_NORMAL + 2,
    CALIBRATION_COLUMNS
};

typedef Eigen::Matrix<double, CALIBRATION_COLUMNS, 1> CalibrationStep;
typedef Eigen::Matrix<double, 6, 1> Vector6d;

//! Rotation vector and translation of a pose step: R <- exp(step) R, t <- t + step.
Pose moved(const Pose& pose, const Vector6d& step);

//! Camera, hand-eye transform and light plane.
struct HandEyeCalibration
{
    Camera camera;
    Pose cam2gripper = Pose{Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero()};
    LightPlane light = LightPlane{Eigen::Vector3d::UnitZ(), 0};

    HandEyeCalibration moved(const CalibrationStep& step) const;
};

//! Where the camera of one view is.
struct CameraView
{
    CameraView(const Pose& gripper2base, const Pose& cam2gripper)
        : gripper(gripper2base), R_cam2base(gripper.R * cam2gripper.R), R_base2cam(R_cam2base.transpose()),
          centre(gripper.R * cam2gripper.t + gripper.t)
    {}

    Eigen::Vector3d toCamera(const Eigen::Vector3d& X) const { return R_base2cam * (X - centre); }

    Pose gripper; //!< gripper2base
    Eigen::Matrix3d R_cam2base, R_base2cam;
    Eigen::Vector3d centre; //!< of the camera, base frame
};

struct CalibrationState
{
    HandEyeCalibration calibration;
    Pose object2base = Pose{Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero()}; //!< frame of the known points
    AlignedVector<Eigen::Vector4d> surfaces; //!< (w, e), |.| = 1, w.X = e in the base frame
    AlignedVector<Pose> gripper2base;        //!< corrected robot poses
    AlignedVector<Eigen::Vector3d> points;   //!< base frame, one per track

    std::vector<CameraView, Eigen::aligned_allocator<CameraView>> views() const;
};

typedef std::vector<CameraView, Eigen::aligned_allocator<CameraView>> CameraViews;

}} // namespace cv::active_handeye

#endif
