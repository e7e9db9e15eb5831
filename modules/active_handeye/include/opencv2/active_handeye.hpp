// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_HPP
#define OPENCV_ACTIVE_HANDEYE_HPP

#include "opencv2/active_handeye/foe.hpp"
#include "opencv2/active_handeye/translations.hpp"
#include "opencv2/active_handeye/rotation.hpp"
#include "opencv2/active_handeye/stripe.hpp"
#include "opencv2/active_handeye/light_plane.hpp"
#include "opencv2/active_handeye/refine.hpp"
#include "opencv2/active_handeye/hand_eye.hpp"
#include "opencv2/active_handeye/verify.hpp"
#include "opencv2/active_handeye/profile.hpp"
#include "opencv2/active_handeye/measure.hpp"
#include "opencv2/active_handeye/planning.hpp"

/**
@defgroup active_handeye Calibration of a robot's camera and laser without a calibration target

A camera (and often a line laser) is fixed to the flange of a robot and looks at any textured scene. The robot makes a few translations and
changes of orientation; from ordinary scene points and laser stripes this module computes the camera matrix, the hand-eye transform and
the light plane.

    robot poses + image points  --> estimateFOE                     the direction of one translation in the image
                                --> calibrateHandEyeTranslations    cameraMatrix, R_cam2gripper
                                --> calibrateHandEyeRotation        t_cam2gripper
    + laser stripes             --> detectStripe, splitStripe, associateStripes
                                --> calibrateLightPlane             lightPlane
    planned views               --> planHandEyeViews, predictHandEyeCovariance      where to go, and what comes of it
    everything at once          --> refineHandEye                   all parameters, noise levels, covariance, verdict
    robot poses + target poses  --> calibrateHandEye, calibrateHandEyeExtended      with a target: as cv::calibrateHandEye
    stripes + calibration       --> reprojectStripe                 points in space
                                --> locateOnStripe, findProfileCorners, measureStripePoints     characteristic points
    new views + calibration     --> verifyHandEye                   still valid?

Frames are named as in cv::calibrateHandEye: R_a2b, t_a2b map a point of frame a into frame b. A scene point X of the base frame is seen at
\f[ x \sim K R_{cam2gripper}^T ( R_{gripper2base}^T (X - t_{gripper2base}) - t_{cam2gripper} ) \f]
Lengths may be in any unit: the results have the same. For a fixed camera that looks at a textured object in the gripper (eye-to-hand) pass the
inverted robot poses, as with cv::calibrateHandEye; the result is then the transform from the camera to the robot base.

Degenerate cases are refused: an answer that the data cannot support is a cv::Exception (StsNoConv) that says what is missing.

@{
    @defgroup active_handeye_foe Focus of expansion
    @defgroup active_handeye_translations Camera matrix and rotation from translations
    @defgroup active_handeye_rotation Translation from changes of orientation
    @defgroup active_handeye_stripe Laser stripes in images
    @defgroup active_handeye_light_plane Light plane
    @defgroup active_handeye_refine Joint refinement
    @defgroup active_handeye_hand_eye Hand-eye transform from poses of a target
    @defgroup active_handeye_planning Planned views
    @defgroup active_handeye_profile Characteristic points of a stripe
    @defgroup active_handeye_measure Points in space from stripes
    @defgroup active_handeye_verify Is a calibration still valid?
@}
*/

#endif
