// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_LIGHT_PLANE_DIAGNOSIS_HPP
#define OPENCV_ACTIVE_HANDEYE_LIGHT_PLANE_DIAGNOSIS_HPP

#include "stripe_directions.hpp"

namespace cv { namespace active_handeye {

//! R_cam2base of each group, to name directions in base coordinates.
typedef std::vector<Eigen::Matrix3d> GroupOrientations;

/** Why the stripes do not determine the light plane, and what motion would: translations along the stripe only, stripes
that stand still, one direction across the stripe only, one common stripe direction. `light` may be null.
*/
std::string explainWeakness(const StripeSurfaces& surfaces, const std::vector<VanishingDirection>& directions,
                            const GroupOrientations& cam2base, const LightPlane* light);

//! "segment 7 (view 3, surface 2) by 4.1 px"
std::string describeContradiction(const StripeView& view, int surfaceId, double error);

}} // namespace cv::active_handeye

#endif
