// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_MEASURE_SRC_HPP
#define OPENCV_ACTIVE_HANDEYE_MEASURE_SRC_HPP

#include "light_plane_problem.hpp"

namespace cv { namespace active_handeye {

//! Order of RefineSummary::covariance.
enum CalibrationParameter
{
    PARAMETER_CAMERA,                               //!< fx, fy, cx, cy, skew, k1, k2, p1, p2, k3
    PARAMETER_ROTATION = PARAMETER_CAMERA + 10,     //!< rx, ry, rz: true R_cam2gripper = exp(r) R_cam2gripper
    PARAMETER_TRANSLATION = PARAMETER_ROTATION + 3, //!< tx, ty, tz
    PARAMETER_NORMAL = PARAMETER_TRANSLATION + 3,   //!< nx, ny, nz
    PARAMETER_OFFSET = PARAMETER_NORMAL + 3,        //!< d
    CALIBRATION_PARAMETERS
};

typedef Eigen::Matrix<double, CALIBRATION_PARAMETERS, CALIBRATION_PARAMETERS> CalibrationMatrix;

//! From a viewing ray to a point in space.
struct StripeGeometry
{
    enum Frame
    {
        CAMERA,
        GRIPPER,
        BASE
    };

    Camera camera;
    LightPlane light;
    Frame frame;                    //!< of the points
    Pose cam2gripper, gripper2base; //!< identity beyond that frame

    Pose cam2frame() const
    {
        return Pose{gripper2base.R * cam2gripper.R, gripper2base.R * cam2gripper.t + gripper2base.t};
    }
};

//! Errors that are known of a measurement, and what they make of a point to first order.
struct MeasurementErrors
{
    CalibrationMatrix calibration = CalibrationMatrix::Zero(); //!< rows of parameters not observed are 0
    std::vector<int> unobserved;                               //!< parameters of infinite variance
    double robotTranslationSigma = 0, robotRotationSigma = 0;

    //! Covariance of the point where the ray (x, y, 1) meets the light plane, in the frame of the geometry.
    Eigen::Matrix3d covariance(const StripeGeometry& geometry, const Eigen::Vector3d& ray, double pixelSigma) const;
};

}} // namespace cv::active_handeye

#endif
