// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_REFINE_INPUT_HPP
#define OPENCV_ACTIVE_HANDEYE_REFINE_INPUT_HPP

#include "calibration_state.hpp"
#include "input.hpp"

namespace cv { namespace active_handeye {

//! What a caller of refineHandEye measured, checked.
struct RefineMeasurements
{
    AlignedVector<Pose> gripper2base;
    std::vector<Pixels> imagePoints;
    std::vector<std::vector<double>> pointSigmas; //!< empty = all alike
    AlignedVector<Eigen::Vector3d> objectPoints;  //!< NaN = unknown; empty = none known
    std::vector<Pixels> stripes;
    std::vector<int> stripeViews, surfaceIds;
    std::vector<double> stripeSigmas; //!< empty = from the segments
};

//! V arrays of N positive numbers; those of points that were not seen do not matter. Empty = none given.
std::vector<std::vector<double>> readPointSigmas(InputArrayOfArrays pointSigmas,
                                                 const std::vector<Pixels>& imagePoints);

//! N points of 3 coordinates, all three finite or all three NaN. Empty = none given.
AlignedVector<Eigen::Vector3d> readObjectPoints(InputArray objectPoints, size_t points);

//! One positive number for every segment. Empty = none given.
std::vector<double> readStripeSigmas(InputArray stripeSigmas, size_t segments);

//! (nx, ny, nz, d), |n| = 1, d > 0.
LightPlane readLightPlane(InputArray lightPlane);

//! Throws StsOutOfRange / StsBadArg naming the setting.
void checkRefineParams(const RefineParams& params);

}} // namespace cv::active_handeye

#endif
