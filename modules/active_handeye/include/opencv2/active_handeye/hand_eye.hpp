// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_HAND_EYE_HPP
#define OPENCV_ACTIVE_HANDEYE_HAND_EYE_HPP

#include "opencv2/core.hpp"

#include <string>
#include <vector>

namespace cv { namespace active_handeye {

//! @addtogroup active_handeye_hand_eye
//! @{

//! Methods of calibrateHandEye; the first five are those of cv::calibrateHandEye, with the same numbers
enum HandEyeMethod
{
    CALIB_HAND_EYE_TSAI = 0,    //!< rotation, then translation, from turns of 17 to 116 degrees @cite Tsai1989
    CALIB_HAND_EYE_PARK = 1,    //!< rotation by logarithms, then translation @cite Park1994
    CALIB_HAND_EYE_HORAUD = 2,  //!< rotation by quaternions, then translation @cite Horaud1995
    CALIB_HAND_EYE_ANDREFF = 3, //!< both at once, linear; depends on the unit of length @cite Andreff1999
    CALIB_HAND_EYE_DANIILIDIS =
        4,                     //!< both at once, dual quaternions; depends on the unit of length @cite Daniilidis1999
    CALIB_HAND_EYE_REFINED = 5 //!< maximum likelihood, wrong views left out; see #calibrateHandEyeExtended
};

/** @brief Hand-eye transform from poses of the robot and poses of a target, as cv::calibrateHandEye, but checked.

For every pair of views i, j the motion of the gripper \f$A = G_j^{-1} G_i\f$ and that of the camera \f$B = C_j C_i^{-1}\f$ satisfy
\f[ A X = X B \f]
with G = gripper to base, C = target to camera and X = camera to gripper. Two turns about axes that are not parallel
are needed, hence at least three views. On exact data all methods give the same; on noisy data the first five give what OpenCV's methods of the
same name do. Motions that do not determine X, and poses that contradict each other, are refused by every method.

For a camera that is fixed beside the robot (eye-to-hand) pass the inverted robot poses; the result is camera to base.
See doc/method/hand_eye.md.

@param[in] R_gripper2base V rotations `(3x3)` or rotation vectors, V >= 3.
@param[in] t_gripper2base V translations of 3 numbers, `(3x1)` or `(1x3)`, any unit of length.
@param[in] R_target2cam V rotations `(3x3)` or rotation vectors, from the target to the camera.
@param[in] t_target2cam V translations, in the unit of t_gripper2base.
@param[out] R_cam2gripper `(3x3)`.
@param[out] t_cam2gripper `(3x1)`, in the unit of the translations.
@param[in] method a #HandEyeMethod.
@throws cv::Exception StsBadArg, StsBadSize, StsOutOfRange for wrong input (numbers that are not finite, no rotation, lists of
different lengths, an unknown method, two units of length); StsNoConv when the poses do not determine the result: no turn, all
axes parallel (the axis is named), turns too small or too large for CALIB_HAND_EYE_TSAI, poses that contradict each other (it is
said when they would agree inverted).
*/
CV_EXPORTS_W void calibrateHandEye(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base,
                                   InputArrayOfArrays R_target2cam, InputArrayOfArrays t_target2cam,
                                   OutputArray R_cam2gripper, OutputArray t_cam2gripper,
                                   HandEyeMethod method = CALIB_HAND_EYE_TSAI);

//! Noise levels of #calibrateHandEyeExtended: standard deviation of one component; 0 = exact, negative = estimated
struct CV_EXPORTS_W_SIMPLE HandEyeParams
{
    CV_WRAP HandEyeParams();

    CV_PROP_RW double targetRotationSigma; //!< of the rotation vector of R_target2cam, rad; default estimated
    //! Of t_target2cam; default estimated. The noise of t_gripper2base has the same effect: one of the two has to be given.
    CV_PROP_RW double targetTranslationSigma;
    CV_PROP_RW double robotRotationSigma;    //!< of the rotation vector of R_gripper2base, rad; default estimated
    CV_PROP_RW double robotTranslationSigma; //!< of t_gripper2base; default 0: targetTranslationSigma covers both
};

//! What #calibrateHandEyeExtended found out besides the transform. Lengths in the unit of the translations, angles in rad.
struct CV_EXPORTS_W_SIMPLE HandEyeSummary
{
    CV_WRAP HandEyeSummary();

    CV_PROP_RW bool usable;         //!< whether the result may be used; message says why (not)
    CV_PROP_RW std::string message; //!< the verdict in a sentence
    CV_PROP_RW int iterations;      //!< of all least-squares solutions together

    //! `(6x6)` of rx, ry, rz, tx, ty, tz; rx, ry, rz is the rotation error vector in the gripper frame:
    //! true R = exp(error) R_cam2gripper.
    CV_PROP_RW Mat covariance;
    CV_PROP_RW Mat standardDeviations; //!< `(6x1)`
    //! `(6x1)` degrees of freedom of Student's t for the intervals (Satterthwaite: the noise levels are estimates too).
    CV_PROP_RW Mat degreesOfFreedom;
    CV_PROP_RW Mat intervals95; //!< `(6x2)` lower and upper end; the rotation error vector is around 0

    //! `(4x4)`, rows targetRotation, targetTranslation, robotRotation, robotTranslation: level, its 95 % interval (lower,
    //! upper), 1 when it was estimated.
    CV_PROP_RW Mat noiseLevels;
    //! Sum of squared normalised residuals, its degrees of freedom and p-value; NaN unless all noise levels were given:
    //! estimated ones fit by construction.
    CV_PROP_RW double chiSquare;
    CV_PROP_RW double chiSquareDof;    //!< degrees of freedom of chiSquare
    CV_PROP_RW double chiSquarePValue; //!< p-value of chiSquare

    CV_PROP_RW Mat R_target2base; //!< `(3x3)`
    CV_PROP_RW Mat t_target2base; //!< `(3x1)`
    //! `(Vx6)` rotation vector and translation of the target in the camera frame, predicted - given: predicted R = exp(w) R_target2cam.
    CV_PROP_RW Mat residuals;
    CV_PROP_RW Mat
        viewPValues; //!< `(Vx2)` p-values of the orientation and the position of each view against the others
    CV_PROP_RW std::vector<int> rejectedViews;    //!< views that contradict the others and were left out
    CV_PROP_RW std::vector<std::string> culprits; //!< what was left out, and why, one sentence each
};

/** @brief As #calibrateHandEye with CALIB_HAND_EYE_REFINED, with covariance, noise levels and residuals.

Maximum likelihood of X and the pose of the target in the base for Gaussian errors of the poses of the camera and of the
robot. Their levels are variance components, estimated by restricted maximum likelihood: errors of the robot's rotation shift
the target, those of the camera's do not, which tells them apart. Views that contradict the others are found from a robust start, left out and named. The
result does not depend on the unit of length. See doc/method/hand_eye.md.

@param[in] R_gripper2base V rotations `(3x3)` or rotation vectors, V >= 3.
@param[in] t_gripper2base V translations of 3 numbers, any unit of length.
@param[in] R_target2cam V rotations `(3x3)` or rotation vectors, from the target to the camera.
@param[in] t_target2cam V translations, in the unit of t_gripper2base.
@param[out] R_cam2gripper `(3x3)`.
@param[out] t_cam2gripper `(3x1)`.
@param[out] summary see HandEyeSummary.
@param[in] params noise levels.
@return standard deviation of t_cam2gripper: root of the sum of the three variances.
@throws cv::Exception as #calibrateHandEye; StsNoConv also when the noise leaves the result open (the direction is named).
*/
CV_EXPORTS_W double calibrateHandEyeExtended(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base,
                                             InputArrayOfArrays R_target2cam, InputArrayOfArrays t_target2cam,
                                             OutputArray R_cam2gripper, OutputArray t_cam2gripper,
                                             CV_OUT HandEyeSummary& summary,
                                             const HandEyeParams& params = HandEyeParams());

//! @}

}} // namespace cv::active_handeye

#endif
