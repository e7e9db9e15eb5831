// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// What a camera at planned poses would see of an assumed scene.
#ifndef OPENCV_ACTIVE_HANDEYE_PLANNED_VIEWS_HPP
#define OPENCV_ACTIVE_HANDEYE_PLANNED_VIEWS_HPP

#include "refine_problem.hpp"

namespace cv { namespace active_handeye {

//! Calibration and scene that are taken for true.
struct AssumedScene
{
    HandEyeCalibration calibration;
    Size imageSize;
    AlignedVector<Eigen::Vector3d> points;   //!< base frame
    AlignedVector<Eigen::Vector4d> surfaces; //!< (w, e) of length 1, w to the side from which it is seen

    CameraView view(const Pose& gripper2base) const { return CameraView(gripper2base, calibration.cam2gripper); }

    //! Pixel of a point; false where the view does not see it.
    bool project(const CameraView& view, const Eigen::Vector3d& X, Eigen::Vector2d& pixel) const;

    //! Pixels of all points; NaN = not seen.
    Pixels project(const CameraView& view) const;

    //! Stripes on all surfaces in all views, numbered in this order.
    StripeSegments stripes(const AlignedVector<Pose>& gripper2base) const;

private:
    bool isInFront(const CameraView& view, const Eigen::Vector4d& surface) const;
    bool isHidden(const CameraView& view, const Eigen::Vector3d& X) const;
    bool contains(const Eigen::Vector2d& pixel) const;
    bool stripeEnds(const CameraView& view, const Eigen::Vector4d& surface, Eigen::Vector2d (&ends)[2]) const;
};

}} // namespace cv::active_handeye

#endif
