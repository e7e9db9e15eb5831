// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_VERIFY_HPP
#define OPENCV_ACTIVE_HANDEYE_VERIFY_HPP

#include "opencv2/core.hpp"

#include <string>
#include <vector>

namespace cv { namespace active_handeye {

//! @addtogroup active_handeye_verify
//! @{

//! Noise levels that #verifyHandEye takes as known, usually those that #refineHandEye found
struct CV_EXPORTS_W_SIMPLE VerifyParams
{
    CV_WRAP VerifyParams();

    CV_PROP_RW double
        pointSigma; //!< of one image coordinate, pixels (with pointSigmas: their common factor); default 0.1
    CV_PROP_RW double robotTranslationSigma; //!< of each coordinate of the robot's position; default 0 = exact
    CV_PROP_RW double robotRotationSigma; //!< of each component of the robot's rotation vector, rad; default 0 = exact
    CV_PROP_RW double significance;       //!< p-value below which the calibration is not valid any more; default 0.01
};

//! What #verifyHandEye found
struct CV_EXPORTS_W_SIMPLE VerifySummary
{
    CV_WRAP VerifySummary();

    CV_PROP_RW bool valid;          //!< whether the new views agree with the calibration within its covariance
    CV_PROP_RW std::string message; //!< the verdict in a sentence

    //! Test of the calibration's parameters against the new views: squared length of the shift that the views ask for, in units of
    //! the covariance of calibration and views together.
    CV_PROP_RW double driftChiSquare;
    CV_PROP_RW double driftDof;    //!< degrees of freedom of driftChiSquare
    CV_PROP_RW double driftPValue; //!< p-value of driftChiSquare
    //! Test of the residuals that are left when the parameters may shift: large when noise levels or poses are not as stated.
    CV_PROP_RW double fitChiSquare;
    CV_PROP_RW double fitDof;    //!< degrees of freedom of fitChiSquare
    CV_PROP_RW double fitPValue; //!< p-value of fitChiSquare
    CV_PROP_RW Mat
        shift; //!< `(20x1)` shift of the parameters that the new views suggest (order of RefineSummary::parameterNames)
    CV_PROP_RW Mat shiftDeviations; //!< `(20x1)` standard deviations of the shift; 0 = not tested

    //! `(Vx4)` every view predicted from the others: RMS error of its image points [px], RMS expected [px], the same two on the scene
    //! [unit of t_gripper2base]. Expected: image noise, robot, calibration. NaN where no point is seen in another view.
    CV_PROP_RW Mat viewErrors;
    CV_PROP_RW std::vector<int> contradictingViews; //!< views whose error is far more than expected
    CV_PROP_RW int usedObservations;                //!< image points used
    CV_PROP_RW int rejectedObservations;            //!< image points left out as wrong matches
};

/** @brief Asks new views whether a calibration is still valid.

Scene points are triangulated from the new views with the calibration and the reported poses; nothing of the old scene is
needed, and few views suffice. The gradient of the likelihood by the calibration's parameters has, if nothing has changed, a known
covariance: that of the views' noise plus the calibration's own. Its squared length in these units is a chi-square (score
test). Every view is also predicted from the others, and the error compared with what is expected. See doc/method/verify.md.

@param[in] R_gripper2base V rotations (3 x 3) or rotation vectors.
@param[in] t_gripper2base V translations, in the unit of t_cam2gripper.
@param[in] imagePoints V arrays N x 2 of pixels of the recorded images; row j is the same scene point in every view, (NaN, NaN) = not
seen.
@param[in] cameraMatrix 3 x 3.
@param[in] distCoeffs k1, k2, p1, p2[, k3], or empty.
@param[in] R_cam2gripper 3 x 3 rotation or rotation vector.
@param[in] t_cam2gripper 3 numbers.
@param[in] covariance 20 x 20 of the calibration, as RefineSummary::covariance.
@param[out] summary see VerifySummary.
@param[in] pointSigmas V arrays of N standard deviations of the image points, pixels; empty = all alike.
@param[in] params noise levels.
@return RMS error, pixels, of the views predicted from each other.
@throws cv::Exception StsBadArg, StsBadSize, StsOutOfRange for wrong input; StsNoConv when no point is seen in two views.
*/
CV_EXPORTS_W double verifyHandEye(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base,
                                  InputArrayOfArrays imagePoints, InputArray cameraMatrix, InputArray distCoeffs,
                                  InputArray R_cam2gripper, InputArray t_cam2gripper, InputArray covariance,
                                  CV_OUT VerifySummary& summary, InputArrayOfArrays pointSigmas = noArray(),
                                  const VerifyParams& params = VerifyParams());

//! @}

}} // namespace cv::active_handeye

#endif
