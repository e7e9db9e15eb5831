// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_FOE_HPP
#define OPENCV_ACTIVE_HANDEYE_FOE_HPP

#include "opencv2/core.hpp"

namespace cv { namespace active_handeye {

//! @addtogroup active_handeye_foe
//! @{

//! How estimateFOE treats wrong matches
enum FOEMethod
{
    FOE_LEAST_SQUARES = 0, //!< all matches are right: maximum likelihood from all of them
    FOE_RANSAC = 1         //!< some matches are wrong: samples of two matches, then maximum likelihood from the inliers
};

/** @brief Focus of expansion (FOE) of one pure translation of the camera.

When the camera translates by c without turning, the image of every fixed scene point moves along a line through
\f$ e \sim K c \f$, the focus of expansion @cite Ma1996 (paper, (3)). Two matches determine it:
\f$ e \cdot (x_1 \times x_2) = 0 \f$ for homogeneous pixels of both views. A translation parallel to the image plane has its FOE at
infinity, therefore it is a homogeneous 3-vector. Its sign is the direction in which the *camera* moved: \f$ K^{-1} e \f$ points from the first
camera centre to the second, which follows from the scene being in front of the camera.

The estimate minimises the sum of squared orthogonal distances of both points of each match to their common line through e. See doc/method/foe.md.

@param[in] points1 N x 2 (or N x 1 x 2) pixels of the first view, without lens distortion.
@param[in] points2 N x 2 pixels of the same scene points in the second view.
@param[out] foe 3 x 1, \f$ K c \f$ up to scale, |foe| = 1.
@param[out] inlierMask N x 1, 8 bit; 1 where the match agrees with foe (FOE_LEAST_SQUARES: all 1).
@param[out] covariance 3 x 3 covariance of foe on the unit sphere (rank 2: foe is its null vector). The noise level is estimated from the
residuals; with two matches there are none, and a noise of 1 px per axis is assumed.
@param[in] method see #FOEMethod.
@param[in] threshold FOE_RANSAC: largest orthogonal distance of an inlier, pixels; with ten inliers or more five times their noise counts, when
that is less.
@param[in] confidence FOE_RANSAC: probability that a sample without wrong matches was drawn.
@return number of inliers.
@throws cv::Exception StsBadArg, StsBadSize, StsOutOfRange for wrong input; StsNoConv when the matches cannot answer: fewer than two, no
parallax (the median displacement in pixels is in the text), or all displacements on one line.
*/
CV_EXPORTS_W int estimateFOE(InputArray points1, InputArray points2, OutputArray foe,
                             OutputArray inlierMask = noArray(), OutputArray covariance = noArray(),
                             FOEMethod method = FOE_RANSAC, double threshold = 1.0, double confidence = 0.999);

//! @}

}} // namespace cv::active_handeye

#endif
