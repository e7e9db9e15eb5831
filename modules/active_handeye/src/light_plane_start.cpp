// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "light_plane_start.hpp"
#include "decompositions.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector4d;

typedef Eigen::SelfAdjointEigenSolver<Matrix3d> Eigen3;

double offsetFromMotion(const Vector3d& n, const Vector3d& r, const StripeSurface& surface,
                        const std::vector<int>& views)
{
    const Vector3d along = (r - n * n.dot(r)).normalized(), q = along.cross(n);
    Vector4d h = Vector4d(1, 0, 0, 0); // (e0 - y_n, w_n, w_q, y_q), y = d w
    for (int pass = 0; pass < 3; ++pass)
    {
        Eigen::Matrix4d M = Eigen::Matrix4d::Zero();
        for (int i : views)
        {
            const StripeView& view = surface.views[i];
            const Vector3d p = along.cross(interpretationNormal(view));
            const double pn = p.dot(n), pq = p.dot(q), cn = view.displacement.dot(n), cq = view.displacement.dot(q);
            const double scale = pass ? Vector2d(h(0) - cn * h(1) - cq * h(2), h(3)).norm() : 1;
            const Vector4d row = Vector4d(pn, -pn * cn, -pn * cq, -pq) / std::max(scale, 1e-9);
            M += row * row.transpose();
        }
        const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen = symmetricEigen<Eigen::MatrixXd>(M);
        if (eigen.eigenvalues()(1) <= 1e-14 * eigen.eigenvalues()(3))
            return std::numeric_limits<double>::quiet_NaN();
        h = eigen.eigenvectors().col(0);
    }
    return h(3) / h(2);
}

namespace {

//! Points of the scene on the ends of the lines, in the camera frame of the group's first view.
struct SurfacePoints
{
    AlignedVector<Vector3d> X; //!< two per view
    std::vector<double> weights;

    SurfacePoints(const LightPlane& light, const StripeSurface& surface)
    {
        for (const StripeView& view : surface.views)
            for (const Vector3d& ray : view.rays)
            {
                const double depth = light.d / light.n.dot(ray);
                X.push_back(depth * ray + view.displacement);
                weights.push_back(depth > 0 && std::isfinite(depth) ? 1 / (depth * depth) : 0);
            }
    }

    Vector4d plane(const std::vector<int>& views) const
    {
        Vector3d mean = Vector3d::Zero();
        double sum = 1e-300;
        for (int v : views)
            for (int i = 2 * v; i < 2 * v + 2; ++i)
            {
                mean += weights[i] * X[i];
                sum += weights[i];
            }
        mean /= sum;
        Matrix3d scatter = Matrix3d::Zero();
        for (int v : views)
            for (int i = 2 * v; i < 2 * v + 2; ++i)
                scatter += weights[i] * (X[i] - mean) * (X[i] - mean).transpose();
        const Vector3d w = Eigen3(scatter).eigenvectors().col(0);
        return (Vector4d() << w, w.dot(mean)).finished().normalized();
    }
};

//! Sum of truncated squared errors; the views within the tolerance.
double agreement(const LightPlane& light, const Matrix3d& K, const StripeSurface& surface, std::vector<int>& agreeing)
{
    double cost = 0;
    agreeing.clear();
    for (int v = 0; v < int(surface.views.size()); ++v)
    {
        const double error = lineError(K, light, surface.plane, surface.views[v]);
        const bool agrees = error <= startTolerance; // false for NaN
        cost += agrees ? error * error : startTolerance * startTolerance;
        if (agrees)
            agreeing.push_back(v);
    }
    return cost;
}

} // namespace

double fitSurface(const LightPlane& light, const Matrix3d& K, StripeSurface& surface)
{
    const SurfacePoints points(light, surface);
    std::vector<int> agreeing, all;
    for (int v = 0; v < int(surface.views.size()); ++v)
        all.push_back(v);
    surface.plane = points.plane(all);
    double best = agreement(light, K, surface, agreeing);
    if (agreeing.size() == all.size() || all.size() < 4)
        return best;
    Vector4d bestPlane = surface.plane;
    const auto keepIfBetter = [&](const std::vector<int>& views)
    {
        surface.plane = points.plane(views);
        const double cost = agreement(light, K, surface, agreeing);
        if (cost < best)
            best = cost, bestPlane = surface.plane;
    };
    for (int i = 0; i < int(all.size()); ++i)
        for (int j = i + 1; j < int(all.size()); ++j)
            keepIfBetter({i, j});
    surface.plane = bestPlane;
    agreement(light, K, surface, agreeing);
    if (agreeing.size() >= 3)
        keepIfBetter(std::vector<int>(agreeing));
    surface.plane = bestPlane;
    return best;
}

namespace {

class LightPlaneSearch
{
public:
    LightPlaneSearch(const Matrix3d& K, const std::vector<VanishingDirection>& directions,
                     const AlignedVector<Vector3d>& knownPoints, StripeSurfaces& surfaces)
        : K_(K), directions_(directions), knownPoints_(knownPoints), surfaces_(surfaces), meanRay_(Vector3d::Zero()),
          bestCost_(std::numeric_limits<double>::infinity())
    {
        for (const StripeSurface& surface : surfaces_)
            for (const StripeView& view : surface.views)
                meanRay_ += view.rays[0] + view.rays[1];
    }

    //! Cheap candidates first; more only while some line still contradicts.
    bool run(LightPlane& light)
    {
        const NormalCandidates candidates = findNormals(directions_, knownPoints_);
        const AlignedVector<Vector3d>& normals = candidates.normals;
        for (size_t i = 0; i < normals.size() && (candidates.isFan || !isClean());
             ++i) // in a fan, wrong normals may look clean
            tryNormal(normals[i], false);
        for (size_t i = 0; i < normals.size() && i < 20 && !isClean(); ++i)
            tryNormal(normals[i], true);
        if (!std::isfinite(bestCost_))
            return false;
        light = best_;
        for (StripeSurface& surface : surfaces_)
            fitSurface(light, K_, surface);
        return true;
    }

    AlignedVector<LightPlane> fan(const LightPlane& light)
    {
        AlignedVector<LightPlane> lights;
        const double depth = light.d / light.n.dot(meanRay_);
        for (const Vector3d& normal : fanOfNormals(light.n, findNormals(directions_, knownPoints_).stripe))
        {
            bestCost_ = std::numeric_limits<double>::infinity();
            tryNormal(normal, false);
            for (double factor : {0.25, 0.35, 0.5, 0.7, 1., 1.4, 2., 2.8, 4.})
                tryOffset(facing(normal), factor * depth * std::abs(normal.dot(meanRay_)));
            if (std::isfinite(bestCost_))
                lights.push_back(best_);
        }
        return lights;
    }

private:
    //! No line contradicts, and they agree to half a pixel.
    bool isClean() const { return bestCost_ < 0.25 * lineCount(); }

    double lineCount() const
    {
        double count = 0;
        for (const StripeSurface& surface : surfaces_)
            count += double(surface.views.size());
        return count;
    }

    Vector3d facing(const Vector3d& n) const { return n.dot(meanRay_) < 0 ? Vector3d(-n) : n; }

    void tryNormal(const Vector3d& axis, bool subsets)
    {
        const Vector3d n = facing(axis);
        for (const Vector3d& X : knownPoints_)
            tryOffset(n, n.dot(X));
        for (size_t s = 0; s < surfaces_.size(); ++s)
        {
            std::vector<int> views;
            for (int v = 0; v < int(surfaces_[s].views.size()); ++v)
                if (directions_[s].errors[v] <= startTolerance)
                    views.push_back(v);
            if (!subsets && views.size() >= 3)
                tryOffset(n, offsetFromMotion(n, directions_[s].r, surfaces_[s], views));
            if (subsets && views.size() > 3)
                for (size_t skip = 0; skip < views.size(); ++skip)
                {
                    std::vector<int> others = views;
                    others.erase(others.begin() + skip);
                    tryOffset(n, offsetFromMotion(n, directions_[s].r, surfaces_[s], others));
                }
        }
    }

    void tryOffset(const Vector3d& n, double d)
    {
        if (!(d > 0) || !std::isfinite(d))
            return;
        const LightPlane light = {n, d};
        double cost = 0;
        for (size_t s = 0; s < surfaces_.size() && cost < bestCost_; ++s)
            cost += fitSurface(light, K_, surfaces_[s]);
        if (cost < bestCost_)
            bestCost_ = cost, best_ = light;
    }

    const Matrix3d& K_;
    const std::vector<VanishingDirection>& directions_;
    const AlignedVector<Vector3d>& knownPoints_;
    StripeSurfaces& surfaces_;
    Vector3d meanRay_;
    double bestCost_;
    LightPlane best_;
};

} // namespace

bool startLightPlane(const Matrix3d& K, const std::vector<VanishingDirection>& directions,
                     const AlignedVector<Vector3d>& knownPoints, StripeSurfaces& surfaces, LightPlane& light)
{
    return LightPlaneSearch(K, directions, knownPoints, surfaces).run(light);
}

AlignedVector<LightPlane> fanOfLightPlanes(const Matrix3d& K, const LightPlane& light,
                                           const AlignedVector<Vector3d>& knownPoints, StripeSurfaces surfaces)
{
    std::vector<VanishingDirection> directions;
    for (const StripeSurface& surface : surfaces)
        directions.push_back(findVanishingDirection(surface, K));
    return LightPlaneSearch(K, directions, knownPoints, surfaces).fan(light);
}

}} // namespace cv::active_handeye
