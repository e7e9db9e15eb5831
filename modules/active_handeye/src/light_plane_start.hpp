// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_LIGHT_PLANE_START_HPP
#define OPENCV_ACTIVE_HANDEYE_LIGHT_PLANE_START_HPP

#include "stripe_directions.hpp"

namespace cv { namespace active_handeye {

//! d from how the lines of one surface move with the camera (method of the null vector, see the header's steps).
//! NaN when it is not determined. `views` are indices into surface.views, at least three.
double offsetFromMotion(const Eigen::Vector3d& n, const Eigen::Vector3d& r, const StripeSurface& surface,
                        const std::vector<int>& views);

//! The plane of the surface that agrees best with its lines for this light plane; returns the sum of squared line errors [px],
//! each at most startTolerance.
double fitSurface(const LightPlane& light, const Eigen::Matrix3d& K, StripeSurface& surface);

//! Closed form over all surfaces; fits surfaces[].plane. Returns false when no candidate has the scene in front of the camera.
bool startLightPlane(const Eigen::Matrix3d& K, const std::vector<VanishingDirection>& directions,
                     const AlignedVector<Eigen::Vector3d>& knownPoints, StripeSurfaces& surfaces, LightPlane& light);

//! The best offset for each of the normals that fan out about the best known stripe direction, where there is one.
AlignedVector<LightPlane> fanOfLightPlanes(const Eigen::Matrix3d& K, const LightPlane& light,
                                           const AlignedVector<Eigen::Vector3d>& knownPoints, StripeSurfaces surfaces);

}} // namespace cv::active_handeye

#endif
