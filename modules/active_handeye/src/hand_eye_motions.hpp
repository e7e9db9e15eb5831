// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_HAND_EYE_MOTIONS_HPP
#define OPENCV_ACTIVE_HANDEYE_HAND_EYE_MOTIONS_HPP

#include "pose.hpp"

namespace cv { namespace active_handeye {

Pose inverse(const Pose& pose);

//! `second` after `first`.
Pose operator*(const Pose& second, const Pose& first);

//! Poses of the gripper and of a target as the camera sees it, view by view.
struct HandEyeViews
{
    AlignedVector<Pose> gripper2base, target2cam;

    int count() const { return int(gripper2base.size()); }

    //! Pose of the target in the base, as one view tells it.
    Pose target2base(int view, const Pose& cam2gripper) const
    {
        return gripper2base[view] * cam2gripper * target2cam[view];
    }
};

//! Motions between two views, A X = X B.
struct HandEyeMotion
{
    Pose gripper; //!< A: from the gripper of view i to that of view j
    Pose camera;  //!< B: the same of the camera
};
typedef AlignedVector<HandEyeMotion> HandEyeMotions;

//! Of every pair of views i < j.
HandEyeMotions motionsOf(const HandEyeViews& views);

//! Throws StsNoConv, naming what is missing, unless gripper and camera turn about two axes that are not parallel.
void requireTurns(const HandEyeViews& views);

//! Throws StsBadArg when the camera's translations fit the robot's in another unit of length only.
void requireSameUnit(const HandEyeMotions& motions);

//! Throws StsNoConv unless most views agree on where the target is; says so when they would with poses inverted.
void requireAgreement(const HandEyeViews& views, const Pose& cam2gripper);

//! Throws StsNoConv, with the same hint, when less than two thirds of the views agree.
void requireMostViews(const HandEyeViews& views, int agreeing);

}} // namespace cv::active_handeye

#endif
