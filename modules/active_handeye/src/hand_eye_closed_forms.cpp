// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "hand_eye_closed_forms.hpp"
#include "decompositions.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::Vector4d;
using Eigen::VectorXd;

namespace {

typedef Eigen::Matrix<double, 8, 1> Vector8d;

//! (w, x, y, z) with w >= 0, so that A and B of one motion have quaternions of the same sign.
Vector4d quaternionOf(const Matrix3d& R)
{
    const Eigen::Quaterniond q(R);
    const Vector4d wxyz(q.w(), q.x(), q.y(), q.z());
    return q.w() < 0 ? Vector4d(-wxyz) : wxyz;
}

Matrix3d rotationOf(const Vector4d& wxyz)
{
    return Eigen::Quaterniond(wxyz(0), wxyz(1), wxyz(2), wxyz(3)).normalized().toRotationMatrix();
}

//! Matrix of p -> q p.
Matrix4d leftProduct(const Vector4d& q)
{
    Matrix4d Q;
    Q << q(0), -q.tail<3>().transpose(), q.tail<3>(), q(0) * Matrix3d::Identity() + skew(q.tail<3>());
    return Q;
}

//! Matrix of p -> p q.
Matrix4d rightProduct(const Vector4d& q)
{
    Matrix4d W;
    W << q(0), -q.tail<3>().transpose(), q.tail<3>(), q(0) * Matrix3d::Identity() - skew(q.tail<3>());
    return W;
}

//! Turns for which the rotation vector 2 sin(angle / 2) of Tsai's equations is neither too short nor too near its fold.
HandEyeMotions motionsForTsai(const HandEyeMotions& motions)
{
    const double shortest = 0.3, longest = 1.7;
    const auto suits = [&](const Pose& pose)
    {
        const double length = 2 * quaternionOf(pose.R).tail<3>().norm();
        return length >= shortest && length <= longest;
    };
    HandEyeMotions used;
    double largest = 0, smallest = CV_PI;
    for (const HandEyeMotion& motion : motions)
    {
        const double angle = logRotation(motion.gripper.R).norm();
        largest = std::max(largest, angle);
        smallest = std::min(smallest, angle);
        if (suits(motion.gripper) && suits(motion.camera))
            used.push_back(motion);
    }
    if (used.size() < 2)
        CV_Error(
            Error::StsNoConv,
            cv::format(
                "R_gripper2base: CALIB_HAND_EYE_TSAI needs two or more turns of %.0f to %.0f deg, given %d (turns from "
                "%.2f to %.2f deg): turn more, or use another method",
                2 * std::asin(shortest / 2) * 180 / CV_PI, 2 * std::asin(longest / 2) * 180 / CV_PI, int(used.size()),
                smallest * 180 / CV_PI, largest * 180 / CV_PI));
    return used;
}

//! [P_A + P_B]x p = P_B - P_A for p = tan(angle / 2) axis of R_cam2gripper.
Matrix3d rotationOfTsai(const HandEyeMotions& motions)
{
    MatrixXd A(3 * motions.size(), 3);
    VectorXd b(3 * motions.size());
    for (int k = 0; k < int(motions.size()); ++k)
    {
        const Vector3d gripper = 2 * quaternionOf(motions[k].gripper.R).tail<3>(),
                       camera = 2 * quaternionOf(motions[k].camera.R).tail<3>();
        A.middleRows<3>(3 * k) = skew(gripper + camera);
        b.segment<3>(3 * k) = camera - gripper;
    }
    const Eigen::JacobiSVD<MatrixXd> svd = thinSVD(A);
    if (!(svd.singularValues()(2) > 1e-12 * svd.singularValues()(0)))
        CV_Error(
            Error::StsNoConv,
            "R_gripper2base: CALIB_HAND_EYE_TSAI needs turns about two axes that are not parallel among those of 17 "
            "to 116 deg, and a camera that is not turned by 180 deg against the gripper: use another method");
    Vector4d q;
    q << 1, svd.solve(b);
    return rotationOf(q);
}

Pose tsai(const HandEyeMotions& motions)
{
    const HandEyeMotions used = motionsForTsai(motions);
    const Matrix3d R = rotationOfTsai(used);
    return Pose{R, translationOf(used, R)};
}

Pose park(const HandEyeMotions& motions)
{
    const Matrix3d R = rotationFromLogarithms(motions);
    return Pose{R, translationOf(motions, R)};
}

//! q_A q = q q_B
Pose horaud(const HandEyeMotions& motions)
{
    Matrix4d S = Matrix4d::Zero();
    for (const HandEyeMotion& motion : motions)
    {
        const Matrix4d difference =
            leftProduct(quaternionOf(motion.gripper.R)) - rightProduct(quaternionOf(motion.camera.R));
        S += difference.transpose() * difference;
    }
    const Matrix3d R = rotationOf(symmetricEigen<MatrixXd>(S).eigenvectors().col(0));
    return Pose{R, translationOf(motions, R)};
}

//! (I - R_A (x) R_B) vec R = 0 and (I (x) t_B^T) vec R + (I - R_A) t = t_A, R row by row, for the 12 numbers of R and t.
Pose andreff(const HandEyeMotions& motions)
{
    MatrixXd A = MatrixXd::Zero(12 * motions.size(), 12);
    VectorXd b = VectorXd::Zero(12 * motions.size());
    for (int k = 0; k < int(motions.size()); ++k)
    {
        const Pose &gripper = motions[k].gripper, &camera = motions[k].camera;
        for (int row = 0; row < 3; ++row)
        {
            for (int column = 0; column < 3; ++column)
                A.block<3, 3>(12 * k + 3 * row, 3 * column) =
                    double(row == column) * Matrix3d::Identity() - gripper.R(row, column) * camera.R;
            A.block<1, 3>(12 * k + 9 + row, 3 * row) = camera.t.transpose();
        }
        A.block<3, 3>(12 * k + 9, 9) = Matrix3d::Identity() - gripper.R;
        b.segment<3>(12 * k + 9) = gripper.t;
    }
    const VectorXd x = leastSquaresSolution(A, b);
    const Matrix3d M = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(x.data());
    if (!(std::abs(M.determinant()) > 1e-6))
        CV_Error(
            Error::StsNoConv,
            "t_gripper2base: CALIB_HAND_EYE_ANDREFF takes the scale of R_cam2gripper from translations of gripper and "
            "camera, and these give none: translate more, or use another method");
    return Pose{nearestRotation(M.determinant() < 0 ? Matrix3d(-M) : M), x.tail<3>()};
}

Vector8d dualQuaternionOf(const Pose& pose)
{
    Vector8d q;
    q.head<4>() = quaternionOf(pose.R);
    Vector4d t;
    t << 0, pose.t;
    q.tail<4>() = 0.5 * leftProduct(t) * q.head<4>();
    return q;
}

//! The combination of two null vectors that is a unit dual quaternion: |q| = 1, q.q' = 0.
Vector8d unitCombination(const Vector8d& first, const Vector8d& second)
{
    const double a = first.head<4>().dot(first.tail<4>()), c = second.head<4>().dot(second.tail<4>()),
                 b = first.head<4>().dot(second.tail<4>()) + second.head<4>().dot(first.tail<4>());
    const double q = -0.5 * (b + std::copysign(std::sqrt(std::max(0., b * b - 4 * a * c)), b));
    Vector8d best = Vector8d::Zero();
    for (const Eigen::Vector2d& weights : {Eigen::Vector2d(q, a), Eigen::Vector2d(c, q)}) // roots q / a and c / q
    {
        const Vector8d sum = weights.stableNormalized()(0) * first + weights.stableNormalized()(1) * second;
        if (sum.head<4>().norm() > best.head<4>().norm())
            best = sum;
    }
    return best / best.head<4>().norm();
}

//! Screw axes of A and B: a - b + [a + b]x in the unknown dual quaternion.
Pose daniilidis(const HandEyeMotions& motions)
{
    MatrixXd T = MatrixXd::Zero(6 * motions.size(), 8);
    for (int k = 0; k < int(motions.size()); ++k)
    {
        const Vector8d a = dualQuaternionOf(motions[k].gripper), b = dualQuaternionOf(motions[k].camera);
        Eigen::Matrix<double, 3, 4> real, dual;
        real << (a - b).segment<3>(1), skew((a + b).segment<3>(1));
        dual << (a - b).segment<3>(5), skew((a + b).segment<3>(5));
        T.block<3, 4>(6 * k, 0) = real;
        T.block<3, 4>(6 * k + 3, 0) = dual;
        T.block<3, 4>(6 * k + 3, 4) = real;
    }
    const Eigen::JacobiSVD<MatrixXd> svd = thinSVD(T);
    const Vector8d q = unitCombination(svd.matrixV().col(6), svd.matrixV().col(7));
    Vector4d conjugate = -q.head<4>();
    conjugate(0) = q(0);
    return Pose{rotationOf(q.head<4>()), 2 * (leftProduct(q.tail<4>()) * conjugate).tail<3>()};
}

struct ClosedForm
{
    HandEyeMethod method;
    Pose (*solve)(const HandEyeMotions&);
};

const ClosedForm closedForms[] = {{CALIB_HAND_EYE_TSAI, tsai},
                                  {CALIB_HAND_EYE_PARK, park},
                                  {CALIB_HAND_EYE_HORAUD, horaud},
                                  {CALIB_HAND_EYE_ANDREFF, andreff},
                                  {CALIB_HAND_EYE_DANIILIDIS, daniilidis}};

} // namespace

Matrix3d rotationFromLogarithms(const HandEyeMotions& motions)
{
    Matrix3d M = Matrix3d::Zero();
    for (const HandEyeMotion& motion : motions)
        M += logRotation(motion.gripper.R) * logRotation(motion.camera.R).transpose();
    return nearestRotation(M);
}

Vector3d translationOf(const HandEyeMotions& motions, const Matrix3d& R_cam2gripper)
{
    MatrixXd A(3 * motions.size(), 3);
    VectorXd b(3 * motions.size());
    for (int k = 0; k < int(motions.size()); ++k)
    {
        A.middleRows<3>(3 * k) = motions[k].gripper.R - Matrix3d::Identity();
        b.segment<3>(3 * k) = R_cam2gripper * motions[k].camera.t - motions[k].gripper.t;
    }
    return leastSquaresSolution(A, b);
}

Pose handEyeClosedForm(const HandEyeMotions& motions, HandEyeMethod method)
{
    for (const ClosedForm& form : closedForms)
        if (form.method == method)
        {
            const Pose pose = form.solve(motions);
            if (!pose.R.allFinite() || !pose.t.allFinite())
                CV_Error(Error::StsNoConv,
                         cv::format("R_gripper2base: method %d has no solution for these poses: use another one",
                                    int(method)));
            return pose;
        }
    CV_Error(Error::StsOutOfRange,
             cv::format("method: needed CALIB_HAND_EYE_TSAI (0) to CALIB_HAND_EYE_REFINED (5), given %d", int(method)));
}

}} // namespace cv::active_handeye
