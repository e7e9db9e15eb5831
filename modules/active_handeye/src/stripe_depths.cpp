// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "stripe_depths.hpp"
#include "decompositions.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

static ScenePoint nearestToRays(const AlignedVector<Vector3d>& origins, const AlignedVector<Vector3d>& directions)
{
    Matrix3d A = Matrix3d::Zero();
    Vector3d b = Vector3d::Zero();
    for (size_t i = 0; i < origins.size(); ++i)
    {
        const Matrix3d across = Matrix3d::Identity() - directions[i] * directions[i].transpose();
        A += across;
        b += across * origins[i];
    }
    const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(A);
    const double leastParallax = 0.003; // rad
    const double parallax = std::sqrt(std::max(0., eigen.eigenvalues()(0)));
    if (origins.size() < 2 || parallax < leastParallax)
        return ScenePoint{Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()), 0};
    return ScenePoint{solveSymmetric(A, b), parallax};
}

ScenePoints triangulate(const std::vector<Pixels>& imagePoints, const Camera& camera,
                        const AlignedVector<Pose>& cam2base)
{
    const double largestMiss = 5; // px
    ScenePoints points;
    for (size_t j = 0; j < imagePoints[0].size(); ++j)
    {
        AlignedVector<Vector3d> origins, directions;
        for (size_t v = 0; v < imagePoints.size(); ++v)
            if (imagePoints[v][j].allFinite())
            {
                origins.push_back(cam2base[v].t);
                directions.push_back(cam2base[v].R * camera.ray(imagePoints[v][j]).normalized());
            }
        ScenePoint point = nearestToRays(origins, directions);
        Vector3d& X = point.X;
        for (size_t v = 0; v < imagePoints.size() && X.allFinite(); ++v)
        {
            if (!imagePoints[v][j].allFinite())
                continue;
            const Vector3d seen = cam2base[v].R.transpose() * (X - cam2base[v].t);
            if (seen.z() <= 0 || (camera.project(seen) - imagePoints[v][j]).norm() > largestMiss)
                X.setConstant(std::numeric_limits<double>::quiet_NaN());
        }
        points.push_back(point);
    }
    return points;
}

AlignedVector<StripeDepth> depthsNearStripes(const std::vector<Pixels>& segments, const std::vector<int>& views,
                                             const std::vector<Pixels>& imagePoints, const ScenePoints& scenePoints,
                                             const Camera& camera, const AlignedVector<Pose>& cam2base,
                                             double searchRadius)
{
    AlignedVector<StripeDepth> depths;
    for (size_t s = 0; s < segments.size(); ++s)
    {
        const Pose& pose = cam2base[views[s]];
        for (size_t j = 0; j < scenePoints.size(); ++j)
        {
            const Vector2d& pixel = imagePoints[views[s]][j];
            if (!pixel.allFinite() || !scenePoints[j].X.allFinite())
                continue;
            const auto nearer = [&](const Vector2d& a, const Vector2d& b)
            { return (a - pixel).squaredNorm() < (b - pixel).squaredNorm(); };
            const Vector2d nearest = *std::min_element(segments[s].begin(), segments[s].end(), nearer);
            if ((nearest - pixel).norm() <= searchRadius)
                depths.push_back(StripeDepth{camera.ray(nearest),
                                             1 / (pose.R.transpose() * (scenePoints[j].X - pose.t)).z()});
        }
    }
    return depths;
}

AlignedVector<Vector3d> pointsBeside(const StripeLine& line, const Pixels& imagePoints, const ScenePoints& scenePoints,
                                     const Camera& camera)
{
    const double leastParallax = 0.1;                    // rad: 0.1 px of error shift a depth like 1 px of the stripe
    const double farthest = 30;                          // px
    const double reach = std::sqrt(3) * line.halfLength; // RMS extent -> half of the whole
    AlignedVector<Vector3d> beside;
    for (size_t j = 0; j < scenePoints.size(); ++j)
    {
        if (!imagePoints[j].allFinite() || !(scenePoints[j].parallax >= leastParallax) || !scenePoints[j].X.allFinite())
            continue;
        const Vector2d ideal = (camera.K * camera.ray(imagePoints[j])).hnormalized();
        if (std::abs(line.distance(ideal)) <= farthest && std::abs(line.direction.dot(ideal - line.centre)) <= reach)
            beside.push_back(scenePoints[j].X);
    }
    return beside;
}

namespace {

//! mu = n / d
Vector3d solveInverseDepths(const AlignedVector<StripeDepth>& depths, const std::vector<int>& used)
{
    Matrix3d A = Matrix3d::Zero();
    Vector3d b = Vector3d::Zero();
    for (int i : used)
    {
        A += depths[i].ray * depths[i].ray.transpose();
        b += depths[i].inverseDepth * depths[i].ray;
    }
    return solveSymmetric(A, b);
}

std::vector<int> agreeing(const AlignedVector<StripeDepth>& depths, const Vector3d& mu, double focal, double tolerance)
{
    const double pixelsPerUnit = focal / mu.head<2>().norm();
    std::vector<int> inliers;
    for (size_t i = 0; i < depths.size(); ++i)
        if (std::abs(mu.dot(depths[i].ray) - depths[i].inverseDepth) * pixelsPerUnit <= tolerance)
            inliers.push_back(int(i));
    return inliers;
}

} // namespace

LightPlane lightPlaneFromDepths(const AlignedVector<StripeDepth>& depths, double focal)
{
    const int fewest = 30, trials = 500;
    if (depths.size() < fewest)
        CV_Error(
            Error::StsNoConv,
            cv::format(
                "imagePoints: too few tracked points near the stripes; needed at least %d within searchRadius, given %d",
                fewest, int(depths.size())));
    RNG rng(1);
    const double coarse = 4, fine = 2; // px
    std::vector<int> best;
    for (int trial = 0; trial < trials; ++trial)
    {
        const int count = int(depths.size());
        const Vector3d mu =
            solveInverseDepths(depths, {rng.uniform(0, count), rng.uniform(0, count), rng.uniform(0, count)});
        const std::vector<int> inliers = agreeing(depths, mu, focal, coarse);
        if (inliers.size() > best.size())
            best = inliers;
    }
    Vector3d mu = best.empty() ? Vector3d::Zero().eval() : solveInverseDepths(depths, best);
    for (int pass = 0; pass < 5 && !best.empty(); ++pass)
    {
        best = agreeing(depths, mu, focal, fine);
        if (!best.empty())
            mu = solveInverseDepths(depths, best);
    }
    if (best.size() * 3 < depths.size())
        CV_Error(
            Error::StsNoConv,
            cv::format(
                "imagePoints: no light plane agrees with the depths of the tracked points near the stripes; needed a third of "
                "them within %g px, given %d of %d",
                fine, int(best.size()), int(depths.size())));
    return LightPlane{mu.normalized(), 1 / mu.norm()};
}

}} // namespace cv::active_handeye
