// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_SRC_FOE_HPP
#define OPENCV_ACTIVE_HANDEYE_SRC_FOE_HPP

#include "input.hpp"

namespace cv { namespace active_handeye {

struct FOE
{
    Eigen::Vector3d direction;  //!< K c, unit, signed
    Eigen::Matrix3d covariance; //!< of direction, rank 2
    std::vector<uchar> inliers; //!< one per match
    int inlierCount;
};

//! estimateFOE() on Eigen types; `source` names the caller's data in error texts.
FOE estimateFOE(const Pixels& points1, const Pixels& points2, FOEMethod method, double threshold, double confidence,
                const std::string& source);

}} // namespace cv::active_handeye

#endif
