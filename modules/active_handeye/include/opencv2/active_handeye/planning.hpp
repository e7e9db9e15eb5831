// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_PLANNING_HPP
#define OPENCV_ACTIVE_HANDEYE_PLANNING_HPP

#include "opencv2/active_handeye/refine.hpp"

namespace cv { namespace active_handeye {

//! @addtogroup active_handeye_planning
//! @{

/** @brief Predicts the covariance that #refineHandEye would reach with images that have not been taken yet.

The problem of the refinement is built at the assumed truth, linearised there, and inverted; nothing is simulated. A scene
point is seen where it projects into the image from in front of the camera; points that only one view sees do not count.
See doc/method/planning.md.

@param[in] R_gripper2base V planned rotations (3 x 3) or rotation vectors, 2 or more.
@param[in] t_gripper2base V planned translations, any unit of length.
@param[in] scenePoints N x 3 assumed scene points, base frame.
@param[in] imageSize pixels.
@param[in] cameraMatrix 3 x 3, assumed.
@param[in] distCoeffs k1, k2, p1, p2[, k3], assumed, or empty = 0.
@param[in] R_cam2gripper 3 x 3 or rotation vector, assumed.
@param[in] t_cam2gripper 3 numbers, assumed.
@param[out] covariance `(20x20)`, order of RefineSummary::parameterNames; rows of fixed parameters are 0, variances of
undetermined ones infinite.
@param[out] weakDirections what the planned views would determine badly, by name, and what motion would cure it.
@param[out] seenPoints `(Vx1)` integers: the points that each view shares with another.
@param[in] lightPlane (nx, ny, nz, d), n.X = d in the camera frame, assumed; empty = no stripes.
@param[in] surfaces S x 4, planes (wx, wy, wz, e) of the scene, w.X = e in the base frame; w, of any length, points to the side
from which it is seen. A scene point nearer to a plane than 1 % of its distance from the camera is not seen from behind it.
With lightPlane every view sees the stripe on every plane, as far as the image reaches; those on planes that one view alone
sees do not count.
@param[in] params noise levels, all of which are needed (stripeSigma only with lightPlane); flags and lensModel as for
#refineHandEye. LENS_AUTO is the smallest model that has the coefficients of distCoeffs, which that would choose.
@return standard deviation of t_cam2gripper: root of the sum of the three variances.
@throws cv::Exception StsBadArg, StsBadSize, StsOutOfRange for wrong input; StsNoConv when no point is seen twice.
*/
CV_EXPORTS_W double predictHandEyeCovariance(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base,
                                             InputArray scenePoints, Size imageSize, InputArray cameraMatrix,
                                             InputArray distCoeffs, InputArray R_cam2gripper, InputArray t_cam2gripper,
                                             OutputArray covariance, CV_OUT std::vector<std::string>& weakDirections,
                                             OutputArray seenPoints, InputArray lightPlane = noArray(),
                                             InputArray surfaces = noArray(),
                                             const RefineParams& params = RefineParams());

//! Settings of #planHandEyeViews
struct CV_EXPORTS_W_SIMPLE PlanParams
{
    CV_WRAP PlanParams();

    //! Orientations at which there have to be enough views for the closed forms; negative (default) = 2, with REFINE_FIX_K 1.
    CV_PROP_RW int groups;
    //! Views that are enough; negative (default) = 4 whose translations span space, with REFINE_FIX_K 3 that span a plane.
    CV_PROP_RW int viewsPerGroup;
    CV_PROP_RW int exchanges;    //!< rounds in which every view may be exchanged for a better one; default 3
    CV_PROP_RW double seenShare; //!< of the scene points, that a view has to see to be chosen, 0 to 1; default 0.25
};

/** @brief Chooses, from possible views, those with which #refineHandEye would know t_cam2gripper best.

Greedy choice, then exchange, by the sum of the variances of t_cam2gripper. See doc/method/planning.md for what the search
approximates; the value returned is that of #predictHandEyeCovariance.

@param[in] R_gripper2base V rotations (3 x 3) or rotation vectors: views taken already and possible ones.
@param[in] t_gripper2base V translations, any unit of length.
@param[in] scenePoints N x 3 assumed scene points, base frame.
@param[in] imageSize pixels.
@param[in] cameraMatrix 3 x 3, assumed.
@param[in] distCoeffs k1, k2, p1, p2[, k3], assumed, or empty = 0.
@param[in] R_cam2gripper 3 x 3 or rotation vector, assumed.
@param[in] t_cam2gripper 3 numbers, assumed.
@param[in] stops how many views there are to be, those taken included.
@param[out] chosen the new views by their numbers, in groups of equal orientation: those with most views first, and in
every group the one that tells most first.
@param[in] taken numbers of the views that were taken already; empty = none.
@param[in] params noise levels, flags and lens model as for #predictHandEyeCovariance.
@param[in] planParams what the choice has to have.
@return standard deviation of t_cam2gripper with all of them.
@throws cv::Exception StsBadArg, StsBadSize, StsOutOfRange for wrong input; StsNoConv when the possible views do not hold
groups of translations, or turns about two axes.
*/
CV_EXPORTS_W double planHandEyeViews(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base,
                                     InputArray scenePoints, Size imageSize, InputArray cameraMatrix,
                                     InputArray distCoeffs, InputArray R_cam2gripper, InputArray t_cam2gripper,
                                     int stops, CV_OUT std::vector<int>& chosen, InputArray taken = noArray(),
                                     const RefineParams& params = RefineParams(),
                                     const PlanParams& planParams = PlanParams());

//! @}

}} // namespace cv::active_handeye

#endif
