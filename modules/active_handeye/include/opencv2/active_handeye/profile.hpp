// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#ifndef OPENCV_ACTIVE_HANDEYE_PROFILE_HPP
#define OPENCV_ACTIVE_HANDEYE_PROFILE_HPP

#include "opencv2/core.hpp"

#include "opencv2/active_handeye/stripe.hpp"

namespace cv { namespace active_handeye {

//! @addtogroup active_handeye_profile
//! @{

/** @brief Characteristic points that lie on a stripe: where its straight pieces pass the given pixels.

A line through the columns of one piece around the point is several times better than a single column. The line is
straight in undistorted pixels; the answer is a pixel of the recorded image. Its variance across the stripe is that of
the weighted fit, raised by the scatter of these columns about the line and by the correlation of neighbours along the
whole stripe (grain of the laser light, texture), and never below (0.02 px)^2. See doc/method/profile.md.

@param[in] stripePoints `(Nx2)` pixels in order along the stripe, as from #detectStripe.
@param[in] sigmas `(Nx1)` their standard deviations [px], as from #detectStripe.
@param[in] segmentIds `(Nx1)` the straight pieces, as from #splitStripe.
@param[in] pixels `(Mx2)` pixels near the stripe. The coordinate along the stripe (u for STRIPE_HORIZONTAL, v for
STRIPE_VERTICAL) says where the point is, the other one only which piece is meant: the nearest.
@param[in] cameraMatrix `(3x3)` camera matrix.
@param[in] distCoeffs k1, k2, p1, p2[, k3] as in OpenCV; empty = none.
@param[out] points `(Mx2)` pixels on the stripe; NaN where no piece comes within maxDistance of the pixel.
@param[out] covariances `(Mx2x2)` [px^2]; NaN as well.
@param[in] sigmaAlong standard deviation [px] of the coordinate along the stripe in pixels; 0 = it is exact.
@param[in] orientation of the stripe, a #StripeOrientation.
@param[in] halfWindow columns of the piece on either side of the point that count; at least 8 must be there.
@param[in] maxDistance between pixel and stripe, across it [px]. The point may lie 3 px beyond the end of its piece.

@throws cv::Exception StsBadArg, StsBadSize, StsOutOfRange for wrong input.
*/
CV_EXPORTS_W void locateOnStripe(InputArray stripePoints, InputArray sigmas, InputArray segmentIds, InputArray pixels,
                                 InputArray cameraMatrix, InputArray distCoeffs, OutputArray points,
                                 OutputArray covariances, double sigmaAlong = 0, int orientation = STRIPE_HORIZONTAL,
                                 double halfWindow = 15, double maxDistance = 10);

/** @brief Corners of a profile: where two neighbouring straight pieces of a stripe meet in the light plane.

Roots of grooves, edges of plates and fillets. Both pieces are continued as lines, so that a rounded or open root (a
root gap, a bead) does not matter. The opening angle is measured in the light plane on the side the camera is on: less
than 180 degrees is a groove, more is a ridge. See doc/method/profile.md.

@param[in] stripePoints `(Nx2)` pixels in order along the stripe, as from #detectStripe.
@param[in] sigmas `(Nx1)` their standard deviations [px], as from #detectStripe.
@param[in] segmentIds `(Nx1)` the straight pieces, as from #splitStripe; short faces need a small minPoints there.
@param[in] cameraMatrix `(3x3)` camera matrix.
@param[in] distCoeffs k1, k2, p1, p2[, k3] as in OpenCV; empty = none.
@param[in] lightPlane (nx, ny, nz, d) in the camera frame, |n| = 1, d > 0, as from #calibrateLightPlane.
@param[out] corners `(Kx2)` pixels of the recorded image, in order along the stripe; K may be 0.
@param[out] covariances `(Kx2x2)` [px^2], from the lines as in #locateOnStripe.
@param[out] openingAngles `(Kx1)` degrees, 0 to 360.
@param[out] segments `(Kx2)` int32, the pieces that meet.
@param[in] orientation of the stripe, a #StripeOrientation.
@param[in] halfWindow columns: the 2 halfWindow + 1 columns of a piece nearest to the corner count.
@param[in] maxGap [px]: the corner is this near to the ends of both pieces at most; farther apart they do not meet.

@throws cv::Exception StsBadArg, StsBadSize, StsOutOfRange for wrong input.
*/
CV_EXPORTS_W void findProfileCorners(InputArray stripePoints, InputArray sigmas, InputArray segmentIds,
                                     InputArray cameraMatrix, InputArray distCoeffs, InputArray lightPlane,
                                     OutputArray corners, OutputArray covariances, OutputArray openingAngles,
                                     OutputArray segments, int orientation = STRIPE_HORIZONTAL, double halfWindow = 15,
                                     double maxGap = 12);

//! @}

}} // namespace cv::active_handeye

#endif // OPENCV_ACTIVE_HANDEYE_PROFILE_HPP
