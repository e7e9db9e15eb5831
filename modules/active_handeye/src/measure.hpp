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

typedef Eigen::Matrix<double, 3, 2> Matrix32d;
typedef Eigen::Matrix<double, 3, CALIBRATION_PARAMETERS> PointByCalibration;

//! The point where the ray of a pixel meets the light plane, in the frame of the geometry, and what moves it.
struct ReprojectedPoint
{
    Eigen::Vector3d X;
    Eigen::Vector3d arm;              //!< from the flange to the point: errors of the robot's rotation turn it
    Matrix32d byPixel;                //!< derivative by the pixel of the recorded image
    PointByCalibration byCalibration; //!< derivative by the calibration

    //! `ray`: (x, y, 1) of the pixel.
    ReprojectedPoint(const StripeGeometry& geometry, const Eigen::Vector3d& ray);
};

//! Errors that are known of a measurement, and what they make of points to first order.
struct MeasurementErrors
{
    CalibrationMatrix calibration = CalibrationMatrix::Zero(); //!< rows of parameters not observed are 0
    std::vector<int> unobserved;                               //!< parameters of infinite variance
    double robotTranslationSigma = 0, robotRotationSigma = 0;

    //! Covariance of two points of one view from the error of the robot's pose.
    Eigen::Matrix3d fromRobot(const ReprojectedPoint& a, const ReprojectedPoint& b) const;

    //! Covariance of two points from the errors of the calibration.
    Eigen::Matrix3d fromCalibration(const ReprojectedPoint& a, const ReprojectedPoint& b) const;

    //! Infinite variance for the coordinates that hang on a parameter which was not observed.
    void markUnobserved(const ReprojectedPoint& point, Eigen::Matrix3d& covariance) const;

    //! Of one point, with everything.
    Eigen::Matrix3d covariance(const ReprojectedPoint& point, const Eigen::Matrix2d& pixelCovariance) const;
};

//! The calibration part of the arguments of reprojectStripe and measureStripePoints; the robot's sigmas of 0 or more.
MeasurementErrors readMeasurementErrors(InputArray calibrationCovariance, double robotTranslationSigma,
                                        double robotRotationSigma);

//! Throws StsOutOfRange that names the pixels whose rays do not meet the light plane in front of the camera.
void refuseMissed(const std::vector<size_t>& missed, const Pixels& pixels);

//! Whether the ray meets the light plane in front of the camera.
bool meets(const LightPlane& light, const Eigen::Vector3d& ray);

}} // namespace cv::active_handeye

#endif
