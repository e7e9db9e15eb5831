// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_MEASURE_HPP
#define OPENCV_ACTIVE_HANDEYE_MEASURE_HPP

#include "opencv2/core.hpp"

namespace cv { namespace active_handeye {

//! @addtogroup active_handeye_measure
//! @{

/** @brief Points in space from the pixels of a laser stripe, with their covariances.

The viewing ray m of a pixel meets the light plane \f$n \cdot X = d\f$ in
\f[ X_{cam} = \frac{d}{n \cdot m}\, m, \quad X_{gripper} = R_{cam2gripper} X_{cam} + t_{cam2gripper}, \quad
X_{base} = R_{gripper2base} X_{gripper} + t_{gripper2base} \f]
(paper (1)). Without the transforms the points are in the camera frame, with R_cam2gripper and t_cam2gripper in the gripper frame, with the robot's
pose in the base frame. All pixels of one call were seen in one view.

The covariances are first order in the errors of calibration, pixel and robot pose, as far as these are given; a source that is not given counts as exact.
The points of one call share the errors of calibration and pose: their mean is not better known for their number. See doc/method/measure.md.

@param[in] stripePoints M x 2 pixels of the recorded (distorted) image, as from #detectStripe; may be empty.
@param[in] cameraMatrix 3 x 3.
@param[in] distCoeffs k1, k2, p1, p2[, k3], or empty.
@param[in] lightPlane (nx, ny, nz, d) in the camera frame, |n| = 1, d > 0.
@param[out] points3D M x 3, in the unit of d.
@param[out] covariances M x 3 x 3, in the frame of points3D; empty when no source of error is given. A coordinate that hangs on a parameter
of infinite variance has infinite variance, and covariance 0 with the others.
@param[in] R_cam2gripper 3 x 3 rotation or rotation vector, or empty.
@param[in] t_cam2gripper vector of 3, or empty.
@param[in] R_gripper2base pose of the robot in this view: 3 x 3 rotation or rotation vector, or empty.
@param[in] t_gripper2base vector of 3, or empty.
@param[in] calibrationCovariance 20 x 20, as RefineSummary::covariance, or empty. Infinite variances mark parameters that were not observed.
@param[in] pixelSigmas standard deviation of each image coordinate, pixels: one number, M numbers, or empty.
@param[in] robotTranslationSigma standard deviation of each coordinate of t_gripper2base.
@param[in] robotRotationSigma standard deviation of each component of the rotation error vector w of the robot, rad: true R = exp(w)
R_gripper2base.
@param[in] allowMissed false: a pixel whose ray does not meet the light plane in front of the camera is an error. true: its point and
covariance are NaN.
@throws cv::Exception StsBadArg, StsBadSize, StsOutOfRange for wrong input, and for pixels that miss the light plane (they are named).
*/
CV_EXPORTS_W void reprojectStripe(InputArray stripePoints, InputArray cameraMatrix, InputArray distCoeffs,
                                  InputArray lightPlane, OutputArray points3D, OutputArray covariances = noArray(),
                                  InputArray R_cam2gripper = noArray(), InputArray t_cam2gripper = noArray(),
                                  InputArray R_gripper2base = noArray(), InputArray t_gripper2base = noArray(),
                                  InputArray calibrationCovariance = noArray(), InputArray pixelSigmas = noArray(),
                                  double robotTranslationSigma = 0, double robotRotationSigma = 0,
                                  bool allowMissed = false);

/** @brief Points of the base frame, each from what one or more views saw of it, with their covariances.

Every view places a point as #reprojectStripe does. The views of one point are combined by generalised least squares: the errors of pixels are independent, those of
the robot's pose common to all pixels of a view, those of the calibration common to everything. So the covariance says by how much the views
improve on one of them, which is not by their number. See doc/method/measure.md.

@param[in] R_gripper2base V rotations 3 x 3 or rotation vectors.
@param[in] t_gripper2base V vectors of 3.
@param[in] stripePoints N x 2 pixels of the recorded images, as from #locateOnStripe or #findProfileCorners.
@param[in] stripeViews N integers: the view (0 .. V-1) each pixel was seen in.
@param[in] pointIds N integers from 0 to P-1, each at least once: the point each pixel shows.
@param[in] cameraMatrix 3 x 3.
@param[in] distCoeffs k1, k2, p1, p2[, k3], or empty.
@param[in] lightPlane (nx, ny, nz, d) in the camera frame, |n| = 1, d > 0.
@param[in] R_cam2gripper 3 x 3 rotation or rotation vector.
@param[in] t_cam2gripper vector of 3.
@param[out] points3D P x 3 in the base frame, in the unit of the poses.
@param[out] covariances P x 3 x 3; infinite variances as in #reprojectStripe.
@param[out] disagreements N x 1: squared Mahalanobis distance of what pixel i alone says from the combined point. Chi-square with 3 degrees of
freedom or fewer, if the errors are as stated; 0 for a point seen once.
@param[in] calibrationCovariance 20 x 20, as RefineSummary::covariance; empty = the calibration counts as exact.
@param[in] pixelCovariances N x 2 x 2, pixels^2; not zero; as from #locateOnStripe or #findProfileCorners.
@param[in] robotTranslationSigma as in #reprojectStripe.
@param[in] robotRotationSigma as in #reprojectStripe.
@throws cv::Exception StsBadArg, StsBadSize, StsOutOfRange for wrong input, and for pixels whose ray does not meet the light plane in front of the camera
(they are named).
*/
CV_EXPORTS_W void measureStripePoints(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base,
                                      InputArray stripePoints, InputArray stripeViews, InputArray pointIds,
                                      InputArray cameraMatrix, InputArray distCoeffs, InputArray lightPlane,
                                      InputArray R_cam2gripper, InputArray t_cam2gripper, OutputArray points3D,
                                      OutputArray covariances, OutputArray disagreements,
                                      InputArray calibrationCovariance, InputArray pixelCovariances,
                                      double robotTranslationSigma = 0, double robotRotationSigma = 0);

//! @}

}} // namespace cv::active_handeye

#endif
