// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "light_plane_diagnosis.hpp"
#include "light_plane_start.hpp"
#include "motion_groups.hpp"

#include "opencv2/core/utils/logger.hpp"

#include <map>
#include <set>

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

//! A light plane less certain than this is no answer.
const double largestNormalDeviation = 2 * CV_PI / 180;
const double largestOffsetDeviation = 0.1; // of d
const size_t fewestViews = 3;

size_t distinctViews(const StripeSurface& surface)
{
    std::set<int> views;
    for (const StripeView& view : surface.views)
        views.insert(view.view);
    return views.size();
}

struct Contradiction
{
    std::string text;
    double error; //!< px
};

//! The calibration as a list of steps over its state; lengths in units of `unit` so that all numbers are about one.
class LightPlaneCalibration
{
public:
    Camera camera;
    AlignedVector<Vector3d> knownPoints;
    GroupOrientations cam2base;
    double unit = 1;
    StripeSurfaces surfaces;

    void readSurfaces(const AlignedVector<Pose>& gripper2base, const std::vector<MotionGroup>& groups, const Matrix3d& cam2gripper,
                      const std::vector<Pixels>& stripes, const std::vector<int>& views, const std::vector<int>& ids);
    void requireViews();
    void findDirections();
    void start();
    void refine();
    void requireAnswer() const;

    LightPlane light() const { return LightPlane{light_.n, light_.d * unit}; }
    Eigen::Matrix4d covariance() const;
    double rms() const;
    void warn() const;

private:
    LeastSquaresSummary solve(double cauchyScale);
    bool dropContradictions();
    void dropThinSurfaces();
    void drop(StripeSurface& surface, size_t view, double error);
    std::string contradictionList() const;
    CV_NORETURN void failContradiction() const;

    std::vector<VanishingDirection> directions_;
    LightPlane light_;
    Matrix3d covariance_; //!< tangent of n (2), d in units
    bool observable_ = false;
    std::vector<Contradiction> contradictions_;
    size_t given_ = 0;
};

void LightPlaneCalibration::readSurfaces(const AlignedVector<Pose>& gripper2base, const std::vector<MotionGroup>& groups,
                                         const Matrix3d& cam2gripper, const std::vector<Pixels>& stripes, const std::vector<int>& views,
                                         const std::vector<int>& ids)
{
    std::vector<int> groupOfView(gripper2base.size());
    for (size_t g = 0; g < groups.size(); ++g)
    {
        cam2base.push_back(groups[g].R * cam2gripper);
        for (int view : groups[g].views)
            groupOfView[view] = int(g);
    }
    std::map<std::pair<int, int>, StripeSurface> found;
    double sum = 0;
    for (size_t i = 0; i < stripes.size(); ++i)
    {
        StripeView view;
        view.segment = int(i);
        view.view = views[i];
        view.line = readStripeLine(stripes[i], camera, int(i));
        if (ids[i] < 0)
            continue;
        const Matrix3d toRay = camera.K.inverse();
        for (int end = 0; end < 2; ++end)
            view.rays[end] = toRay * view.line.end(end).homogeneous();
        const MotionGroup& group = groups[groupOfView[view.view]];
        view.displacement = cam2gripper.transpose() * group.displacement(gripper2base[group.views[0]], gripper2base[view.view]);
        sum += view.displacement.norm();
        ++given_;
        StripeSurface& surface = found[std::make_pair(groupOfView[view.view], ids[i])];
        surface.group = groupOfView[view.view];
        surface.id = ids[i];
        surface.views.push_back(view);
    }
    unit = sum > 0 ? sum / double(given_) : 1;
    for (auto& item : found)
    {
        for (StripeView& view : item.second.views)
            view.displacement /= unit;
        surfaces.push_back(item.second);
    }
    for (Vector3d& X : knownPoints)
        X /= unit;
}

void LightPlaneCalibration::requireViews()
{
    std::string counts;
    StripeSurfaces thick;
    for (const StripeSurface& surface : surfaces)
    {
        if (distinctViews(surface) >= fewestViews)
            thick.push_back(surface);
        counts += cv::format("%ssurface %d in the group of view %d: %d", counts.empty() ? "" : ", ", surface.id,
                             surface.views[0].view, int(distinctViews(surface)));
    }
    if (thick.empty())
        CV_Error(Error::StsNoConv, "surfaceIds: no surface has its stripe in enough views; needed at least 3 views of equal orientation "
                                   "with a stripe on the same surface, given " + (counts.empty() ? "no segment with a surface id" : counts));
    given_ = 0;
    for (const StripeSurface& surface : thick)
        given_ += surface.views.size();
    surfaces = thick;
}

std::string LightPlaneCalibration::contradictionList() const
{
    std::vector<Contradiction> sorted = contradictions_;
    std::stable_sort(sorted.begin(), sorted.end(), [](const Contradiction& a, const Contradiction& b) { return a.error > b.error; });
    std::string list;
    const size_t longest = 8;
    for (size_t i = 0; i < std::min(longest, sorted.size()); ++i)
        list += (i ? ", " : "") + sorted[i].text;
    return list + (sorted.size() > longest ? cv::format(" and %d more", int(sorted.size() - longest)) : "");
}

void LightPlaneCalibration::drop(StripeSurface& surface, size_t view, double error)
{
    contradictions_.push_back(Contradiction{describeContradiction(surface.views[view], surface.id, error), error});
    surface.views.erase(surface.views.begin() + view);
}

//! A surface whose lines meet nowhere is mislabelled: nothing of it can be trusted.
void LightPlaneCalibration::findDirections()
{
    StripeSurfaces kept;
    for (StripeSurface& surface : surfaces)
    {
        const VanishingDirection direction = findVanishingDirection(surface, camera.K);
        if (direction.agreeing >= int(fewestViews))
        {
            kept.push_back(surface);
            directions_.push_back(direction);
            continue;
        }
        for (size_t v = 0; v < surface.views.size(); ++v)
            contradictions_.push_back(Contradiction{describeContradiction(surface.views[v], surface.id, direction.errors[v]), direction.errors[v]});
    }
    surfaces = kept;
    if (surfaces.empty())
        CV_Error(Error::StsNoConv, "surfaceIds: stripes of one surface in one group do not share a vanishing direction (a mislabelled surface?); "
                                   "needed at least 3 lines per surface that meet within 3 px, given lines that miss: " + contradictionList());
}

void LightPlaneCalibration::start()
{
    if (startLightPlane(camera.K, directions_, knownPoints, surfaces, light_))
        return;
    const std::string reason = explainWeakness(surfaces, directions_, cam2base, 0);
    if (reason.find("motion of the stripes is too small") == std::string::npos)
        CV_Error(Error::StsNoConv, reason);
    CV_Error(Error::StsNoConv, "t_gripper2base: the stripes move against the camera's translations, the light plane would lie behind the "
                               "camera; needed poses of the gripper in the base frame (are they inverted?) and R_cam2gripper of this camera");
}

LeastSquaresSummary LightPlaneCalibration::solve(double cauchyScale)
{
    LightPlaneProblem problem(camera.K, knownPoints, cauchyScale, light_, surfaces);
    const LeastSquaresSummary summary = solveLeastSquares(problem, 100);
    light_ = problem.light();
    surfaces = problem.surfaces();
    return summary;
}

//! Drops the segments that the robust solution does not explain; true when there were any.
bool LightPlaneCalibration::dropContradictions()
{
    std::vector<double> errors;
    for (const StripeSurface& surface : surfaces)
        for (const StripeView& view : surface.views)
            errors.push_back(lineError(camera.K, light_, surface.plane, view));
    std::nth_element(errors.begin(), errors.begin() + errors.size() / 2, errors.end());
    const double limit = std::max(1., 5 * errors[errors.size() / 2]); // px
    bool any = false;
    for (StripeSurface& surface : surfaces)
        for (size_t v = surface.views.size(); v-- > 0;)
        {
            const double error = lineError(camera.K, light_, surface.plane, surface.views[v]);
            if (error <= limit)
                continue;
            drop(surface, v, error);
            any = true;
        }
    return any;
}

void LightPlaneCalibration::dropThinSurfaces()
{
    StripeSurfaces kept;
    std::vector<VanishingDirection> directions;
    for (size_t s = 0; s < surfaces.size(); ++s)
        if (distinctViews(surfaces[s]) >= fewestViews)
        {
            kept.push_back(surfaces[s]);
            directions.push_back(directions_[s]);
        }
    surfaces = kept;
    directions_ = directions;
}

void LightPlaneCalibration::failContradiction() const
{
    CV_Error(Error::StsNoConv, "surfaceIds: the stripes contradict each other (a mislabelled surface, a reflection?); needed segments of which most agree with one light plane, "
                               "given segments that miss it: " + contradictionList());
}

void LightPlaneCalibration::refine()
{
    const double cauchyScale = 0.5; // px
    for (int round = 0; round < 3; ++round)
    {
        solve(cauchyScale);
        const bool dropped = dropContradictions();
        dropThinSurfaces();
        if (surfaces.empty())
            failContradiction();
        if (!dropped)
            break;
    }
    const LeastSquaresSummary summary = solve(std::numeric_limits<double>::infinity());

    // information on n and d when the surfaces are unknown (Schur complement)
    Matrix3d information = summary.JtJ.topLeftCorner<3, 3>();
    for (size_t s = 0; s < surfaces.size(); ++s)
    {
        const Matrix3d cross = summary.JtJ.block<3, 3>(0, 3 + 3 * s), own = summary.JtJ.block<3, 3>(3 + 3 * s, 3 + 3 * s);
        information -= cross * own.completeOrthogonalDecomposition().pseudoInverse() * cross.transpose();
    }
    const Vector3d scale(1, 1, light_.d);
    const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(Matrix3d(scale.asDiagonal() * information * scale.asDiagonal()));
    observable_ = eigen.eigenvalues()(0) > 1e-12 * eigen.eigenvalues()(2) && eigen.eigenvalues()(0) > 0;
    if (!observable_)
        return;
    LightPlaneProblem problem(camera.K, knownPoints, 0, light_, surfaces);
    const int freedom = problem.residuals() - problem.unknowns();
    const double misfit = freedom > 0 ? std::max(1., summary.cost / freedom) : 1;
    covariance_ = misfit * scale.asDiagonal() * Matrix3d(eigen.eigenvectors() * eigen.eigenvalues().cwiseInverse().asDiagonal() *
                                                         eigen.eigenvectors().transpose()) * scale.asDiagonal();
}

void LightPlaneCalibration::requireAnswer() const
{
    size_t used = 0;
    for (const StripeSurface& surface : surfaces)
        used += surface.views.size();
    const double normalDeviation = observable_ ? std::sqrt(covariance_.topLeftCorner<2, 2>().trace()) : CV_PI;
    const double offsetDeviation = observable_ ? std::sqrt(covariance_(2, 2)) / light_.d : 1e9;
    const bool weak = normalDeviation > largestNormalDeviation || offsetDeviation > largestOffsetDeviation;
    if (used * 10 < given_ * 6 || (weak && !contradictions_.empty()))
        failContradiction();
    if (!weak)
        return;
    std::string certainty = observable_ ? cv::format(" (standard deviations would be %.2g deg and %.2g %% of d)", normalDeviation * 180 / CV_PI,
                                                     100 * offsetDeviation)
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
            squares += view.line.squares + view.line.points * std::pow(lineError(camera.K, light_, surface.plane, view), 2);
            points += view.line.points;
        }
    return std::sqrt(squares / points);
}

void LightPlaneCalibration::warn() const
{
    if (!contradictions_.empty())
        CV_LOG_WARNING(NULL, "calibrateLightPlane left out segments that contradict the others: " << contradictionList());
}

} // namespace

double calibrateLightPlane(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base, InputArrayOfArrays stripePoints,
                           InputArray stripeViews, InputArray surfaceIds, InputArray cameraMatrix, InputArray distCoeffs,
                           InputArray R_cam2gripper, OutputArray lightPlane, OutputArray covariance, InputArray knownPoints,
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
    const std::vector<MotionGroup> groups = groupByOrientation(poses, tolerance);
    requireTranslation(groups, poses, tolerance);
    calibration.readSurfaces(poses, groups, readRotation(R_cam2gripper, "R_cam2gripper"), stripes, views, ids);
    calibration.requireViews();
    calibration.findDirections();
    calibration.start();
    calibration.refine();
    calibration.requireAnswer();
    calibration.warn();
    const LightPlane light = calibration.light();
    writeMatrix((Eigen::Vector4d() << light.n, light.d).finished(), lightPlane);
    if (covariance.needed())
        writeMatrix(calibration.covariance(), covariance);
    return calibration.rms();
}

}} // namespace cv::active_handeye
