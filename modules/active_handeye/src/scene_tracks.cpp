// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "scene_tracks.hpp"
#include "residuals.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

static Vector3d undetermined()
{
    return Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
}

SceneTracks::SceneTracks(const std::vector<Pixels>& imagePoints, const std::vector<std::vector<double>>& pointSigmas,
                         const AlignedVector<Vector3d>& objectPoints)
{
    for (size_t j = 0; j < imagePoints[0].size(); ++j)
    {
        const size_t start = observations.size();
        for (size_t view = 0; view < imagePoints.size(); ++view)
            if (!std::isnan(imagePoints[view][j].x()))
            {
                const double sigma = pointSigmas.empty() ? 1 : pointSigmas[view][j];
                observations.push_back(PointObservation{int(view), imagePoints[view][j], 1 / sigma, true});
            }
        const bool isKnownPoint = !objectPoints.empty() && objectPoints[j].allFinite();
        if (observations.size() - start < (isKnownPoint ? 1u : 2u))
        {
            observations.resize(start);
            continue;
        }
        column.push_back(int(j));
        first.push_back(int(observations.size()));
        if (!objectPoints.empty())
            known.push_back(objectPoints[j]);
    }
}

int SceneTracks::usedIn(int track) const
{
    int count = 0;
    for (int i = first[track]; i < first[track + 1]; ++i)
        count += observations[i].used;
    return count;
}

bool SceneTracks::anyKnown() const
{
    return std::any_of(known.begin(), known.end(), [](const Vector3d& X) { return X.allFinite(); });
}

namespace {

struct Ray
{
    Vector3d origin, direction;
    int observation;
};

typedef std::vector<Ray, Eigen::aligned_allocator<Ray>> Rays;

//! Point with the least sum of squared distances to the rays [from, to).
Vector3d nearestPoint(const Rays& rays)
{
    Matrix3d A = Matrix3d::Zero();
    Vector3d b = Vector3d::Zero();
    const Vector3d origin = rays[0].origin;
    for (const Ray& ray : rays)
    {
        const Matrix3d across = Matrix3d::Identity() - ray.direction * ray.direction.transpose();
        A += across;
        b += across * (ray.origin - origin);
    }
    const double parallax = A.ldlt().vectorD().minCoeff() / double(rays.size());
    return parallax > 1e-12 ? Vector3d(origin + A.ldlt().solve(b)) : undetermined();
}

double pixelError(const SceneTracks& tracks, const CalibrationState& state, const CameraViews& views, const Vector3d& X,
                  int observation)
{
    Vector2d error;
    const PointObservation& o = tracks.observations[observation];
    if (!X.allFinite() || !PointResidual::evaluate(state.calibration.camera, views[o.view], X, o.pixel, error))
        return std::numeric_limits<double>::infinity();
    return error.norm();
}

//! Of the points of all pairs of rays, the one that most rays agree with.
Vector3d agreedPoint(const Rays& rays, const SceneTracks& tracks, const CalibrationState& state,
                     const CameraViews& views, double tolerance)
{
    Vector3d best = undetermined();
    double bestCost = std::numeric_limits<double>::infinity();
    const size_t most = 12, stride = std::max<size_t>(1, rays.size() / most);
    for (size_t a = 0; a < rays.size(); a += stride)
        for (size_t b = a + 1; b < rays.size(); b += stride)
        {
            const Vector3d X = nearestPoint(Rays{rays[a], rays[b]});
            double cost = 0;
            for (const Ray& ray : rays)
                cost += std::min(pixelError(tracks, state, views, X, ray.observation), tolerance);
            if (cost < bestCost)
                bestCost = cost, best = X;
        }
    Rays agreeing;
    for (const Ray& ray : rays)
        if (pixelError(tracks, state, views, best, ray.observation) < tolerance)
            agreeing.push_back(ray);
    return agreeing.size() >= 2 ? nearestPoint(agreeing) : best;
}

} // namespace

void triangulate(const SceneTracks& tracks, double tolerance, CalibrationState& state)
{
    const CameraViews views = state.views();
    state.points.assign(tracks.count(), undetermined());
    for (int track = 0; track < tracks.count(); ++track)
    {
        Rays rays;
        for (int i = tracks.first[track]; i < tracks.first[track + 1]; ++i)
        {
            const PointObservation& o = tracks.observations[i];
            if (o.used)
                rays.push_back(Ray{views[o.view].centre,
                                   (views[o.view].R_cam2base * state.calibration.camera.ray(o.pixel)).normalized(), i});
        }
        if (rays.size() < 2)
            continue;
        state.points[track] = nearestPoint(rays);
        double worst = 0;
        for (const Ray& ray : rays)
            worst = std::max(worst, pixelError(tracks, state, views, state.points[track], ray.observation));
        if (worst > tolerance && rays.size() > 2)
            state.points[track] = agreedPoint(rays, tracks, state, views, tolerance);
    }
}

void placeObject(const SceneTracks& tracks, CalibrationState& state)
{
    Vector3d from = Vector3d::Zero(), to = Vector3d::Zero();
    std::vector<int> both;
    for (int track = 0; track < tracks.count(); ++track)
        if (tracks.isKnown(track) && state.points[track].allFinite())
        {
            both.push_back(track);
            from += tracks.known[track];
            to += state.points[track];
        }
    if (both.size() < 3)
        CV_Error(Error::StsNoConv,
                 cv::format("objectPoints: needed 3 or more known points that several views see, given %d",
                            int(both.size())));
    from /= double(both.size());
    to /= double(both.size());
    Matrix3d M = Matrix3d::Zero();
    for (int track : both)
        M += (state.points[track] - to) * (tracks.known[track] - from).transpose();
    state.object2base.R = nearestRotation(M); // Kabsch
    state.object2base.t = to - state.object2base.R * from;
    for (int track = 0; track < tracks.count(); ++track)
        if (tracks.isKnown(track))
            state.points[track] = state.object2base.R * tracks.known[track] + state.object2base.t;
}

std::vector<double> normalizedErrors(const SceneTracks& tracks, const CalibrationState& state)
{
    const CameraViews views = state.views();
    std::vector<double> errors(tracks.observations.size());
    for (int track = 0; track < tracks.count(); ++track)
        for (int i = tracks.first[track]; i < tracks.first[track + 1]; ++i)
            errors[i] = pixelError(tracks, state, views, state.points[track], i) * tracks.observations[i].inverseSigma;
    return errors;
}

}} // namespace cv::active_handeye
