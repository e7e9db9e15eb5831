// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_REFINE_HPP
#define OPENCV_ACTIVE_HANDEYE_REFINE_HPP

#include "opencv2/core.hpp"

#include <string>
#include <vector>

namespace cv { namespace active_handeye {

//! @addtogroup active_handeye_refine
//! @{

//! What refineHandEye keeps as it was given
enum RefineFlags
{
    REFINE_FIX_K = 1,        //!< cameraMatrix
    REFINE_SKEW = 2,         //!< skew is estimated too; else it stays what it was (0 without a start)
    REFINE_FIX_ASPECT = 4,   //!< fy / fx stays what it was (1 without a start); not usable where the data contradict it
    REFINE_FIX_ROTATION = 8, //!< R_cam2gripper
    REFINE_FIX_TRANSLATION = 16, //!< t_cam2gripper
    REFINE_FIX_LIGHT_PLANE = 32, //!< lightPlane
    REFINE_ALLOW_PARTIAL = 64    //!< robots that cannot turn about two axes: answer what is observable, mark the rest
};

//! Which distortion coefficients are estimated; the others stay what they were. The tests ask whether distortion differs from
//! the start: give a start of distCoeffs only where they are known.
enum LensModel
{
    LENS_AUTO =
        -1, //!< the smallest of the five below that the data do not contradict (Wald test at 1 %); with REFINE_FIX_K: LENS_FIXED
    LENS_FIXED = 0,      //!< none
    LENS_K1 = 1,         //!< k1
    LENS_K1_K2 = 2,      //!< k1, k2
    LENS_TANGENTIAL = 3, //!< k1, k2, p1, p2
    LENS_K3 = 4          //!< k1, k2, p1, p2, k3
};

//! Settings of #refineHandEye
struct CV_EXPORTS_W_SIMPLE RefineParams
{
    CV_WRAP RefineParams();

    CV_PROP_RW int flags;     //!< combination of #RefineFlags; default 0
    CV_PROP_RW int lensModel; //!< a #LensModel; default LENS_AUTO

    //! Standard deviation of one image coordinate, pixels (with pointSigmas: their common factor); negative (default) =
    //! estimated.
    CV_PROP_RW double pointSigma;
    //! Standard deviation of a stripe segment's line, pixels (with stripeSigmas: their common factor); negative
    //! (default) = estimated.
    CV_PROP_RW double stripeSigma;
    //! Standard deviation of each coordinate of the robot's position, unit of t_gripper2base; 0 = the robot is exact,
    //! negative (default) = estimated.
    CV_PROP_RW double robotTranslationSigma;
    //! Standard deviation of each component of the robot's rotation vector, rad; 0 = exact, negative (default) =
    //! estimated.
    CV_PROP_RW double robotRotationSigma;

    //! Distance of an image point from its prediction, in sigmas, from which its pull no longer grows (Huber); default 2.5.
    CV_PROP_RW double huberThreshold;
    //! Distance, in sigmas, from which an image point is left out; default 4.5.
    CV_PROP_RW double rejectThreshold;
    CV_PROP_RW int maxIterations;           //!< of one least-squares solution; default 50
    CV_PROP_RW double orientationTolerance; //!< for the closed-form start, degrees; default 0.05
};

//! What #refineHandEye found out besides the calibration. Lengths in the unit of t_gripper2base, angles in rad, image in pixels.
struct CV_EXPORTS_W_SIMPLE RefineSummary
{
    CV_WRAP RefineSummary();

    CV_PROP_RW bool usable;            //!< whether the result may be used; message says why (not)
    CV_PROP_RW std::string message;    //!< the verdict in a sentence
    CV_PROP_RW std::string stopReason; //!< why the iterations ended
    CV_PROP_RW int iterations;         //!< of all least-squares solutions together
    CV_PROP_RW double rms;             //!< RMS distance of the image points used from their predictions

    //! fx, fy, cx, cy, skew, k1, k2, p1, p2, k3, rx, ry, rz, tx, ty, tz, nx, ny, nz, d; rx, ry, rz is the rotation error
    //! vector in the gripper frame: true R = exp(error) R_cam2gripper.
    CV_PROP_RW std::vector<std::string> parameterNames;
    CV_PROP_RW Mat covariance; //!< `(20x20)`; rows of fixed parameters are 0, variances of unobserved ones infinite
    CV_PROP_RW Mat standardDeviations; //!< `(20x1)`
    //! `(20x1)` degrees of freedom of Student's t for the intervals (Satterthwaite: the noise levels are estimates too).
    CV_PROP_RW Mat degreesOfFreedom;
    CV_PROP_RW Mat intervals95; //!< `(20x2)` lower and upper end; the rotation error vector is around 0

    CV_PROP_RW double pointSigma;            //!< noise level used, as in RefineParams
    CV_PROP_RW double stripeSigma;           //!< noise level used, as in RefineParams
    CV_PROP_RW double robotTranslationSigma; //!< noise level used, as in RefineParams
    CV_PROP_RW double robotRotationSigma;    //!< noise level used, as in RefineParams
    CV_PROP_RW Mat
        noiseLevels; //!< `(4x4)`: rows as above; level, 95 % interval (lower, upper), 1 when it was estimated

    //! Sum of squared normalised residuals and pose corrections at the noise levels given (RefineParams); NaN when none was.
    //! Noise levels that were estimated fit by construction: then only the lens tests tell.
    CV_PROP_RW double chiSquare;
    CV_PROP_RW double chiSquareDof;    //!< degrees of freedom of chiSquare
    CV_PROP_RW double chiSquarePValue; //!< p-value of chiSquare
    CV_PROP_RW int lensModel;          //!< the #LensModel used
    //! `(5x4)`, one row for LENS_FIXED to LENS_K3: Wald statistic of the coefficients that this model lacks of
    //! LENS_K3, their number, p-value, Akaike's information criterion up to a constant (statistic - 2 x their number).
    CV_PROP_RW Mat lensTests;

    CV_PROP_RW Mat
        poseCorrections; //!< `(Vx6)` rotation vector and translation in the base frame: true R = exp(w) R_gripper2base
    CV_PROP_RW Mat viewRms;   //!< `(Vx1)` RMS residual of the points used; NaN where none was
    CV_PROP_RW Mat residuals; //!< `(Vx2N)`: row v holds dx, dy of every point, predicted - measured; NaN = not seen
    CV_PROP_RW Mat rejectedObservations;          //!< `(VxN)` uchar, 1 where an image point was left out
    CV_PROP_RW std::vector<int> rejectedViews;    //!< views whose reported pose was not believed
    CV_PROP_RW std::vector<int> rejectedSegments; //!< stripe segments left out
    CV_PROP_RW Mat
        stripeResiduals; //!< `(Sx2)` distances of the two ends of every segment from its prediction; NaN = not used
    //! `(Gx6)`, a row for every group of equal orientation (RefineParams::orientationTolerance) whose stripes were used:
    //! its first view, how many of its views and segments were used, on how many surfaces, and the standard deviations
    //! that the light plane's normal (rad, RMS length) and offset would have without the stripes of this group, all else
    //! and the noise levels as they are; infinite = it would not be determined. With all stripes they are
    //! sqrt(var nx + var ny + var nz) and sqrt(var d).
    CV_PROP_RW Mat stripeGroups;
    CV_PROP_RW std::vector<std::string> culprits; //!< what was left out or not believed, and why, one sentence each
    CV_PROP_RW Mat scenePoints;                   //!< `(Nx3)` in the base frame; NaN = not determined

    CV_PROP_RW std::vector<std::string>
        weakDirections;                //!< what the data determine badly, by name, and what motion would cure it
    CV_PROP_RW double workingDistance; //!< median depth of the scene points
    //! `(3x3)` covariance, in the gripper frame, of a scene point on the central ray at the working distance, as far as
    //! the calibration causes it: "mm at the tool".
    CV_PROP_RW Mat toolCovariance;
};

/** @brief Maximum-likelihood calibration of camera, hand-eye transform and light plane from everything that was seen.

Unknowns are the camera matrix, the lens distortion, X = (R, t)_cam2gripper, the light plane \f$n \cdot X = d\f$, one plane for
every surface, all scene points, and for every view a correction of the robot's pose with prior \f$N(0, \sigma_{robot}^2)\f$.
Residuals are distances in the image: of the points (Huber), and of the two ends of every stripe segment from the
predicted stripe. Points are eliminated (Schur complement); Levenberg-Marquardt solves for the rest. The noise levels
are variance components estimated by restricted maximum likelihood, so the covariance covers image noise and robot noise
as the data show them. See doc/method/refine.md.

A missing start (an empty array) is computed by #calibrateHandEyeTranslations, #calibrateHandEyeRotation and
#calibrateLightPlane. Points with known coordinates (a board is the special case) need no other function: give objectPoints.

@param[in] R_gripper2base V rotations (3 x 3) or rotation vectors.
@param[in] t_gripper2base V translations, any unit of length.
@param[in] imagePoints V arrays N x 2 of pixels of the recorded (distorted) images; row j is the same scene point in every view,
(NaN, NaN) = not seen.
@param[in,out] cameraMatrix 3 x 3; in: start, or empty.
@param[in,out] distCoeffs k1, k2, p1, p2[, k3]; in: start, or empty = 0. Out: 5 x 1. LENS_AUTO asks
whether the coefficients differ from their start: give only what is known.
@param[in,out] R_cam2gripper 3 x 3; in: start, or empty.
@param[in,out] t_cam2gripper 3 x 1; in: start, or empty.
@param[in,out] lightPlane (nx, ny, nz, d), 4 x 1; in: start, or empty. Out: empty when there are no stripes.
@param[out] summary see RefineSummary.
@param[in] stripePoints S straight stripe segments, each M x 2, pixels of the recorded images.
@param[in] stripeViews S integers: the view each segment was seen in.
@param[in] surfaceIds S integers: the plane, fixed in the base frame, each segment lies on; -1 = not known (not used).
@param[in] objectPoints N x 3 known coordinates in a frame of their own, NaN = not known; the pose of that frame in the base
is estimated.
@param[in] pointSigmas V arrays of N standard deviations of the image points, pixels; empty = all alike.
@param[in] stripeSigmas S standard deviations of the segments' lines, pixels; empty = all alike.
@param[in] params settings.
@return RMS distance between image points and their predictions, pixels.
@throws cv::Exception StsBadArg, StsBadSize, StsOutOfRange for wrong input; StsNoConv when the data do not determine the
result: the text names what is missing.
*/
CV_EXPORTS_W double refineHandEye(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base,
                                  InputArrayOfArrays imagePoints, InputOutputArray cameraMatrix,
                                  InputOutputArray distCoeffs, InputOutputArray R_cam2gripper,
                                  InputOutputArray t_cam2gripper, InputOutputArray lightPlane,
                                  CV_OUT RefineSummary& summary, InputArrayOfArrays stripePoints = noArray(),
                                  InputArray stripeViews = noArray(), InputArray surfaceIds = noArray(),
                                  InputArray objectPoints = noArray(), InputArrayOfArrays pointSigmas = noArray(),
                                  InputArray stripeSigmas = noArray(), const RefineParams& params = RefineParams());

//! @}

}} // namespace cv::active_handeye

#endif
