// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// One residual per kind of measurement, with its derivatives in the tangent space of calibration_state.hpp.
#ifndef OPENCV_ACTIVE_HANDEYE_RESIDUALS_HPP
#define OPENCV_ACTIVE_HANDEYE_RESIDUALS_HPP

#include "calibration_state.hpp"

namespace cv { namespace active_handeye {

/** Reprojection error of a scene point, predicted - measured (method.md section 1).

All that moves camera and point rigidly acts through the point: with D = derivative by the point X in the base frame the derivatives are
D [skew(X - centre) R_gripper2base, -R_gripper2base] by the hand-eye transform and D [skew(X - t_gripper2base), -I] by the robot's pose.
*/
struct PointResidual
{
    Eigen::Vector2d error;
    Eigen::Matrix<double, 2, 3> byPoint;
    Eigen::Matrix<double, 2, POINT_COLUMNS> byCalibration;

    //! Error alone; false for a point behind the camera.
    static bool evaluate(const Camera& camera, const CameraView& view, const Eigen::Vector3d& X,
                         const Eigen::Vector2d& pixel, Eigen::Vector2d& error);

    //! Error and derivative by the point.
    bool linearizePoint(const Camera& camera, const CameraView& view, const Eigen::Vector3d& X,
                        const Eigen::Vector2d& pixel);

    //! Error and all derivatives.
    bool linearize(const Camera& camera, const CameraView& view, const Eigen::Vector3d& X,
                   const Eigen::Vector2d& pixel);

    //! Derivative by the robot's pose.
    Eigen::Matrix<double, 2, 6> byPose(const CameraView& view, const Eigen::Vector3d& X) const;
};

//! Derivative of the viewing ray (x, y) of a fixed pixel by fx, fy, cx, cy, skew, k1, k2, p1, p2, k3.
Eigen::Matrix<double, 2, 10> rayByCamera(const Camera& camera, const Eigen::Vector2d& ideal);

/** Distance, in pixels, of one end of a stripe segment from the stripe predicted (method.md section 6).

The surface (w, e) of the base frame is (w_c, e_c) in the camera's; light plane and surface meet in the interpretation plane
e_c n - d w_c, and the ideal ray m of the pixel should lie on it.
*/
struct StripeResidual
{
    double error;
    Eigen::Matrix<double, 1, CALIBRATION_COLUMNS> byCalibration;
    Eigen::Matrix<double, 1, 6> byPose;
    Eigen::Matrix<double, 1, 4> bySurface; //!< (w, e), before its restriction to a tangent space

    //! False where light plane and surface are parallel in the image.
    bool linearize(const HandEyeCalibration& calibration, const CameraView& view, const Eigen::Vector4d& surface,
                   const Eigen::Vector2d& pixel);
};

}} // namespace cv::active_handeye

#endif
