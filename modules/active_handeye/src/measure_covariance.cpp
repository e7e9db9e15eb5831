// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "measure.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

typedef Eigen::Matrix<double, 2, 10> Matrix2x10d;
typedef Eigen::Matrix<double, 3, 2> Matrix32d;
typedef Eigen::Matrix<double, 3, CALIBRATION_PARAMETERS> PointByCalibration;

namespace {

//! Derivatives of a viewing ray (x, y, 1), from pixel = K distort(x, y).
struct RayDerivatives
{
    Matrix2d byPixel;
    Matrix2x10d byCamera; //!< fx, fy, cx, cy, skew, k1, k2, p1, p2, k3, for a fixed pixel

    RayDerivatives(const Camera& camera, const Vector2d& ideal)
    {
        const double x = ideal.x(), y = ideal.y(), r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2;
        const Matrix2d scale = camera.K.topLeftCorner<2, 2>();
        const Vector2d distorted = camera.distort(ideal);
        Matrix2x10d pixelByCamera;
        pixelByCamera.leftCols<5>() << distorted.x(), 0, 1, 0, distorted.y(), //
            0, distorted.y(), 0, 1, 0;
        Eigen::Matrix<double, 2, 5> distortedBy;
        distortedBy << x * r2, x * r4, 2 * x * y, r2 + 2 * x * x, x * r6, //
            y * r2, y * r4, r2 + 2 * y * y, 2 * x * y, y * r6;
        pixelByCamera.rightCols<5>() = scale * distortedBy;
        byPixel = (scale * camera.distortJacobian(ideal)).inverse();
        byCamera = -byPixel * pixelByCamera;
    }
};

//! Derivative of the point, in the frame of the geometry, by all calibration parameters.
PointByCalibration pointByCalibration(const StripeGeometry& geometry, const Vector3d& ray,
                                      const Matrix2x10d& rayByCamera, const Matrix32d& pointByRay)
{
    const double slope = geometry.light.n.dot(ray);
    const Vector3d X = ray * (geometry.light.d / slope);
    PointByCalibration J = PointByCalibration::Zero();
    J.middleCols<10>(PARAMETER_CAMERA) = pointByRay * rayByCamera;
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
    const RayDerivatives rayDerivatives(geometry.camera, ray.head<2>());
    const Matrix32d byRay = depth * (Matrix3d::Identity() - ray * light.n.transpose() / slope).leftCols<2>();

    const Matrix32d byPixel = cam2frame.R * byRay * rayDerivatives.byPixel;
    Matrix3d result = pixelSigma * pixelSigma * byPixel * byPixel.transpose();

    const Vector3d arm = cam2frame.R * (depth * ray) + cam2frame.t - geometry.gripper2base.t;
    result.diagonal().array() += robotTranslationSigma * robotTranslationSigma;
    result -= robotRotationSigma * robotRotationSigma * skew(arm) * skew(arm);

    const PointByCalibration J = pointByCalibration(geometry, ray, rayDerivatives.byCamera, byRay);
    result += J * calibration * J.transpose();
    result = (0.5 * (result + result.transpose())).eval();
    markUnobserved(J, unobserved, result);
    return result;
}

}} // namespace cv::active_handeye
