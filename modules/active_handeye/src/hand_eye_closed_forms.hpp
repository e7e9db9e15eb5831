// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// The closed forms of calibrateHandEye, one after another, from their papers.
#ifndef OPENCV_ACTIVE_HANDEYE_HAND_EYE_CLOSED_FORMS_HPP
#define OPENCV_ACTIVE_HANDEYE_HAND_EYE_CLOSED_FORMS_HPP

#include "hand_eye_motions.hpp"

namespace cv { namespace active_handeye {

//! cam2gripper by one of the first five methods. Throws StsNoConv where it is not determined by this method.
Pose handEyeClosedForm(const HandEyeMotions& motions, HandEyeMethod method);

//! R_cam2gripper that turns the gripper's rotation vectors best into the camera's (Park and Martin 1994).
Eigen::Matrix3d rotationFromLogarithms(const HandEyeMotions& motions);

//! t_cam2gripper of (R_A - I) t = R t_B - t_A by least squares.
Eigen::Vector3d translationOf(const HandEyeMotions& motions, const Eigen::Matrix3d& R_cam2gripper);

}} // namespace cv::active_handeye

#endif
