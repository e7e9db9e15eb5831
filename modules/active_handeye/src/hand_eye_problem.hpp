// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Poses of robot and camera with errors: residuals, their covariance, and the least-squares problem they make.
#ifndef OPENCV_ACTIVE_HANDEYE_HAND_EYE_PROBLEM_HPP
#define OPENCV_ACTIVE_HANDEYE_HAND_EYE_PROBLEM_HPP

#include "calibration_state.hpp"
#include "hand_eye_motions.hpp"
#include "least_squares.hpp"

namespace cv { namespace active_handeye {

enum HandEyeNoise
{
    NOISE_TARGET_ROTATION,
    NOISE_TARGET_TRANSLATION,
    NOISE_ROBOT_ROTATION,
    NOISE_ROBOT_TRANSLATION,
    HAND_EYE_NOISES
};

typedef Eigen::Matrix<double, 6, 6> Matrix6d;
typedef Eigen::Matrix<double, 12, 12> Matrix12d;
typedef Eigen::Matrix<double, 12, 1> Vector12d;
typedef Eigen::Matrix<double, 6, 12> Matrix6x12d;
typedef Eigen::Matrix<double, HAND_EYE_NOISES, 1> NoiseVariances;

struct HandEyeState
{
    Pose cam2gripper, target2base;

    //! Step: cam2gripper, then target2base, each rotation vector and translation.
    HandEyeState moved(const Vector12d& step) const;
};

//! One view, linearised (doc/method/hand_eye.md, (3), (4)).
struct HandEyeResidual
{
    Vector6d value; //!< rotation vector and translation of the target in the camera frame, predicted - given
    Matrix6x12d jacobian;
    Eigen::Vector3d arm; //!< from the gripper to the target, camera frame

    //! Covariance of the value when one noise has variance 1.
    Matrix6d covariance(int noise) const;
    Matrix6d covariance(const NoiseVariances& variances) const;
};

typedef AlignedVector<HandEyeResidual> HandEyeResiduals;

Vector6d residualOf(const HandEyeViews& views, int view, const HandEyeState& state);
HandEyeResidual linearizedResidual(const HandEyeViews& views, int view, const HandEyeState& state);

//! Least squares of the chosen views, weighted by the covariance at the state it starts from.
class HandEyeProblem : public LeastSquaresProblem
{
public:
    HandEyeProblem(const HandEyeViews& views, const std::vector<int>& chosen, const HandEyeState& state,
                   const NoiseVariances& variances);

    double linearize(Eigen::MatrixXd& JtJ, Eigen::VectorXd& Jtr) CV_OVERRIDE;
    double costAfter(const Eigen::VectorXd& step) const CV_OVERRIDE;
    void apply(const Eigen::VectorXd& step) CV_OVERRIDE;

    //! Of the sum of squares in standard deviations: far below what can be told.
    double negligibleDecrease() const CV_OVERRIDE { return 1e-10; }

    const HandEyeState& state() const { return state_; }

private:
    const HandEyeViews& views_;
    const std::vector<int>& chosen_;
    HandEyeState state_;
    AlignedVector<Eigen::LLT<Matrix6d>> covariances_;
};

}} // namespace cv::active_handeye

#endif
