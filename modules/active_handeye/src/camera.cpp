// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "camera.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

bool Camera::hasDistortion() const
{
    return std::any_of(D, D + 5, [](double k) { return k != 0; });
}

//! Distorted coordinates and, where wanted, their derivative: together they cost little more than one of them.
static inline Vector2d distorted(const double* D, const Vector2d& ideal, Matrix2d* J)
{
    const double x = ideal.x(), y = ideal.y(), r2 = x * x + y * y;
    const double radial = 1 + r2 * (D[0] + r2 * (D[1] + r2 * D[4]));
    if (J)
    {
        const double slope = 2 * (D[0] + r2 * (2 * D[1] + r2 * 3 * D[4])); // d radial / d(r2), times 2
        (*J)(0, 0) = radial + slope * x * x + 2 * D[2] * y + 6 * D[3] * x;
        (*J)(0, 1) = (*J)(1, 0) = slope * x * y + 2 * D[2] * x + 2 * D[3] * y;
        (*J)(1, 1) = radial + slope * y * y + 6 * D[2] * y + 2 * D[3] * x;
    }
    return Vector2d(x * radial + 2 * D[2] * x * y + D[3] * (r2 + 2 * x * x),
                    y * radial + D[2] * (r2 + 2 * y * y) + 2 * D[3] * x * y);
}

Vector2d Camera::distort(const Vector2d& ideal) const
{
    return distorted(D, ideal, nullptr);
}

Matrix2d Camera::distortJacobian(const Vector2d& ideal) const
{
    Matrix2d J;
    distorted(D, ideal, &J);
    return J;
}

Vector3d Camera::ray(const Vector2d& pixel) const
{
    const double y = (pixel.y() - K(1, 2)) / K(1, 1);
    const double x = (pixel.x() - K(0, 2) - K(0, 1) * y) / K(0, 0);
    const Vector2d target(x, y);
    if (!hasDistortion())
        return target.homogeneous();
    Matrix2d J;
    Vector2d ideal = 2 * target - distort(target), reached = distorted(D, ideal, &J);
    if (J.determinant() <= 0)
        reached = distorted(D, ideal = target, &J);
    const int maxIterations = 50;
    for (int i = 0; i < maxIterations && J.determinant() > 0; ++i)
    {
        const Vector2d step = J.inverse() * (target - reached); // Newton
        ideal += step;
        if (step.squaredNorm() <= 1e-16 * (1 + ideal.squaredNorm())) // it converges quadratically
            return ideal.homogeneous();
        reached = distorted(D, ideal, &J);
    }
    CV_Error(
        Error::StsOutOfRange,
        cv::format("distCoeffs: the lens model cannot be inverted at pixel (%.1f, %.1f); needed coefficients whose "
                   "distortion grows monotonically over the image, given (%g, %g, %g, %g, %g)",
                   pixel.x(), pixel.y(), D[0], D[1], D[2], D[3], D[4]));
}

Vector2d Camera::idealPixel(const Vector2d& pixel) const
{
    return hasDistortion() ? Vector2d((K * ray(pixel)).head<2>()) : pixel;
}

Vector2d Camera::project(const Vector3d& X) const
{
    return (K * distort(X.head<2>() / X.z()).homogeneous()).head<2>();
}

}} // namespace cv::active_handeye
