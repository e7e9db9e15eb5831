// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "stripe_directions.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::Vector3d;

typedef Eigen::SelfAdjointEigenSolver<Matrix3d> Eigen3;

Vector3d interpretationNormal(const StripeView& view)
{
    return view.rays[0].cross(view.rays[1]).normalized();
}

//! Standard deviation of m.r in units of the angular error of the line's ends: r = alpha ray0 + beta ray1.
static double leverage(const StripeView& view, const Vector3d& r)
{
    Eigen::Matrix<double, 3, 2> ends;
    ends << view.rays[0].normalized(), view.rays[1].normalized();
    const Eigen::Vector2d alphaBeta = (ends.transpose() * ends).inverse() * (ends.transpose() * r);
    return std::max(1e-3, alphaBeta.norm());
}

static double missBy(const StripeView& view, const Vector3d& r, double focal)
{
    return std::abs(interpretationNormal(view).dot(r)) / leverage(view, r) * focal;
}

//! Weighted least squares over the lines that agree with r so far; the first pass takes all of them.
static void refineDirection(const StripeSurface& surface, double focal, bool useAll, VanishingDirection& direction)
{
    const int passes = 3;
    for (int pass = 0; pass < passes; ++pass)
    {
        Matrix3d M = Matrix3d::Zero();
        for (size_t i = 0; i < surface.views.size(); ++i)
        {
            const StripeView& view = surface.views[i];
            if (!useAll && direction.errors[i] > startTolerance)
                continue;
            const Vector3d m = interpretationNormal(view);
            const double deviation = (useAll && pass == 0 ? 1 : leverage(view, direction.r)) * view.line.sigma / focal;
            M += m * m.transpose() / (deviation * deviation);
        }
        const Eigen3 eigen(M);
        direction.r = eigen.eigenvectors().col(0);
        const double largestDeviation = 0.3; // rad
        const double information = eigen.eigenvalues()(1);
        direction.determined = information * largestDeviation * largestDeviation > 1;
        direction.covariance.setZero();
        for (int i = 1; i < 3; ++i)
            direction.covariance += eigen.eigenvectors().col(i) * eigen.eigenvectors().col(i).transpose() /
                                    std::max(eigen.eigenvalues()(i), 1e-300);
    }
}

static void countAgreeing(const StripeSurface& surface, double focal, VanishingDirection& direction)
{
    direction.errors.clear();
    direction.agreeing = 0;
    for (const StripeView& view : surface.views)
    {
        direction.errors.push_back(missBy(view, direction.r, focal));
        direction.agreeing += direction.errors.back() <= startTolerance;
    }
}

VanishingDirection findVanishingDirection(const StripeSurface& surface, const Matrix3d& K)
{
    const double focal = std::sqrt(K(0, 0) * K(1, 1));
    VanishingDirection best;
    refineDirection(surface, focal, true, best);
    countAgreeing(surface, focal, best);
    if (best.worst() <= startTolerance)
        return best;
    for (size_t i = 0; i < surface.views.size(); ++i)
        for (size_t j = i + 1; j < surface.views.size(); ++j)
        {
            const Vector3d cross = interpretationNormal(surface.views[i]).cross(interpretationNormal(surface.views[j]));
            if (cross.norm() < 1e-9)
                continue;
            VanishingDirection candidate = best;
            candidate.r = cross.normalized();
            countAgreeing(surface, focal, candidate);
            if (candidate.agreeing > best.agreeing)
                best = candidate;
        }
    if (best.agreeing >= 3)
    {
        refineDirection(surface, focal, false, best);
        countAgreeing(surface, focal, best);
    }
    return best;
}

//! Known points: their differences are perpendicular to n.
static Matrix3d knownPointEquations(const AlignedVector<Vector3d>& knownPoints)
{
    Matrix3d M = Matrix3d::Zero();
    Vector3d mean = Vector3d::Zero();
    for (const Vector3d& X : knownPoints)
        mean += X / double(knownPoints.size());
    for (const Vector3d& X : knownPoints)
        M += (X - mean) * (X - mean).transpose() / std::pow(1e-3 * X.z(), 2);
    return M;
}

AlignedVector<Vector3d> fanOfNormals(const Vector3d& n, const Vector3d& axis)
{
    AlignedVector<Vector3d> normals;
    for (int degrees = 2; degrees < 180; degrees += 2)
        normals.push_back(Eigen::AngleAxisd(degrees * CV_PI / 180, axis) * n);
    return normals;
}

NormalCandidates findNormals(const std::vector<VanishingDirection>& directions,
                             const AlignedVector<Vector3d>& knownPoints)
{
    NormalCandidates candidates;
    const Matrix3d known = knownPointEquations(knownPoints);
    Eigen3 eigen;
    Vector3d n = Vector3d::Zero();
    for (int pass = 0; pass < 3; ++pass)
    {
        Matrix3d M = known;
        for (const VanishingDirection& direction : directions)
            M += direction.r * direction.r.transpose() / ((pass ? n.dot(direction.covariance * n) : 0) + 1e-8);
        eigen.compute(M);
        n = eigen.eigenvectors().col(0);
    }
    candidates.normals.push_back(n);
    for (size_t i = 0; i < directions.size(); ++i)
        for (size_t j = i + 1; j < directions.size(); ++j)
        {
            const Vector3d cross = directions[i].r.cross(directions[j].r);
            if (cross.norm() > 0.02 && candidates.normals.size() < 60)
                candidates.normals.push_back(cross.normalized());
        }
    const double weak = 0.05; // rad: n is free to turn about the common direction
    candidates.isFan = eigen.eigenvalues()(1) * weak * weak < 1;
    candidates.stripe = eigen.eigenvectors().col(2);
    if (candidates.isFan)
        for (const Vector3d& turned : fanOfNormals(n, candidates.stripe))
            candidates.normals.push_back(turned);
    return candidates;
}

}} // namespace cv::active_handeye
