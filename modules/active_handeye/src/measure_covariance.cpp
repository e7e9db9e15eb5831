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

typedef Eigen::Matrix<double, 3, 2> Matrix32d;
typedef Eigen::Matrix<double, 3, CALIBRATION_PARAMETERS> PointByCalibration;

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

//! Infinite variance for the coordinates that hang on a parameter which was not observed.
void markUnobserved(const PointByCalibration& J, const std::vector<int>& unobserved, Matrix3d& covariance)
{
    for (int parameter : unobserved)
        for (int i = 0; i < 3; ++i)
            if (std::abs(J(i, parameter)) > 1e-12 * J.col(parameter).norm())
            {
                covariance.row(i).setZero();
                covariance.col(i).setZero();
                covariance(i, i) = std::numeric_limits<double>::infinity();
            }
}

} // namespace

Matrix3d MeasurementErrors::covariance(const StripeGeometry& geometry, const Vector3d& ray, double pixelSigma) const
{
    const Pose cam2frame = geometry.cam2frame();
    const LightPlane& light = geometry.light;
    const double slope = light.n.dot(ray), depth = light.d / slope;
    const Matrix2d pixelByRay =
        geometry.camera.K.topLeftCorner<2, 2>() * geometry.camera.distortJacobian(ray.head<2>());
    const Matrix32d byRay = depth * (Matrix3d::Identity() - ray * light.n.transpose() / slope).leftCols<2>();

    const Matrix32d byPixel = cam2frame.R * byRay * pixelByRay.inverse();
    Matrix3d result = pixelSigma * pixelSigma * byPixel * byPixel.transpose();

    const Vector3d arm = cam2frame.R * (depth * ray) + cam2frame.t - geometry.gripper2base.t;
    result.diagonal().array() += robotTranslationSigma * robotTranslationSigma;
    result -= robotRotationSigma * robotRotationSigma * skew(arm) * skew(arm);

    const PointByCalibration J = pointByCalibration(geometry, ray, byRay);
    result += J * calibration * J.transpose();
    result = (0.5 * (result + result.transpose())).eval();
    markUnobserved(J, unobserved, result);
    return result;
}

}} // namespace cv::active_handeye
