// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#ifndef OPENCV_ACTIVE_HANDEYE_LIGHT_PLANE_HPP
#define OPENCV_ACTIVE_HANDEYE_LIGHT_PLANE_HPP

#include "opencv2/core.hpp"

namespace cv { namespace active_handeye {

//! @addtogroup active_handeye_light_plane
//! @{

/** @brief Finds the plane of a line laser that is fixed to the camera, from its stripes on unknown planes.

The camera only translates inside a group of views with equal orientation (displacement \f$c_s\f$ in the camera
frame). With the light plane \f$n \cdot X = d\f$ and a fixed surface \f$w \cdot X = e_0\f$ (camera frame of the
group's first view) the stripe of view s lies on the interpretation plane
\f[ m_s \sim (e_0 - w \cdot c_s)\, n - d\, w . \f]
1. Each segment becomes one line with its covariance in undistorted coordinates.
2. The lines of one surface in one group meet in one vanishing direction \f$r = n \times w\f$ (paper (22)).
3. Two different directions give \f$n \sim r_1 \times r_2\f$ (paper (25)); all of them are used by least squares.
4. The offset d follows from how the lines move with the camera: no marker is needed. Then follows a maximum
   likelihood refinement of n, d and all surfaces; it minimises the distance of the stripes to the predicted
   lines in pixels.

A group and surface counts when its stripe was seen in at least three views whose translations have two directions
across the stripe. Use two or more stripe directions: surfaces with different tilt, or two orientations of the
gripper. One direction alone is accepted only if its many views determine the plane; the covariance tells how well.

Segments that contradict the others (a wrong surface id, a reflection) are left out; the log (level warning) names
them. When too few remain, the call fails and names them in the error. See doc/method/light_plane.md.

@param[in] R_gripper2base V rotations of the gripper in the robot base frame: `(3x3)` rotation matrices or `(3x1)`
rotation vectors.
@param[in] t_gripper2base V translations, `(3x1)`; any unit of length, the result has the same one.
@param[in] stripePoints S straight stripe segments, each `(Mx2)`, M >= 2, in pixels of the distorted image; see
#detectStripe and #splitStripe.
@param[in] stripeViews S integers: the view (0 .. V-1) each segment was seen in.
@param[in] surfaceIds S integers: the fixed plane of the scene each segment lies on, see #associateStripes;
-1 = not known, such a segment is not used. An id is compared inside a group of equal orientation only.
@param[in] cameraMatrix `(3x3)` camera matrix.
@param[in] distCoeffs distortion coefficients as in OpenCV (k1, k2, p1, p2[, k3 ...]); empty = none.
@param[in] R_cam2gripper `(3x3)` or `(3x1)` rotation of the camera in the gripper frame.
@param[out] lightPlane `(4x1)` (nx, ny, nz, d) in the camera frame, n.X = d, |n| = 1, d > 0.
@param[out] covariance `(4x4)` covariance of lightPlane; its rank is 3 because |n| = 1. It is scaled by the lines'
misfit, which with fewer than ten degrees of freedom may only enlarge it.
@param[in] knownPoints optional `(Mx3)` points of the light plane in the camera frame (paper (30), (31)); each adds
the equation n.X = d. They are taken as exact to 1/1000 of their depth. A point on the stripe that a pure translation c
of the camera shows along the rays x1 and x2 (from its pixels) is X = x1 ((x2 x x1).(x2 x c)) / |x2 x x1|^2.
@param[in] orientationTolerance views whose orientations differ by less (degrees) form one group.
@return RMS distance, in pixels, of the stripe points used to the lines predicted by the result.

@throws cv::Exception with `StsBadArg`, `StsBadSize` or `StsOutOfRange` for wrong input, with `StsNoConv` when the
stripes do not determine the plane: too few views, translations along the stripe only, one stripe direction only,
stripes that contradict each other. The text says what is missing, directions in base coordinates.
*/
CV_EXPORTS_W double calibrateLightPlane(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base,
                                        InputArrayOfArrays stripePoints, InputArray stripeViews, InputArray surfaceIds,
                                        InputArray cameraMatrix, InputArray distCoeffs, InputArray R_cam2gripper,
                                        OutputArray lightPlane, OutputArray covariance = noArray(),
                                        InputArray knownPoints = noArray(), double orientationTolerance = 0.05);

//! @}

}} // namespace cv::active_handeye

#endif // OPENCV_ACTIVE_HANDEYE_LIGHT_PLANE_HPP
