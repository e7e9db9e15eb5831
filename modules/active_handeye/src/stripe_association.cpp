// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "motion_groups.hpp"
#include "stripe_depths.hpp"

#include <set>

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector4d;

namespace {

//! A segment with its ends on the light plane, in the base frame.
struct SceneLine
{
    StripeView view; //!< displacement 0: surfaces are given in the camera frame of its view
    int group;
    Vector3d ends[2];
    bool inFront;
};

typedef AlignedVector<SceneLine> SceneLines;

struct ScenePlane
{
    Vector4d plane; //!< (w, e0), w.X = e0 in the base frame, |w| = 1
    std::vector<int> lines;
    double
        planarity; //!< RMS extent of the lines' ends across their longest direction, relative to that; 0 = they are all on one line
};

class SurfaceFinder
{
public:
    SurfaceFinder(const SceneLines& lines, const LightPlane& light, const Matrix3d& K,
                  const AlignedVector<Pose>& cam2base, double tolerance)
        : lines_(lines), light_(light), K_(K), cam2base_(cam2base), tolerance_(tolerance)
    {}

    std::vector<int> run(int groups)
    {
        AlignedVector<ScenePlane> surfaces;
        for (int group = 0; group < groups; ++group)
            findInGroup(group, surfaces);
        mergeAcrossGroups(surfaces);
        std::stable_sort(surfaces.begin(), surfaces.end(),
                         [](const ScenePlane& a, const ScenePlane& b) { return a.lines.size() > b.lines.size(); });
        std::vector<int> ids(lines_.size(), -1);
        for (size_t s = 0; s < surfaces.size(); ++s)
            for (int line : surfaces[s].lines)
                ids[line] = int(s);
        return ids;
    }

private:
    double error(const Vector4d& plane, int line) const
    {
        const Pose& pose = cam2base_[lines_[line].view.view];
        Vector4d inCamera;
        inCamera << pose.R.transpose() * plane.head<3>(), plane(3) - plane.head<3>().dot(pose.t);
        const double error = lineError(K_, light_, inCamera, lines_[line].view);
        return std::isfinite(error) ? error : std::numeric_limits<double>::infinity();
    }

    ScenePlane fit(const std::vector<int>& lines) const
    {
        ScenePlane result;
        result.lines = lines;
        Vector3d mean = Vector3d::Zero();
        for (int i : lines)
            mean += (lines_[i].ends[0] + lines_[i].ends[1]) / (2. * double(lines.size()));
        Matrix3d scatter = Matrix3d::Zero();
        for (int i : lines)
            for (const Vector3d& X : lines_[i].ends)
                scatter += (X - mean) * (X - mean).transpose();
        const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(scatter);
        const Vector3d w = eigen.eigenvectors().col(0);
        result.plane << w, w.dot(mean);
        result.planarity = std::sqrt(std::max(0., eigen.eigenvalues()(1)) / eigen.eigenvalues()(2));
        return result;
    }

    std::vector<int> linesOn(const Vector4d& plane, const std::vector<int>& candidates) const
    {
        std::vector<int> on;
        for (int line : candidates)
            if (error(plane, line) <= tolerance_)
                on.push_back(line);
        return on;
    }

    size_t views(const std::vector<int>& lines) const
    {
        std::set<int> views;
        for (int line : lines)
            views.insert(lines_[line].view.view);
        return views.size();
    }

    //! Largest set of coplanar lines among the candidates, seeded by pairs of different views.
    ScenePlane largest(const std::vector<int>& candidates) const
    {
        ScenePlane best;
        const size_t pairs = candidates.size() * (candidates.size() - 1) / 2, mostPairs = 20000,
                     stride = 1 + pairs / mostPairs;
        size_t pair = 0;
        const double leastPlanarity = 0.01;
        for (size_t i = 0; i < candidates.size(); ++i)
            for (size_t j = i + 1; j < candidates.size(); ++j)
            {
                if (pair++ % stride || lines_[candidates[i]].view.view == lines_[candidates[j]].view.view)
                    continue;
                ScenePlane seed = fit({candidates[i], candidates[j]});
                if (seed.planarity < leastPlanarity || error(seed.plane, candidates[i]) > tolerance_ ||
                    error(seed.plane, candidates[j]) > tolerance_)
                    continue;
                seed.lines = linesOn(seed.plane, candidates);
                if (views(seed.lines) > views(best.lines) ||
                    (views(seed.lines) == views(best.lines) && seed.lines.size() > best.lines.size()))
                    best = seed;
            }
        for (int pass = 0; pass < 3 && !best.lines.empty(); ++pass)
        {
            best = fit(best.lines);
            best.lines = linesOn(best.plane, candidates);
        }
        return best;
    }

    void findInGroup(int group, AlignedVector<ScenePlane>& surfaces) const
    {
        const size_t fewestViews = 3;
        std::vector<int> open;
        for (int i = 0; i < int(lines_.size()); ++i)
            if (lines_[i].group == group && lines_[i].inFront)
                open.push_back(i);
        AlignedVector<ScenePlane> found;
        while (views(open) >= fewestViews)
        {
            const ScenePlane surface = largest(open);
            if (views(surface.lines) < fewestViews)
                break;
            found.push_back(surface);
            open.erase(std::remove_if(open.begin(), open.end(),
                                      [&](int line)
                                      {
                                          return std::find(surface.lines.begin(), surface.lines.end(), line) !=
                                                 surface.lines.end();
                                      }),
                       open.end());
        }
        dropAmbiguousLines(found);
        surfaces.insert(surfaces.end(), found.begin(), found.end());
    }

    //! A line that fits a second surface of its group about as well could be on either; one that fits another better belongs there.
    void dropAmbiguousLines(AlignedVector<ScenePlane>& surfaces) const
    {
        const double clearly = 0.5; // px
        for (ScenePlane& surface : surfaces)
        {
            const auto fitsAnother = [&](int line)
            {
                for (const ScenePlane& other : surfaces)
                    if (&other != &surface &&
                        error(other.plane, line) <= std::min(tolerance_, error(surface.plane, line) + clearly))
                        return true;
                return false;
            };
            surface.lines.erase(std::remove_if(surface.lines.begin(), surface.lines.end(), fitsAnother),
                                surface.lines.end());
        }
        surfaces.erase(std::remove_if(surfaces.begin(), surfaces.end(),
                                      [&](const ScenePlane& s) { return views(s.lines) < 3; }),
                       surfaces.end());
    }

    bool fits(const ScenePlane& surface, const ScenePlane& other) const
    {
        const double looser = 2; // errors of the calibration shift one group against another
        for (int line : other.lines)
            if (error(surface.plane, line) > looser * tolerance_)
                return false;
        return true;
    }

    void mergeAcrossGroups(AlignedVector<ScenePlane>& surfaces) const
    {
        for (size_t i = 0; i < surfaces.size(); ++i)
            for (size_t j = i + 1; j < surfaces.size();)
            {
                const bool sameGroup = lines_[surfaces[i].lines[0]].group == lines_[surfaces[j].lines[0]].group;
                if (sameGroup || !fits(surfaces[i], surfaces[j]) || !fits(surfaces[j], surfaces[i]))
                {
                    ++j;
                    continue;
                }
                surfaces[i].lines.insert(surfaces[i].lines.end(), surfaces[j].lines.begin(), surfaces[j].lines.end());
                surfaces.erase(surfaces.begin() + j);
            }
    }

    const SceneLines& lines_;
    const LightPlane& light_;
    const Matrix3d& K_;
    const AlignedVector<Pose>& cam2base_;
    const double tolerance_;
};

SceneLine toScene(const StripeLine& line, int segment, int view, int group, const LightPlane& light, const Matrix3d& K,
                  const Pose& cam2base)
{
    SceneLine scene;
    scene.view.segment = segment;
    scene.view.view = view;
    scene.view.line = line;
    scene.view.displacement.setZero();
    scene.group = group;
    scene.inFront = true;
    for (int end = 0; end < 2; ++end)
    {
        const Vector3d ray = K.inverse() * line.end(end).homogeneous();
        const double depth = light.d / light.n.dot(ray);
        scene.view.rays[end] = ray;
        scene.ends[end] = cam2base.R * (depth * ray) + cam2base.t;
        scene.inFront = scene.inFront && depth > 0 && scene.ends[end].allFinite();
    }
    return scene;
}

} // namespace

void associateStripes(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base,
                      InputArrayOfArrays stripePoints, InputArray stripeViews, InputArrayOfArrays imagePoints,
                      InputArray cameraMatrix, InputArray distCoeffs, InputArray R_cam2gripper,
                      InputArray t_cam2gripper, OutputArray surfaceIds, OutputArray lightPlane, double tolerance,
                      double searchRadius)
{
    CV_TRACE_FUNCTION();
    const AlignedVector<Pose> gripper2base = readRobotPoses(R_gripper2base, t_gripper2base);
    const std::vector<Pixels> segments = readPixelLists(stripePoints, "stripePoints");
    const std::vector<int> views = readStripeViews(stripeViews, segments.size(), gripper2base.size());
    const std::vector<Pixels> tracks = readImagePoints(imagePoints, gripper2base.size());
    const Camera camera = readCamera(cameraMatrix, distCoeffs);
    const Pose cam2gripper = {readRotation(R_cam2gripper, "R_cam2gripper"),
                              readVector3(t_cam2gripper, "t_cam2gripper")};
    readPositive(tolerance, "tolerance");
    readPositive(searchRadius, "searchRadius");

    AlignedVector<Pose> cam2base;
    for (const Pose& pose : gripper2base)
        cam2base.push_back(Pose{pose.R * cam2gripper.R, pose.R * cam2gripper.t + pose.t});
    const AlignedVector<Vector3d> scenePoints = triangulate(tracks, camera, cam2base);
    const double focal = std::sqrt(camera.K(0, 0) * camera.K(1, 1));
    const LightPlane light =
        lightPlaneFromDepths(depthsNearStripes(segments, views, tracks, scenePoints, camera, cam2base, searchRadius),
                             focal);

    const double orientationTolerance = 0.05; // deg, the default of groupViews
    const std::vector<MotionGroup> groups = groupByOrientation(gripper2base, orientationTolerance);
    std::vector<int> groupOfView(gripper2base.size());
    for (size_t g = 0; g < groups.size(); ++g)
        for (int view : groups[g].views)
            groupOfView[view] = int(g);
    SceneLines lines;
    for (size_t s = 0; s < segments.size(); ++s)
        lines.push_back(toScene(readStripeLine(segments[s], camera, int(s)), int(s), views[s], groupOfView[views[s]],
                                light, camera.K, cam2base[views[s]]));
    const std::vector<int> ids = SurfaceFinder(lines, light, camera.K, cam2base, tolerance).run(int(groups.size()));
    Mat(int(ids.size()), 1, CV_32S, const_cast<int*>(ids.data())).copyTo(surfaceIds);
    writeMatrix((Vector4d() << light.n, light.d).finished(), lightPlane);
}

}} // namespace cv::active_handeye
