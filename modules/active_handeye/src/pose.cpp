// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "pose.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d skew(const Vector3d& v)
{
    Matrix3d S;
    S << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
    return S;
}

Matrix3d expRotation(const Vector3d& w)
{
    const double angle = w.norm();
    if (angle < 1e-300)
        return Matrix3d::Identity();
    return Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
}

Vector3d logRotation(const Matrix3d& R)
{
    Eigen::Quaterniond q(R);
    if (q.w() < 0)
        q.coeffs() = -q.coeffs();
    const double sinHalf = q.vec().norm();
    if (sinHalf < 1e-300)
        return Vector3d::Zero();
    return q.vec() * (2 * std::atan2(sinHalf, q.w()) / sinHalf);
}

Matrix3d nearestRotation(const Matrix3d& M)
{
    const Eigen::JacobiSVD<Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const double handedness = (svd.matrixU() * svd.matrixV().transpose()).determinant();
    return svd.matrixU() * Vector3d(1, 1, handedness).asDiagonal() * svd.matrixV().transpose();
}

Eigen::Matrix<double, 3, 2> tangentBasis(const Vector3d& v)
{
    Eigen::Matrix<double, 3, 2> basis;
    basis.col(0) = v.unitOrthogonal();
    basis.col(1) = v.cross(basis.col(0)).normalized();
    return basis;
}

}} // namespace cv::active_handeye
