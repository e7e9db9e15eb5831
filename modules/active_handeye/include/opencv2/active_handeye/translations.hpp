// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_TRANSLATIONS_HPP
#define OPENCV_ACTIVE_HANDEYE_TRANSLATIONS_HPP

#include "opencv2/core.hpp"

namespace cv { namespace active_handeye {

//! @addtogroup active_handeye_translations
//! @{

//! What calibrateHandEyeTranslations solves
enum TranslationsMethod
{
    TRANSLATIONS_METRIC = 0, //!< from all image points and the lengths of the translations
    TRANSLATIONS_FOE = 1     //!< from the directions of the translations alone (paper, (14)-(18))
};

//! What calibrateHandEyeTranslations knows of the camera
enum TranslationsFlags
{
    TRANSLATIONS_FIX_K = 1,        //!< cameraMatrix is known and is not changed
    TRANSLATIONS_ZERO_SKEW = 2,    //!< skew = 0
    TRANSLATIONS_SQUARE_PIXELS = 4 //!< fx = fy and skew = 0
};

/** @brief Camera matrix and hand-eye rotation from pure translations of the gripper.

In the gripper frame of a group of views with equal orientation the gripper moved by b_i, and a fixed scene point has the image
\f$ x_{ij} \sim Z_j - P b_i \f$ with \f$ P = K R_{cam2gripper}^T \f$ and one unknown 3-vector \f$ Z_j \f$ for each point. This is linear in all
unknowns. TRANSLATIONS_METRIC eliminates every Z_j and solves for P, from all groups at once. TRANSLATIONS_FOE estimates the focus of expansion of
every translation from the first view of its group and solves \f$ e_i \sim P b_i \f$ (paper, (16)-(17)), which uses directions only. P is split into K and R
by RQ decomposition, then flags are applied by constrained least squares on the same quadratic form.

Translations needed: METRIC three not coplanar ones; FOE four of which no three are coplanar; with TRANSLATIONS_FIX_K two not parallel ones. They may be
spread over groups. See doc/method/translations.md.

@param[in] R_gripper2base V rotations (3 x 3) or rotation vectors.
@param[in] t_gripper2base V translations, any unit of length.
@param[in] imagePoints V arrays N x 2 of pixels of the recorded (distorted) images; row j is the same scene point in every view, (NaN, NaN) =
not seen. Wrong matches are found by their residuals and left out.
@param[in,out] cameraMatrix 3 x 3. In: K for TRANSLATIONS_FIX_K; otherwise empty, or a first guess for removing the distortion. Out: K.
@param[in] distCoeffs k1, k2, p1, p2[, k3], known beforehand, or empty. With K unknown, distortion is removed with the last K in turn
until K no longer changes.
@param[out] R_cam2gripper 3 x 3.
@param[out] covariance 8 x 8, of fx, fy, cx, cy, skew [pixels] and the rotation error vector in the gripper frame [rad]
(true R = exp(error) R_cam2gripper); rows of fixed parameters are zero. It covers image noise and, where
the residuals show it, a jitter of the reported orientations, both estimated; not other errors of the robot.
@param[in] method see #TranslationsMethod.
@param[in] flags combination of #TranslationsFlags.
@param[in] orientationTolerance views whose orientations differ by less than this belong to one group, degrees.
@return RMS distance between image points and their predictions, pixels.
@throws cv::Exception StsBadArg, StsBadSize, StsOutOfRange for wrong input; StsNoConv when the data cannot answer: no two views of equal
orientation (the nearest are named), no points in common, no parallax, translations parallel or coplanar (the missing direction is given in
base coordinates), a view that contradicts the others (named).
*/
CV_EXPORTS_W double calibrateHandEyeTranslations(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base,
                                                 InputArrayOfArrays imagePoints, InputOutputArray cameraMatrix,
                                                 InputArray distCoeffs, OutputArray R_cam2gripper,
                                                 OutputArray covariance = noArray(),
                                                 TranslationsMethod method = TRANSLATIONS_METRIC, int flags = 0,
                                                 double orientationTolerance = 0.05);

/** @brief Groups of views between which the gripper only translated.

A view joins the first group whose first view has the same orientation within orientationTolerance; every view is in one group.
See doc/method/translations.md.

@param[in] R_gripper2base V rotations (3 x 3) or rotation vectors.
@param[out] groupIds V x 1, 32-bit; groups are numbered from 0 in the order of their first views.
@param[in] orientationTolerance degrees.
@throws cv::Exception StsBadArg, StsBadSize, StsOutOfRange for wrong input.
*/
CV_EXPORTS_W void groupViews(InputArrayOfArrays R_gripper2base, OutputArray groupIds,
                             double orientationTolerance = 0.05);

//! @}

}} // namespace cv::active_handeye

#endif
