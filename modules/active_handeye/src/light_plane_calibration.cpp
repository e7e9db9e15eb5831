// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "light_plane_calibration.hpp"
#include "light_plane_start.hpp"

#include <set>

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::Vector3d;

static const size_t fewestViews = 3;

static size_t distinctViews(const StripeSurface& surface)
{
    std::set<int> views;
    for (const StripeView& view : surface.views)
        views.insert(view.view);
    return views.size();
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
        CV_Error(Error::StsNoConv,
                 "surfaceIds: no surface has its stripe in enough views; needed at least 3 views of equal orientation "
                 "with a stripe on the same surface, given " +
                     (counts.empty() ? "no segment with a surface id" : counts));
    given_ = 0;
    for (const StripeSurface& surface : thick)
        given_ += surface.views.size();
    surfaces = thick;
}

std::string LightPlaneCalibration::contradictionList() const
{
    std::vector<Contradiction> sorted = contradictions_;
    std::stable_sort(sorted.begin(), sorted.end(),
                     [](const Contradiction& a, const Contradiction& b) { return a.error > b.error; });
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
            contradictions_.push_back(Contradiction{
                describeContradiction(surface.views[v], surface.id, direction.errors[v]), direction.errors[v]});
    }
    surfaces = kept;
    if (surfaces.empty())
        CV_Error(
            Error::StsNoConv,
            cv::format(
                "surfaceIds: stripes of one surface in one group do not share a vanishing direction (a mislabelled surface?); "
                "needed at least 3 lines per surface that meet within %g px, given lines that miss: ",
                startTolerance) +
                contradictionList());
}

void LightPlaneCalibration::start()
{
    if (startLightPlane(camera.K, directions_, knownPoints, surfaces, light_))
        return;
    const std::string reason = explainWeakness(surfaces, directions_, cam2base, 0);
    if (reason.find("motion of the stripes is too small") == std::string::npos)
        CV_Error(Error::StsNoConv, reason);
    CV_Error(
        Error::StsNoConv,
        "t_gripper2base: the stripes move against the camera's translations, the light plane would lie behind the "
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
    const double limit = std::max(0.3, 6 * errors[errors.size() / 2]); // px
    bool any = false;
    for (StripeSurface& surface : surfaces)
        for (size_t v = surface.views.size(); v-- > 0;)
        {
            const double error = lineError(camera.K, light_, surface.plane, surface.views[v]);
            if (error <= limit + 3 * surface.views[v].line.sigma)
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
    directions_ = std::move(directions);
}

void LightPlaneCalibration::failContradiction() const
{
    CV_Error(
        Error::StsNoConv,
        "surfaceIds: the stripes contradict each other (a mislabelled surface, a reflection?); needed segments of which most agree with one light plane, "
        "given segments that miss it: " +
            contradictionList());
}

void LightPlaneCalibration::refine()
{
    for (double cauchyScale : {0.5, 0.2, 0.2}) // px
    {
        solve(cauchyScale);
        const bool dropped = dropContradictions();
        dropThinSurfaces();
        if (surfaces.empty())
            failContradiction();
        if (!dropped)
            break;
    }
    solution_ = solve(std::numeric_limits<double>::infinity());
    updateCovariance(solution_);
}

double LightPlaneCalibration::normalDeviation() const
{
    return observable_ ? std::sqrt(covariance_.topLeftCorner<2, 2>().trace()) : CV_PI;
}

//! The solution, and descents from light planes all around the stripe direction. They need not end: the valley may be long, narrow and bent.
AlignedVector<LightPlaneExplanation> LightPlaneCalibration::explanations() const
{
    const int iterations = 30;
    AlignedVector<LightPlaneExplanation> found(1, LightPlaneExplanation{light_, surfaces, solution_.cost});
    for (const LightPlane& start : fanOfLightPlanes(camera.K, light_, knownPoints, surfaces))
    {
        StripeSurfaces fitted = surfaces;
        for (StripeSurface& surface : fitted)
            fitSurface(start, camera.K, surface);
        LightPlaneProblem problem(camera.K, knownPoints, std::numeric_limits<double>::infinity(), start, fitted);
        const double cost = solveLeastSquares(problem, iterations).cost;
        found.push_back(LightPlaneExplanation{problem.light(), problem.surfaces(), cost});
    }
    return found;
}

void LightPlaneCalibration::requireOneExplanation()
{
    const double weak = 0.2 * CV_PI / 180; // rad
    if (normalDeviation() < weak)
        return;
    const AlignedVector<LightPlaneExplanation> all = explanations();
    const auto best =
        std::min_element(all.begin(), all.end(), [](const LightPlaneExplanation& a, const LightPlaneExplanation& b)
                         { return a.cost < b.cost; });
    if (best->cost < solution_.cost)
    {
        light_ = best->light;
        surfaces = best->surfaces;
        solution_ = solve(std::numeric_limits<double>::infinity());
        updateCovariance(solution_);
    }
    const double plausible = 9, different = 5; // of chi^2; standard deviations
    for (const LightPlaneExplanation& other : all)
    {
        const double angle = std::atan2(light_.n.cross(other.light.n).norm(), light_.n.dot(other.light.n));
        if (other.cost < solution_.cost + plausible * misfit_ && angle > different * normalDeviation())
            CV_Error(Error::StsNoConv,
                     cv::format("stripePoints: a light plane %.1f deg from the best one explains the stripes as well; "
                                "needed stripes in more views, on more surfaces or at more orientations, given "
                                "%d stripes on %d surfaces",
                                angle * 180 / CV_PI, int(given_), int(surfaces.size())));
    }
}

//! Share of the lines' variances that is not the scatter of their pixels but the floor, which good luck must not lower.
static double meanFloorShare(const StripeSurfaces& surfaces)
{
    double sum = 0, lines = 0;
    for (const StripeSurface& surface : surfaces)
        for (const StripeView& view : surface.views)
        {
            const double n = view.line.points, scatter = n > 2 ? 2 * view.line.squares / (n - 2) / n : 0;
            sum += 1 - scatter / (view.line.sigma * view.line.sigma);
            lines += 1;
        }
    return sum / lines;
}

//! Information on n and d when the surfaces are unknown (Schur complement), and its inverse.
void LightPlaneCalibration::updateCovariance(const LeastSquaresSummary& summary)
{
    Matrix3d information = summary.JtJ.topLeftCorner<3, 3>();
    for (size_t s = 0; s < surfaces.size(); ++s)
    {
        const Matrix3d cross = summary.JtJ.block<3, 3>(0, 3 + 3 * s),
                       own = summary.JtJ.block<3, 3>(3 + 3 * s, 3 + 3 * s);
        information -= cross * own.completeOrthogonalDecomposition().pseudoInverse() * cross.transpose();
    }
    const Vector3d scale(1, 1, light_.d);
    const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(Matrix3d(scale.asDiagonal() * information *
                                                                 scale.asDiagonal()));
    observable_ = eigen.eigenvalues()(0) > 1e-12 * eigen.eigenvalues()(2) && eigen.eigenvalues()(0) > 0;
    if (!observable_)
        return;
    const LightPlaneProblem problem(camera.K, knownPoints, 0, light_, surfaces);
    const int freedom = problem.residuals() - problem.unknowns();
    const int tellingFreedom = 10; // fewer could agree by chance
    const double found = freedom > 0 ? summary.cost / freedom : 1;
    misfit_ = std::max(freedom >= tellingFreedom ? meanFloorShare(surfaces) : 1, found);
    covariance_ = misfit_ * scale.asDiagonal() *
                  Matrix3d(eigen.eigenvectors() * eigen.eigenvalues().cwiseInverse().asDiagonal() *
                           eigen.eigenvectors().transpose()) *
                  scale.asDiagonal();
}

}} // namespace cv::active_handeye
