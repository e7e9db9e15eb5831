// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_STRIPE_LINES_HPP
#define OPENCV_ACTIVE_HANDEYE_STRIPE_LINES_HPP

#include "camera.hpp"
#include "input.hpp"

namespace cv { namespace active_handeye {

/** A straight stripe segment as one line in ideal pixels, with its covariance.

The line is kept as two points at centre +- halfLength * direction, halfLength being the RMS extent of the pixels: two
such points with independent errors `sigma` across the line carry the same information as all its pixels. `sigma` has a
floor, because errors of neighbouring pixels are correlated (albedo, speckle).
*/
struct StripeLine
{
    Eigen::Vector2d centre, direction; //!< direction is a unit vector
    double halfLength;
    double sigma;   //!< px, of each of the two points
    double squares; //!< sum of squared distances of the pixels to the line, px^2
    int points;

    Eigen::Vector2d end(int i) const { return centre + (i ? halfLength : -halfLength) * direction; }

    //! Distance of a pixel, signed.
    double distance(const Eigen::Vector2d& pixel) const
    {
        return direction.x() * (pixel.y() - centre.y()) - direction.y() * (pixel.x() - centre.x());
    }
};

//! Pixel of the recorded image where one of the two points is.
Eigen::Vector2d recordedEnd(const StripeLine& line, const Camera& camera, int i);

//! Total least squares over ideal pixels.
StripeLine fitStripeLine(const Pixels& idealPixels);

//! The same for a segment of the recorded image. Names stripePoints[index] when its pixels are no line.
StripeLine readStripeLine(const Pixels& pixels, const Camera& camera, int index);

//! S integers in stripeViews, each a view.
std::vector<int> readStripeViews(InputArray stripeViews, size_t segments, size_t views);

//! S integers in surfaceIds, each an id from 0 on or -1.
std::vector<int> readSurfaceIds(InputArray surfaceIds, size_t segments);

}} // namespace cv::active_handeye

#endif
