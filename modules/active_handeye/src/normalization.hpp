// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_NORMALIZATION_HPP
#define OPENCV_ACTIVE_HANDEYE_NORMALIZATION_HPP

#include "input.hpp"

namespace cv { namespace active_handeye {

//! Hartley's normalisation: centroid at the origin, mean distance from it sqrt(2). NaN pixels do not count.
struct Normalization
{
    explicit Normalization(const std::vector<const Pixels*>& lists);

    Eigen::Vector2d apply(const Eigen::Vector2d& pixel) const { return scale * (pixel - centroid); }
    Eigen::Matrix3d matrix() const;  //!< pixels -> normalised
    Eigen::Matrix3d inverse() const; //!< normalised -> pixels

    Eigen::Vector2d centroid;
    double scale;
};

}} // namespace cv::active_handeye

#endif
