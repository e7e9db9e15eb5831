// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "hand_eye_problem.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::Vector3d;

HandEyeState HandEyeState::moved(const Vector12d& step) const
{
    return HandEyeState{active_handeye::moved(cam2gripper, step.head<6>()),
                        active_handeye::moved(target2base, step.tail<6>())};
}

Matrix6d HandEyeResidual::covariance(int noise) const
{
    const double leastShare = 1e-8; // keeps the sum invertible where the robot's rotation is the only noise
    const Matrix3d I = Matrix3d::Identity(), S = skew(arm);
    Matrix6d V = Matrix6d::Zero();
    if (noise == NOISE_TARGET_ROTATION)
        V.topLeftCorner<3, 3>() = I;
    else if (noise == NOISE_ROBOT_ROTATION)
        V << (1 + leastShare) * I, S, S.transpose(), S * S.transpose() + leastShare * arm.squaredNorm() * I;
    else
        V.bottomRightCorner<3, 3>() = I;
    return V;
}

Matrix6d HandEyeResidual::covariance(const NoiseVariances& variances) const
{
    Matrix6d sum = Matrix6d::Zero();
    for (int noise = 0; noise < HAND_EYE_NOISES; ++noise)
        sum += variances(noise) * covariance(noise);
    return sum;
}

Vector6d residualOf(const HandEyeViews& views, int view, const HandEyeState& state)
{
    const Pose predicted = inverse(views.gripper2base[view] * state.cam2gripper) * state.target2base,
               given = views.target2cam[view];
    Vector6d residual;
    residual << logRotation(predicted.R * given.R.transpose()), predicted.t - given.t;
    return residual;
}

//! log(exp(a) exp(w)) = w + J a to first order in a.
static Matrix3d inverseLeftJacobian(const Vector3d& w)
{
    const double angle = w.norm();
    const double factor = angle < 1e-4 ? 1. / 12 : (1 - 0.5 * angle / std::tan(0.5 * angle)) / (angle * angle);
    return Matrix3d::Identity() - 0.5 * skew(w) + factor * skew(w) * skew(w);
}

HandEyeResidual linearizedResidual(const HandEyeViews& views, int view, const HandEyeState& state)
{
    const Pose& gripper = views.gripper2base[view];
    const Matrix3d R_gripper2cam = state.cam2gripper.R.transpose(), R_base2cam = R_gripper2cam * gripper.R.transpose();
    const Vector3d arm = state.target2base.t - gripper.t;
    const Vector3d fromCamera = gripper.R.transpose() * arm - state.cam2gripper.t; // to the target, gripper frame
    HandEyeResidual residual;
    residual.value = residualOf(views, view, state);
    residual.arm = R_base2cam * arm;
    const Matrix3d byTurn = inverseLeftJacobian(residual.value.head<3>());
    residual.jacobian.setZero();
    residual.jacobian.block<3, 3>(0, 0) = -byTurn * R_gripper2cam;
    residual.jacobian.block<3, 3>(0, 6) = byTurn * R_base2cam;
    residual.jacobian.block<3, 3>(3, 0) = R_gripper2cam * skew(fromCamera);
    residual.jacobian.block<3, 3>(3, 3) = -R_gripper2cam;
    residual.jacobian.block<3, 3>(3, 9) = R_base2cam;
    return residual;
}

HandEyeProblem::HandEyeProblem(const HandEyeViews& views, const std::vector<int>& chosen, const HandEyeState& state,
                               const NoiseVariances& variances)
    : views_(views), chosen_(chosen), state_(state)
{
    for (int view : chosen)
        covariances_.push_back(Eigen::LLT<Matrix6d>(linearizedResidual(views, view, state).covariance(variances)));
}

double HandEyeProblem::linearize(Eigen::MatrixXd& JtJ, Eigen::VectorXd& Jtr)
{
    double cost = 0;
    JtJ.setZero(12, 12);
    Jtr.setZero(12);
    for (size_t i = 0; i < chosen_.size(); ++i)
    {
        const HandEyeResidual residual = linearizedResidual(views_, chosen_[i], state_);
        const Matrix6x12d J = covariances_[i].matrixL().solve(residual.jacobian);
        const Vector6d r = covariances_[i].matrixL().solve(residual.value);
        JtJ += J.transpose() * J;
        Jtr += J.transpose() * r;
        cost += r.squaredNorm();
    }
    return cost;
}

double HandEyeProblem::costAfter(const Eigen::VectorXd& step) const
{
    const HandEyeState state = state_.moved(step);
    double cost = 0;
    for (size_t i = 0; i < chosen_.size(); ++i)
        cost += covariances_[i].matrixL().solve(residualOf(views_, chosen_[i], state)).squaredNorm();
    return cost;
}

void HandEyeProblem::apply(const Eigen::VectorXd& step)
{
    state_ = state_.moved(step);
}

}} // namespace cv::active_handeye
