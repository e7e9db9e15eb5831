// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_STRIPE_DEPTHS_HPP
#define OPENCV_ACTIVE_HANDEYE_STRIPE_DEPTHS_HPP

#include "light_plane_problem.hpp"

namespace cv { namespace active_handeye {

//! A tracked point in the base frame.
struct ScenePoint
{
    Eigen::Vector3d X; //!< NaN where the rays have no parallax or miss the point by more than 5 px
    double
        parallax; //!< rad, over all of its rays: their directions' error over this is the relative error of its depth
};

typedef AlignedVector<ScenePoint> ScenePoints;

//! Scene points from their image points in all views, by the nearest point to their rays.
ScenePoints triangulate(const std::vector<Pixels>& imagePoints, const Camera& camera,
                        const AlignedVector<Pose>& cam2base);

//! A ray on the stripe and the inverse depth of a scene point seen near it.
struct StripeDepth
{
    Eigen::Vector3d ray;
    double inverseDepth;
};

//! For every tracked point within searchRadius pixels of a segment: the nearest pixel of that segment.
AlignedVector<StripeDepth> depthsNearStripes(const std::vector<Pixels>& segments, const std::vector<int>& views,
                                             const std::vector<Pixels>& imagePoints, const ScenePoints& scenePoints,
                                             const Camera& camera, const AlignedVector<Pose>& cam2base,
                                             double searchRadius);

//! Scene points of well known depth that a view shows at most 30 px (undistorted) beside a line, between its ends.
//! imagePoints: those of the view.
AlignedVector<Eigen::Vector3d> pointsBeside(const StripeLine& line, const Pixels& imagePoints,
                                            const ScenePoints& scenePoints, const Camera& camera);

//! Light plane from 1 / depth = (n / d).ray, three unknowns, robustly. Throws StsNoConv when it is not determined.
LightPlane lightPlaneFromDepths(const AlignedVector<StripeDepth>& depths, double focal);

}} // namespace cv::active_handeye

#endif
