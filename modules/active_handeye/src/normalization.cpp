// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "normalization.hpp"

namespace cv { namespace active_handeye {

Normalization::Normalization(const std::vector<const Pixels*>& lists) : centroid(0, 0), scale(1)
{
    size_t count = 0;
    for (const Pixels* pixels : lists)
        for (const Eigen::Vector2d& x : *pixels)
            if (x.allFinite())
                centroid += x, ++count;
    if (count == 0)
        return;
    centroid /= double(count);
    double distances = 0;
    for (const Pixels* pixels : lists)
        for (const Eigen::Vector2d& x : *pixels)
            if (x.allFinite())
                distances += (x - centroid).norm();
    if (distances > 0)
        scale = std::sqrt(2.) * double(count) / distances;
}

Eigen::Matrix3d Normalization::matrix() const
{
    Eigen::Matrix3d T;
    T << scale, 0, -scale * centroid.x(), 0, scale, -scale * centroid.y(), 0, 0, 1;
    return T;
}

Eigen::Matrix3d Normalization::inverse() const
{
    Eigen::Matrix3d T;
    T << 1 / scale, 0, centroid.x(), 0, 1 / scale, centroid.y(), 0, 0, 1;
    return T;
}

}} // namespace cv::active_handeye
