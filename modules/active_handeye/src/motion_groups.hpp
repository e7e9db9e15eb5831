// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_MOTION_GROUPS_HPP
#define OPENCV_ACTIVE_HANDEYE_MOTION_GROUPS_HPP

#include "pose.hpp"

namespace cv { namespace active_handeye {

//! Views between which the gripper only translated.
struct MotionGroup
{
    std::vector<int> views;                          //!< in the order given
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity(); //!< R_gripper2base of the group: mean of its views

    //! Displacement of the gripper from the group's first view to `pose`, in the gripper frame.
    Eigen::Vector3d displacement(const Pose& first, const Pose& pose) const
    {
        return R.transpose() * (pose.t - first.t);
    }
};

//! Views whose orientations agree within toleranceDeg with the first view of their group; every view is in one group.
std::vector<MotionGroup> groupByOrientation(const AlignedVector<Pose>& gripper2base, double toleranceDeg);

//! Angle between two orientations, degrees.
double angleBetween(const Eigen::Matrix3d& R1, const Eigen::Matrix3d& R2);

//! Throws StsNoConv when no group has two views, naming the two views that come nearest.
void requireTranslation(const std::vector<MotionGroup>& groups, const AlignedVector<Pose>& gripper2base,
                        double toleranceDeg);

}} // namespace cv::active_handeye

#endif
