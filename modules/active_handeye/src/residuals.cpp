// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "residuals.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

typedef Eigen::Matrix<double, 2, 3> Matrix23d;
typedef Eigen::Matrix<double, 2, 5> Matrix25d;

static const double smallestDepth = 1e-9; // of the distance

static bool isInFront(const Vector3d& Y)
{
    return Y.z() > smallestDepth * Y.norm();
}

//! Derivative of distort() by k1, k2, p1, p2, k3.
static Matrix25d distortByCoefficients(const Vector2d& ideal)
{
    const double x = ideal.x(), y = ideal.y(), r2 = x * x + y * y, r4 = r2 * r2;
    Matrix25d J;
    J << x * r2, x * r4, 2 * x * y, r2 + 2 * x * x, x * r4 * r2, //
        y * r2, y * r4, r2 + 2 * y * y, 2 * x * y, y * r4 * r2;
    return J;
}

bool PointResidual::evaluate(const Camera& camera, const CameraView& view, const Vector3d& X, const Vector2d& pixel,
                             Vector2d& error)
{
    const Vector3d Y = view.toCamera(X);
    if (!isInFront(Y))
        return false;
    error = camera.project(Y) - pixel;
    return true;
}

bool PointResidual::linearizePoint(const Camera& camera, const CameraView& view, const Vector3d& X,
                                   const Vector2d& pixel)
{
    const Vector3d Y = view.toCamera(X);
    if (!isInFront(Y))
        return false;
    const double inverseDepth = 1 / Y.z();
    const Vector2d ideal = Y.head<2>() * inverseDepth;
    const Matrix3d& K = camera.K;
    const Vector2d distorted = camera.distort(ideal);
    error << K(0, 0) * distorted.x() + K(0, 1) * distorted.y() + K(0, 2) - pixel.x(),
        K(1, 1) * distorted.y() + K(1, 2) - pixel.y();
    const Matrix2d J = K.topLeftCorner<2, 2>() * camera.distortJacobian(ideal) * inverseDepth;
    Matrix23d byCameraPoint;
    byCameraPoint << J, -J * ideal;
    byPoint.noalias() = byCameraPoint * view.R_base2cam;
    return true;
}

bool PointResidual::linearize(const Camera& camera, const CameraView& view, const Vector3d& X, const Vector2d& pixel)
{
    if (!linearizePoint(camera, view, X, pixel))
        return false;
    const Vector3d Y = view.toCamera(X);
    const Vector2d ideal = Y.head<2>() / Y.z(), distorted = camera.distort(ideal);
    byCalibration.leftCols<COLUMN_DISTORTION>() << distorted.x(), 0, 1, 0, distorted.y(), //
        0, distorted.y(), 0, 1, 0;
    byCalibration.middleCols<5>(COLUMN_DISTORTION).noalias() =
        camera.K.topLeftCorner<2, 2>() * distortByCoefficients(ideal);
    const Matrix23d byGripperPoint = byPoint * view.gripper.R;
    const Vector3d arm = X - view.centre;
    Matrix23d turned;
    for (int row = 0; row < 2; ++row) // byPoint * skew(arm)
        turned.row(row) = byPoint.row(row).transpose().cross(arm).transpose();
    byCalibration.middleCols<3>(COLUMN_ROTATION).noalias() = turned * view.gripper.R;
    byCalibration.middleCols<3>(COLUMN_TRANSLATION) = -byGripperPoint;
    return true;
}

Eigen::Matrix<double, 2, 6> PointResidual::byPose(const CameraView& view, const Vector3d& X) const
{
    Eigen::Matrix<double, 3, 6> motion;
    motion << skew(X - view.gripper.t), -Matrix3d::Identity();
    return byPoint * motion;
}

Eigen::Matrix<double, 2, 10> rayByCamera(const Camera& camera, const Vector2d& ideal)
{
    const Matrix3d& K = camera.K;
    const Vector2d distorted = camera.distort(ideal);
    Eigen::Matrix<double, 2, 10> pixelBy;
    pixelBy << distorted.x(), 0, 1, 0, distorted.y(), 0, 0, 0, 0, 0, //
        0, distorted.y(), 0, 1, 0, 0, 0, 0, 0, 0;
    pixelBy.rightCols<5>() = K.topLeftCorner<2, 2>() * distortByCoefficients(ideal);
    const Matrix2d byIdeal = K.topLeftCorner<2, 2>() * camera.distortJacobian(ideal);
    return -byIdeal.inverse() * pixelBy; // K distort(x, y) = pixel stays
}

bool StripeResidual::linearize(const HandEyeCalibration& calibration, const CameraView& view,
                               const Eigen::Vector4d& surface, const Vector2d& pixel)
{
    const LightPlane& light = calibration.light;
    const Vector3d w = surface.head<3>(), wc = view.R_base2cam * w;
    const double ec = surface(3) - w.dot(view.centre);
    const Vector3d m = calibration.camera.ray(pixel);
    const Vector3d line = ec * light.n - light.d * wc;
    // Distance in ideal pixels: the gradient of line.m by the ideal pixel is K2^-T line_xy.
    const Matrix2d toIdeal = calibration.camera.K.topLeftCorner<2, 2>().inverse();
    const Vector2d gradient = toIdeal.transpose() * line.head<2>();
    const double length = gradient.norm();
    if (!(length > 1e-12 * line.norm() * toIdeal.norm()))
        return false;
    error = line.dot(m) / length;

    // d error = (m - error * d length / d line) . d line / length + line_xy . d m / length; the change of length with K is of second order.
    const Vector2d lengthByLine = toIdeal * gradient / length;
    Vector3d byLine = m;
    byLine.head<2>() -= error * lengthByLine;
    byLine /= length;
    const Eigen::RowVector2d byRay = line.head<2>().transpose() / length;

    const double byDistance = light.n.dot(byLine);                     // by e_c
    const Eigen::RowVector3d byNormal = -light.d * byLine.transpose(); // by w_c
    const Eigen::RowVector3d bySurfaceNormal = byNormal * view.R_base2cam;
    byCalibration.setZero();
    byCalibration.head<10>() = byRay * rayByCamera(calibration.camera, m.head<2>());
    // w_c = R_base2cam w: a turn exp(a) of the camera in the base frame changes it by R_base2cam (w x a).
    const Vector3d byTurn = bySurfaceNormal.transpose().cross(w);
    byCalibration.segment<3>(COLUMN_ROTATION) = byTurn.transpose() * view.gripper.R;
    byCalibration.segment<3>(COLUMN_TRANSLATION) = -byDistance * w.transpose() * view.gripper.R;
    byCalibration.segment<2>(COLUMN_NORMAL) = ec * byLine.transpose() * tangentBasis(light.n);
    byCalibration(COLUMN_OFFSET) = -wc.dot(byLine);
    // centre = R_gripper2base t + t_gripper2base: a turn of the gripper moves it by a x (centre - t_gripper2base).
    byPose.head<3>() = (byTurn - byDistance * (view.centre - view.gripper.t).cross(w)).transpose();
    byPose.tail<3>() = -byDistance * w.transpose();
    bySurface.head<3>() = bySurfaceNormal - byDistance * view.centre.transpose();
    bySurface(3) = byDistance;
    return true;
}

}} // namespace cv::active_handeye
