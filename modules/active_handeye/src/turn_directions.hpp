// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_TURN_DIRECTIONS_HPP
#define OPENCV_ACTIVE_HANDEYE_TURN_DIRECTIONS_HPP

#include "pose.hpp"

namespace cv { namespace active_handeye {

const double smallestTurn = 0.1; //!< degrees: less does not count as a change of orientation

//! Which directions of t_cam2gripper the changes of orientation show.
struct TurnDirections
{
    explicit TurnDirections(const AlignedVector<Pose>& gripper2base);

    Eigen::MatrixXd observed; //!< 3 x rank basis, gripper frame
    Eigen::Vector3d axis;     //!< the direction least observed: the common axis of all turns, gripper frame
    Eigen::Vector3d axisInBase;
};

}} // namespace cv::active_handeye

#endif
