// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "measure.hpp"
#include "residuals.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

//! Derivative of the point, in the frame of the geometry, by all calibration parameters.
PointByCalibration pointByCalibration(const StripeGeometry& geometry, const Vector3d& ray, const Matrix32d& pointByRay)
{
    const double slope = geometry.light.n.dot(ray);
    const Vector3d X = ray * (geometry.light.d / slope);
    PointByCalibration J = PointByCalibration::Zero();
    J.middleCols<10>(PARAMETER_CAMERA) = pointByRay * rayByCamera(geometry.camera, ray.head<2>());
    J.middleCols<3>(PARAMETER_NORMAL) = -X * ray.transpose() / slope;
    J.col(PARAMETER_OFFSET) = ray / slope;
    if (geometry.frame == StripeGeometry::CAMERA)
        return J;
    J = (geometry.cam2gripper.R * J).eval();
    J.middleCols<3>(PARAMETER_ROTATION) = -skew(geometry.cam2gripper.R * X);
    J.middleCols<3>(PARAMETER_TRANSLATION).setIdentity();
    return geometry.gripper2base.R * J;
}

} // namespace

ReprojectedPoint::ReprojectedPoint(const StripeGeometry& geometry, const Vector3d& ray)
{
    const Pose cam2frame = geometry.cam2frame();
    const LightPlane& light = geometry.light;
    const double slope = light.n.dot(ray), depth = light.d / slope;
    const Matrix2d pixelByRay =
        geometry.camera.K.topLeftCorner<2, 2>() * geometry.camera.distortJacobian(ray.head<2>());
    const Matrix32d byRay = depth * (Matrix3d::Identity() - ray * light.n.transpose() / slope).leftCols<2>();
    X = cam2frame.R * (depth * ray) + cam2frame.t;
    arm = X - geometry.gripper2base.t;
    byPixel = cam2frame.R * byRay * pixelByRay.inverse();
    byCalibration = pointByCalibration(geometry, ray, byRay);
}

Matrix3d MeasurementErrors::fromRobot(const ReprojectedPoint& a, const ReprojectedPoint& b) const
{
    return robotTranslationSigma * robotTranslationSigma * Matrix3d::Identity() -
           robotRotationSigma * robotRotationSigma * skew(a.arm) * skew(b.arm);
}

Matrix3d MeasurementErrors::fromCalibration(const ReprojectedPoint& a, const ReprojectedPoint& b) const
{
    return a.byCalibration * calibration * b.byCalibration.transpose();
}

void MeasurementErrors::markUnobserved(const ReprojectedPoint& point, Matrix3d& covariance) const
{
    const PointByCalibration& J = point.byCalibration;
    for (int parameter : unobserved)
        for (int i = 0; i < 3; ++i)
            if (std::abs(J(i, parameter)) > 1e-12 * J.col(parameter).norm())
            {
                covariance.row(i).setZero();
                covariance.col(i).setZero();
                covariance(i, i) = std::numeric_limits<double>::infinity();
            }
}

Matrix3d MeasurementErrors::covariance(const ReprojectedPoint& point, const Matrix2d& pixelCovariance) const
{
    Matrix3d result = point.byPixel * pixelCovariance * point.byPixel.transpose() + fromRobot(point, point) +
                      fromCalibration(point, point);
    result = (0.5 * (result + result.transpose())).eval();
    markUnobserved(point, result);
    return result;
}

}} // namespace cv::active_handeye
