// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "light_plane_calibration.hpp"

#include "opencv2/core/utils/logger.hpp"

#include <map>

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::Vector3d;

void LightPlaneCalibration::readSurfaces(const AlignedVector<Pose>& gripper2base,
                                         const std::vector<MotionGroup>& groups, const Matrix3d& cam2gripper,
                                         const std::vector<Pixels>& stripes, const std::vector<int>& views,
                                         const std::vector<int>& ids)
{
    std::vector<int> groupOfView(gripper2base.size());
    for (size_t g = 0; g < groups.size(); ++g)
    {
        cam2base.push_back(groups[g].R * cam2gripper);
        for (int view : groups[g].views)
            groupOfView[view] = int(g);
    }
    std::map<std::pair<int, int>, size_t> indexOf; // by group and surface id
    double sum = 0;
    for (size_t i = 0; i < stripes.size(); ++i)
    {
        if (ids[i] < 0)
            continue;
        StripeView view;
        view.segment = int(i);
        view.view = views[i];
        view.line = readStripeLine(stripes[i], camera, int(i));
        const Matrix3d toRay = camera.K.inverse();
        for (int end = 0; end < 2; ++end)
            view.rays[end] = toRay * view.line.end(end).homogeneous();
        const MotionGroup& group = groups[groupOfView[view.view]];
        view.displacement =
            cam2gripper.transpose() * group.displacement(gripper2base[group.views[0]], gripper2base[view.view]);
        sum += view.displacement.norm();
        ++given_;
        const std::pair<int, int> key(groupOfView[view.view], ids[i]);
        if (indexOf.insert(std::make_pair(key, surfaces.size())).second)
        {
            surfaces.push_back(StripeSurface());
            surfaces.back().group = key.first;
            surfaces.back().id = key.second;
        }
        surfaces[indexOf[key]].views.push_back(view);
    }
    unit = sum > 0 ? sum / double(given_) : 1;
    for (StripeSurface& surface : surfaces)
        for (StripeView& view : surface.views)
            view.displacement /= unit;
    for (Vector3d& X : knownPoints)
        X /= unit;
}

void LightPlaneCalibration::requireAnswer() const
{
    const double largestNormalDeviation = 2 * CV_PI / 180, largestOffsetDeviation = 0.1; // of d: beyond it is no answer
    size_t used = 0;
    for (const StripeSurface& surface : surfaces)
        used += surface.views.size();
    const double offsetDeviation = observable_ ? std::sqrt(covariance_(2, 2)) / light_.d : 1e9;
    const bool weak = normalDeviation() > largestNormalDeviation || offsetDeviation > largestOffsetDeviation;
    if (used * 10 < given_ * 6 || (weak && !contradictions_.empty()))
        failContradiction();
    if (!weak)
        return;
    std::string certainty = observable_ ? cv::format(" (standard deviations would be %.2g deg and %.2g %% of d)",
                                                     normalDeviation() * 180 / CV_PI, 100 * offsetDeviation)
                                        : " (nothing determines it)";
    CV_Error(Error::StsNoConv, explainWeakness(surfaces, directions_, cam2base, &light_) + certainty);
}

Eigen::Matrix4d LightPlaneCalibration::covariance() const
{
    Eigen::Matrix<double, 4, 3> J = Eigen::Matrix<double, 4, 3>::Zero();
    J.topLeftCorner<3, 2>() = tangentBasis(light_.n);
    J(3, 2) = unit;
    return J * covariance_ * J.transpose();
}

double LightPlaneCalibration::rms() const
{
    double squares = 0, points = 0;
    for (const StripeSurface& surface : surfaces)
        for (const StripeView& view : surface.views)
        {
            squares +=
                view.line.squares + view.line.points * std::pow(lineError(camera.K, light_, surface.plane, view), 2);
            points += view.line.points;
        }
    return std::sqrt(squares / points);
}

void LightPlaneCalibration::calibrate(const AlignedVector<Pose>& gripper2base, const Matrix3d& cam2gripper,
                                      const std::vector<Pixels>& stripes, const std::vector<int>& views,
                                      const std::vector<int>& ids, double orientationTolerance)
{
    const std::vector<MotionGroup> groups = groupByOrientation(gripper2base, orientationTolerance);
    requireTranslation(groups, gripper2base, orientationTolerance);
    readSurfaces(gripper2base, groups, cam2gripper, stripes, views, ids);
    requireViews();
    findDirections();
    start();
    refine();
    requireOneExplanation();
    requireAnswer();
}

void LightPlaneCalibration::warn() const
{
    if (!contradictions_.empty())
        CV_LOG_WARNING(NULL,
                       "calibrateLightPlane left out segments that contradict the others: " << contradictionList());
}

double calibrateLightPlane(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base,
                           InputArrayOfArrays stripePoints, InputArray stripeViews, InputArray surfaceIds,
                           InputArray cameraMatrix, InputArray distCoeffs, InputArray R_cam2gripper,
                           OutputArray lightPlane, OutputArray covariance, InputArray knownPoints,
                           double orientationTolerance)
{
    CV_TRACE_FUNCTION();
    const AlignedVector<Pose> poses = readRobotPoses(R_gripper2base, t_gripper2base);
    const double tolerance = readPositive(orientationTolerance, "orientationTolerance");
    const std::vector<Pixels> stripes = readPixelLists(stripePoints, "stripePoints");
    const std::vector<int> views = readStripeViews(stripeViews, stripes.size(), poses.size());
    const std::vector<int> ids = readSurfaceIds(surfaceIds, stripes.size());

    LightPlaneCalibration calibration;
    calibration.camera = readCamera(cameraMatrix, distCoeffs);
    calibration.knownPoints = readPoints3D(knownPoints, "knownPoints");
    calibration.calibrate(poses, readRotation(R_cam2gripper, "R_cam2gripper"), stripes, views, ids, tolerance);
    calibration.warn();
    const LightPlane light = calibration.light();
    writeMatrix((Eigen::Vector4d() << light.n, light.d).finished(), lightPlane);
    if (covariance.needed())
        writeMatrix(calibration.covariance(), covariance);
    return calibration.rms();
}

}} // namespace cv::active_handeye
