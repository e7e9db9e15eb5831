// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "light_plane_problem.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector4d;

typedef Eigen::Matrix<double, 4, 3> Matrix43d;
typedef Eigen::Matrix<double, 6, 1> Vector6d;

static const double knownPointError = 1e-3; // of its depth

Vector3d interpretationPlane(const LightPlane& light, const Vector4d& surface, const Vector3d& displacement)
{
    const Vector3d w = surface.head<3>();
    return (surface(3) - w.dot(displacement)) * light.n - light.d * w;
}

static double pixelDistance(const Vector3d& line, const Vector2d& pixel)
{
    return line.dot(pixel.homogeneous()) / line.head<2>().norm();
}

double lineError(const Matrix3d& K, const LightPlane& light, const Vector4d& surface, const StripeView& view)
{
    const Vector3d line = K.inverse().transpose() * interpretationPlane(light, surface, view.displacement);
    const double first = pixelDistance(line, view.line.end(0)), second = pixelDistance(line, view.line.end(1));
    return std::sqrt(0.5 * (first * first + second * second));
}

//! Orthonormal basis of the directions in which the unit 4-vector v can move (Householder).
static Matrix43d tangentBasis4(const Vector4d& v)
{
    const double sign = v(0) < 0 ? -1 : 1;
    const Vector4d u = (v + sign * Vector4d::Unit(0)).normalized();
    const Eigen::Matrix4d H = Eigen::Matrix4d::Identity() - 2 * u * u.transpose();
    return H.rightCols<3>();
}

LightPlaneProblem::LightPlaneProblem(const Matrix3d& K, const AlignedVector<Vector3d>& knownPoints, double cauchyScale,
                                     const LightPlane& start, const StripeSurfaces& surfaces)
    : lineOfPlane_(K.inverse().transpose()), knownPoints_(knownPoints), cauchyScale_(cauchyScale), light_(start),
      surfaces_(surfaces)
{}

double LightPlaneProblem::robustCost(double residual, double sigma) const
{
    const double k = cauchyScale_ / sigma;
    return std::isfinite(k) ? k * k * std::log1p(residual * residual / (k * k)) : residual * residual;
}

double LightPlaneProblem::robustWeight(double residual, double sigma) const
{
    const double k = cauchyScale_ / sigma;
    return std::isfinite(k) ? 1 / (1 + residual * residual / (k * k)) : 1;
}

int LightPlaneProblem::residuals() const
{
    int count = int(knownPoints_.size());
    for (const StripeSurface& surface : surfaces_)
        count += 2 * int(surface.views.size());
    return count;
}

//! Derivative of the interpretation plane by the steps of n (2), d (1) and the surface (3).
static Eigen::Matrix<double, 3, 6> planeJacobian(const LightPlane& light, const Vector4d& surface, const Vector3d& c)
{
    const Vector3d w = surface.head<3>();
    Eigen::Matrix<double, 3, 4> bySurface;
    bySurface.leftCols<3>() = -light.n * c.transpose() - light.d * Matrix3d::Identity();
    bySurface.col(3) = light.n;
    Eigen::Matrix<double, 3, 6> J;
    J.leftCols<2>() = (surface(3) - w.dot(c)) * tangentBasis(light.n);
    J.col(2) = -w;
    J.rightCols<3>() = bySurface * tangentBasis4(surface);
    return J;
}

double LightPlaneProblem::linearize(Eigen::MatrixXd& JtJ, Eigen::VectorXd& Jtr)
{
    JtJ.setZero(unknowns(), unknowns());
    Jtr.setZero(unknowns());
    for (size_t s = 0; s < surfaces_.size(); ++s)
        for (const StripeView& view : surfaces_[s].views)
        {
            const Vector4d& plane = surfaces_[s].plane;
            const Vector3d line = lineOfPlane_ * interpretationPlane(light_, plane, view.displacement);
            const Eigen::Matrix<double, 3, 6> lineJ = lineOfPlane_ * planeJacobian(light_, plane, view.displacement);
            const double length = line.head<2>().norm(), sigma = view.line.sigma;
            for (int end = 0; end < 2; ++end)
            {
                Vector3d gradient = view.line.end(end).homogeneous() / length;
                const double distance = line.dot(gradient);
                gradient.head<2>() -= distance * line.head<2>() / (length * length);
                const Vector6d J = lineJ.transpose() * gradient / sigma;
                const double residual = distance / sigma, weight = robustWeight(residual, sigma);
                const int at = 3 + 3 * int(s);
                JtJ.topLeftCorner<3, 3>() += weight * J.head<3>() * J.head<3>().transpose();
                JtJ.block<3, 3>(0, at) += weight * J.head<3>() * J.tail<3>().transpose();
                JtJ.block<3, 3>(at, at) += weight * J.tail<3>() * J.tail<3>().transpose();
                Jtr.head<3>() += weight * residual * J.head<3>();
                Jtr.segment<3>(at) += weight * residual * J.tail<3>();
            }
        }
    for (const Vector3d& X : knownPoints_)
    {
        const double sigma = knownPointError * std::abs(X.z()), residual = (light_.n.dot(X) - light_.d) / sigma;
        Vector3d J;
        J << tangentBasis(light_.n).transpose() * X, -1;
        JtJ.topLeftCorner<3, 3>() += J * J.transpose() / (sigma * sigma);
        Jtr.head<3>() += residual / sigma * J;
    }
    JtJ.bottomLeftCorner(unknowns() - 3, 3) = JtJ.topRightCorner(3, unknowns() - 3).transpose();
    return cost(moved(Eigen::VectorXd::Zero(unknowns())));
}

LightPlaneProblem::State LightPlaneProblem::moved(const Eigen::VectorXd& step) const
{
    State state;
    state.light.n = (light_.n + tangentBasis(light_.n) * step.head<2>()).normalized();
    state.light.d = light_.d + step(2);
    for (size_t s = 0; s < surfaces_.size(); ++s)
    {
        const Vector4d& plane = surfaces_[s].plane;
        state.planes.push_back((plane + tangentBasis4(plane) * step.segment<3>(3 + 3 * s)).normalized());
    }
    return state;
}

double LightPlaneProblem::cost(const State& state) const
{
    double sum = 0;
    for (size_t s = 0; s < surfaces_.size(); ++s)
        for (const StripeView& view : surfaces_[s].views)
        {
            const Vector3d line = lineOfPlane_ * interpretationPlane(state.light, state.planes[s], view.displacement);
            for (int end = 0; end < 2; ++end)
                sum += robustCost(pixelDistance(line, view.line.end(end)) / view.line.sigma, view.line.sigma);
        }
    for (const Vector3d& X : knownPoints_)
        sum += std::pow((state.light.n.dot(X) - state.light.d) / (knownPointError * X.z()), 2);
    return std::isfinite(sum) ? sum : std::numeric_limits<double>::infinity();
}

double LightPlaneProblem::costAfter(const Eigen::VectorXd& step) const
{
    const State state = moved(step);
    return state.light.d > 0 ? cost(state) : std::numeric_limits<double>::infinity();
}

void LightPlaneProblem::apply(const Eigen::VectorXd& step)
{
    const State state = moved(step);
    light_ = state.light;
    for (size_t s = 0; s < surfaces_.size(); ++s)
        surfaces_[s].plane = state.planes[s];
}

}} // namespace cv::active_handeye
