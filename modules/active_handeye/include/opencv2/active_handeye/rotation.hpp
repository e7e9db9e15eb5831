// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_ROTATION_HPP
#define OPENCV_ACTIVE_HANDEYE_ROTATION_HPP

#include "opencv2/core.hpp"

namespace cv { namespace active_handeye {

//! @addtogroup active_handeye_rotation
//! @{

//! What calibrateHandEyeRotation may answer
enum RotationFlags
{
    ROTATION_ALLOW_PARTIAL =
        1 //!< when all rotation axes are parallel: answer, with the component along the axis marked as not observed
};

/** @brief Hand-eye translation from changes of orientation, with K and R_cam2gripper known.

Every image point gives two equations
\f[ [m_{ij}]_\times R_{cam2gripper}^T ( R_i^T (X_j - t_i) - t_{cam2gripper} ) = 0 \f]
that are linear in the scene points X_j and in t_cam2gripper. Each X_j is eliminated; what remains is a 3 x 3 system. Any motion that changes the
orientation contributes; at least two changes about axes that are not parallel are needed, since for one axis a the matrix R - I has the null vector a
(the paper's (43) inverts it), and some translation of the gripper, which gives the scale. See
doc/method/rotation.md.

@param[in] R_gripper2base V rotations (3 x 3) or rotation vectors.
@param[in] t_gripper2base V translations.
@param[in] imagePoints V arrays N x 2 of pixels of the recorded (distorted) images; (NaN, NaN) = not seen. Wrong matches are left out.
@param[in] cameraMatrix 3 x 3.
@param[in] distCoeffs k1, k2, p1, p2[, k3], or empty.
@param[in] R_cam2gripper 3 x 3 rotation or rotation vector.
@param[out] t_cam2gripper 3 x 1, in the unit of t_gripper2base. With ROTATION_ALLOW_PARTIAL and one axis only, its component along the axis is 0.
@param[out] covariance 3 x 3 for given K and R_cam2gripper; it covers image noise and, where the
residuals show it, a jitter of the reported orientations; not other errors of the robot. A component that is
not observed has infinite variance.
@param[in] flags combination of #RotationFlags.
@return RMS distance between image points and their predictions, pixels.
@throws cv::Exception StsBadArg, StsBadSize, StsOutOfRange for wrong input; StsNoConv when the data cannot answer: no change of
orientation, all axes parallel (the axis is named), no translation, no points in common, no parallax, scene points behind the camera
(inverted poses), a view that contradicts the others (named).
*/
CV_EXPORTS_W double calibrateHandEyeRotation(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base,
                                             InputArrayOfArrays imagePoints, InputArray cameraMatrix,
                                             InputArray distCoeffs, InputArray R_cam2gripper, OutputArray t_cam2gripper,
                                             OutputArray covariance = noArray(), int flags = 0);

//! @}

}} // namespace cv::active_handeye

#endif
