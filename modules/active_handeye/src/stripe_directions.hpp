// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_STRIPE_DIRECTIONS_HPP
#define OPENCV_ACTIVE_HANDEYE_STRIPE_DIRECTIONS_HPP

#include "light_plane_problem.hpp"

namespace cv { namespace active_handeye {

//! A line this far [px] from where the others want it contradicts them, when the closed forms are computed.
const double startTolerance = 5;

//! Unit normal of the plane through the camera's centre and the line.
Eigen::Vector3d interpretationNormal(const StripeView& view);

//! r ~ n x w, where the lines of one surface in one group meet (paper (22)).
struct VanishingDirection
{
    Eigen::Vector3d r;
    Eigen::Matrix3d covariance; //!< of r, across it
    bool determined;            //!< false: the lines coincide, they meet everywhere
    std::vector<double> errors; //!< px by which each line misses r
    int agreeing;               //!< lines within startTolerance

    double worst() const { return *std::max_element(errors.begin(), errors.end()); }
};

VanishingDirection findVanishingDirection(const StripeSurface& surface, const Eigen::Matrix3d& K);

//! Normals of the light plane to try, the best guess first.
struct NormalCandidates
{
    AlignedVector<Eigen::Vector3d> normals;
    Eigen::Vector3d stripe; //!< the direction in the light plane that is known best
    bool isFan; //!< the directions are all alike: normals that fan out about `stripe` are among the candidates
};

//! From all directions by least squares (paper (25)), then from pairs of them, then the fan.
NormalCandidates findNormals(const std::vector<VanishingDirection>& directions,
                             const AlignedVector<Eigen::Vector3d>& knownPoints);

//! n turned about the axis in steps of 2 degrees, without n itself.
AlignedVector<Eigen::Vector3d> fanOfNormals(const Eigen::Vector3d& n, const Eigen::Vector3d& axis);

}} // namespace cv::active_handeye

#endif
