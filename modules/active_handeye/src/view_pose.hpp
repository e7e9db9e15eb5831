// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_VIEW_POSE_HPP
#define OPENCV_ACTIVE_HANDEYE_VIEW_POSE_HPP

#include "scene_tracks.hpp"

namespace cv { namespace active_handeye {

/** Pose of the gripper in one view from the present scene points, which stay where they are (robust resection).

It starts at the view's present pose. `scale`: typical normalised error of a right match. Fewer than 4 points leave the pose as it is.
*/
Pose resectView(const SceneTracks& tracks, const CalibrationState& state, int view, double scale);

}} // namespace cv::active_handeye

#endif
