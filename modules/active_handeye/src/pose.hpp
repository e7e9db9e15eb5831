// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_POSE_HPP
#define OPENCV_ACTIVE_HANDEYE_POSE_HPP

namespace cv { namespace active_handeye {

//! Rigid transform: a point X of frame a is R X + t in frame b.
struct Pose
{
    Eigen::Matrix3d R;
    Eigen::Vector3d t;
};

//! Cross-product matrix: skew(v) w = v x w.
Eigen::Matrix3d skew(const Eigen::Vector3d& v);

//! Rotation of angle |w| about w.
Eigen::Matrix3d expRotation(const Eigen::Vector3d& w);

//! Rotation vector of R, accurate for the smallest angles; |result| <= pi.
Eigen::Vector3d logRotation(const Eigen::Matrix3d& R);

//! Rotation nearest to M in the Frobenius norm (Kabsch).
Eigen::Matrix3d nearestRotation(const Eigen::Matrix3d& M);

//! Two unit vectors that complete the unit vector v to an orthonormal basis.
Eigen::Matrix<double, 3, 2> tangentBasis(const Eigen::Vector3d& v);

}} // namespace cv::active_handeye

#endif
