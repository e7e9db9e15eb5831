// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#ifndef OPENCV_ACTIVE_HANDEYE_STRIPE_HPP
#define OPENCV_ACTIVE_HANDEYE_STRIPE_HPP

#include "opencv2/core.hpp"

namespace cv { namespace active_handeye {

//! @addtogroup active_handeye_stripe
//! @{

//! How the stripe runs through the image
enum StripeOrientation
{
    STRIPE_HORIZONTAL = 0, //!< roughly along the rows: one point per column
    STRIPE_VERTICAL = 1    //!< roughly along the columns: one point per row
};

//! What a stripe looks like, for #detectStripe
struct CV_EXPORTS_W_SIMPLE StripeParams
{
    CV_WRAP StripeParams();

    CV_PROP_RW int orientation; //!< a #StripeOrientation; default STRIPE_HORIZONTAL
    CV_PROP_RW double sigma;    //!< expected standard deviation of the stripe's cross profile [px], 0.5 to 20; the
                                //!< width found in the image (half to twice this) is used; default 1.5
    CV_PROP_RW double minSnr;   //!< least height of a peak of the smoothed profile, in units of its noise; default 4.5
    CV_PROP_RW double minContrast;   //!< least height of the stripe as a fraction of the saturation level; default 0.02
    CV_PROP_RW double maxSecondPeak; //!< a column is doubtful when its second peak is higher than this fraction of the
                                     //!< first; default 0.6
    CV_PROP_RW double saturation;    //!< grey level from which a pixel is saturated; 0 = the largest value of the image
                                     //!< type (say 4095 for 12 bits in 16); default 0
    CV_PROP_RW int minRun;           //!< shorter runs of neighbouring points are left out; default 5
    CV_PROP_RW Rect roi; //!< part of the image to search, the rest is not looked at; default Rect() = the whole image
};

/** @brief Finds the centre line of a laser stripe, one sub-pixel point per column (or row).

A smoothed second difference along each column finds the peak. Its centre is the least-squares fit of a Gaussian
(the Gaussian-weighted centroid, iterated) to the pixels that are not saturated. With a background image the
difference is explained as background times Gaussian, that is: subtract the background, then divide by it; this
removes the error that edges of the texture under the stripe cause. Of two peaks the one in line with the points at
both sides counts. Columns without a clear peak (gaps, shadows, noise, two peaks that are as likely) give no point.

Pixels count in the fit by their variance: noise of the image, and grain of the light (speckle, texture) in proportion
to the light. The stated standard deviations follow the scatter of the points themselves: third differences of centres
8 columns apart, over 200 columns to each side; bends of the stripe cancel in these, steps are cut off.
See doc/method/stripe.md.

One channel of 8 bits without background and a horizontal stripe is the fastest. Memory of the search stays with the
thread and is used again: a further call with images of the same size and type allocates nothing when the outputs are
those of the call before, or have the capacity. That is so for `std::vector<Point2d>` and `std::vector<double>`, and for
a Mat that holds the result of an earlier call: its rows are kept in reserve when fewer are found.

@param[in] image 8 or 16 bit, 1 or 3 channels (their mean is used).
@param[out] stripePoints `(Nx2)` float64, or a vector of Point2d: pixel positions in order of the columns (rows for
STRIPE_VERTICAL), in the full image also with params.roi; pixel centres have integer coordinates; N = 0 when there is no
stripe.
@param[out] sigmas `(Nx1)` float64 standard deviations of the centres along their column (row) [px]. Errors of
neighbouring columns are correlated where the surface is textured or the light has grain.
@param[in] background the same view with the laser off, same size and type; empty = none.
@param[in] params what the stripe looks like.

@throws cv::Exception with `StsBadArg` / `StsBadSize` for an empty image, an unsupported type, a background that
differs in size or type; `StsOutOfRange` for parameters out of range and a roi that is not inside the image. No stripe is a normal outcome, not an error.
*/
CV_EXPORTS_W void detectStripe(InputArray image, OutputArray stripePoints, OutputArray sigmas,
                               InputArray background = noArray(), const StripeParams& params = StripeParams());

/** @brief Splits a stripe into straight segments, one per plane it crosses.

Works in undistorted pixels. The stripe is cut at gaps, then where one straight line leaves more than half of
breakDistance, at the place that makes the two parts straightest. Points at the cuts and outliers belong to none.
See doc/method/stripe.md.

@param[in] stripePoints `(Nx2)` pixels of the distorted image, in order along the stripe, as from #detectStripe.
@param[in] sigmas `(Nx1)` their standard deviations [px]; empty = all alike.
@param[in] cameraMatrix `(3x3)` camera matrix.
@param[in] distCoeffs distortion coefficients as in OpenCV; empty = none.
@param[out] segmentIds `(Nx1)` int32, 0, 1, ... in order along the stripe; -1 = on no straight segment.
@param[in] breakDistance a step of this size [px] across the stripe, or a bend that departs as far, starts a new segment.
@param[in] maxGap neighbouring points farther apart [px] along the stripe belong to different segments.
@param[in] minPoints shorter segments, counted in points, are left out.
@throws cv::Exception with `StsBadArg`, `StsBadSize`, `StsOutOfRange` for wrong input.
*/
CV_EXPORTS_W void splitStripe(InputArray stripePoints, InputArray sigmas, InputArray cameraMatrix,
                              InputArray distCoeffs, OutputArray segmentIds, double breakDistance = 0.6,
                              double maxGap = 6.0, int minPoints = 20);

/** @brief Finds which stripe segments of different views lie on the same fixed plane of the scene.

The tracked points are triangulated. Where a stripe passes near them, its rays and their inverse depths give the light
plane (three unknowns, robustly) before any surface is known. The segments then become lines in the base frame. Surfaces
are planes that the stripes of three views or more agree on, inside a group of equal orientation (0.05 degrees) first,
then across groups, and that the tracked points beside the segments do not contradict; or of two views, where these
points confirm them. The tolerance shrinks to eight times the median misfit, not below 0.3 px. Segments that fit two
surfaces alike, or lie far from all others of theirs, are left out. See doc/method/light_plane.md.

@param[in] R_gripper2base V rotations `(3x3)` or `(3x1)`.
@param[in] t_gripper2base V translations `(3x1)`.
@param[in] stripePoints S straight stripe segments, each `(Mx2)`, pixels of the distorted image.
@param[in] stripeViews S integers: the view (0 .. V-1) each segment was seen in.
@param[in] imagePoints V arrays `(Nx2)`: row j is the same scene point in every view; NaN = not seen.
@param[in] cameraMatrix `(3x3)` camera matrix.
@param[in] distCoeffs distortion coefficients as in OpenCV; empty = none.
@param[in] R_cam2gripper `(3x3)` or `(3x1)` rotation of the camera in the gripper frame.
@param[in] t_cam2gripper `(3x1)` position of the camera in the gripper frame.
@param[out] surfaceIds `(Sx1)` int32: 0, 1, ... (the surface most stripes lie on first); -1 = not sure.
@param[out] lightPlane `(4x1)` the rough light plane used, (nx, ny, nz, d) as in #calibrateLightPlane.
@param[in] tolerance a segment lies on a surface when its points are at most this far [px] from the stripe that
surface and light plane predict.
@param[in] searchRadius tracked points this near [px] to a stripe give its depth.

@throws cv::Exception with `StsNoConv` when fewer than 30 stripe points have a tracked point near them, or no plane
agrees with a third of these; with `StsBadArg`, `StsBadSize`, `StsOutOfRange` for wrong input.
*/
CV_EXPORTS_W void associateStripes(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base,
                                   InputArrayOfArrays stripePoints, InputArray stripeViews,
                                   InputArrayOfArrays imagePoints, InputArray cameraMatrix, InputArray distCoeffs,
                                   InputArray R_cam2gripper, InputArray t_cam2gripper, OutputArray surfaceIds,
                                   OutputArray lightPlane, double tolerance = 1.5, double searchRadius = 12.0);

//! @}

}} // namespace cv::active_handeye

#endif // OPENCV_ACTIVE_HANDEYE_STRIPE_HPP
