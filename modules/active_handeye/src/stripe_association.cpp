// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "motion_groups.hpp"
#include "stripe_depths.hpp"
#include "surface_finder.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector4d;

namespace {

SceneLine toScene(const StripeLine& line, int segment, int view, const LightPlane& light, const Matrix3d& K,
                  const Pose& cam2base)
{
    SceneLine scene;
    scene.view.segment = segment;
    scene.view.view = view;
    scene.view.line = line;
    scene.view.displacement.setZero();
    scene.group = -1;
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

std::vector<int> groupOfEveryView(const std::vector<MotionGroup>& groups, size_t views)
{
    std::vector<int> groupOfView(views);
    for (size_t g = 0; g < groups.size(); ++g)
        for (int view : groups[g].views)
            groupOfView[view] = int(g);
    return groupOfView;
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
    const ScenePoints scenePoints = triangulate(tracks, camera, cam2base);
    const double focal = std::sqrt(camera.K(0, 0) * camera.K(1, 1));
    const LightPlane light =
        lightPlaneFromDepths(depthsNearStripes(segments, views, tracks, scenePoints, camera, cam2base, searchRadius),
                             focal);

    const double orientationTolerance = 0.05; // deg, the default of groupViews
    const std::vector<MotionGroup> groups = groupByOrientation(gripper2base, orientationTolerance);
    const std::vector<int> groupOfView = groupOfEveryView(groups, gripper2base.size());
    SceneLines lines;
    for (size_t s = 0; s < segments.size(); ++s)
    {
        const int view = views[s];
        const StripeLine line = readStripeLine(segments[s], camera, int(s));
        lines.push_back(toScene(line, int(s), view, light, camera.K, cam2base[view]));
        lines.back().group = groupOfView[view];
        lines.back().beside = pointsBeside(line, tracks[view], scenePoints, camera);
    }
    const std::vector<int> ids =
        SurfaceFinder(CoplanarLines(lines, light, camera.K, cam2base, tolerance)).run(int(groups.size()));
    Mat(int(ids.size()), 1, CV_32S, const_cast<int*>(ids.data())).copyTo(surfaceIds);
    writeMatrix((Vector4d() << light.n, light.d).finished(), lightPlane);
}

}} // namespace cv::active_handeye
