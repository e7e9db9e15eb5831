// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "refine_problem.hpp"
#include "decompositions.hpp"
#include "residuals.hpp"

namespace cv { namespace active_handeye {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector4d;
using Eigen::VectorXd;

static const double infinity = std::numeric_limits<double>::infinity();

int RefineUnknowns::poseColumn(int view) const
{
    if (poses[view] == POSE_EXACT)
        return -1;
    int column = surfaceColumn(surfaces);
    for (int i = 0; i < view; ++i)
        column += poses[i] == POSE_EXACT ? 0 : 6;
    return column;
}

int RefineUnknowns::count() const
{
    const int movable = int(poses.size() - std::count(poses.begin(), poses.end(), POSE_EXACT));
    return surfaceColumn(surfaces) + 6 * movable;
}

RefineProblem::RefineProblem(SceneTracks& tracks_, StripeSegments& segments_, const AlignedVector<Pose>& reported_,
                             const CalibrationState& start, double huberThreshold)
    : tracks(tracks_), segments(segments_), reported(reported_), state(start), huberThreshold_(huberThreshold)
{}

Vector6d RefineProblem::correction(int view) const
{
    Vector6d result;
    result << logRotation(state.gripper2base[view].R * reported[view].R.transpose()),
        state.gripper2base[view].t - reported[view].t;
    return result;
}

double RefineProblem::huberCost(double r) const
{
    const double k = huberThreshold_ * noise.point;
    return r <= k ? r * r : k * (2 * r - k);
}

double RefineProblem::trackCost(int track, const CameraViews& views, const Camera& camera, const Vector3d& X) const
{
    double sum = 0;
    for (int i = tracks.first[track]; i < tracks.first[track + 1]; ++i)
    {
        const PointObservation& o = tracks.observations[i];
        if (!o.used)
            continue;
        Vector2d error;
        if (!PointResidual::evaluate(camera, views[o.view], X, o.pixel, error))
            return infinity;
        sum += huberCost(error.norm() * o.inverseSigma);
    }
    return sum;
}

//! Cost of a track at X and the step from there.
PointStep RefineProblem::stepOfPoint(int track, const CameraViews& views, const Camera& camera, const Vector3d& X,
                                     LossCurvature curvature) const
{
    Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
    Vector3d b = Vector3d::Zero();
    PointStep result = {X, 0, false};
    for (int i = tracks.first[track]; i < tracks.first[track + 1]; ++i)
    {
        const PointObservation& o = tracks.observations[i];
        if (!o.used)
            continue;
        PointResidual residual;
        if (!residual.linearizePoint(camera, views[o.view], X, o.pixel))
            return PointStep{X, infinity, false};
        const double r = residual.error.norm() * o.inverseSigma, k = huberThreshold_ * noise.point;
        const bool isClipped = r > k;
        const double weight =
            (isClipped && curvature != CURVATURE_SQUARE ? k / r : 1) * o.inverseSigma * o.inverseSigma;
        A.noalias() += weight * residual.byPoint.transpose() * residual.byPoint;
        b.noalias() += weight * residual.byPoint.transpose() * residual.error;
        if (isClipped && curvature == CURVATURE_LOSS)
        {
            const Vector3d slope = residual.byPoint.transpose() * residual.error.normalized();
            A.noalias() -= weight * slope * slope.transpose();
        }
        result.cost += huberCost(r);
        result.isClipped |= isClipped;
    }
    result.next -= solveSymmetric(A, b);
    return result;
}

/** Follows the cameras with a scene point. Returns the cost of its track.

First a plain step, since they may have moved far, and a robust one from there. Where Huber's loss clips, Newton's steps go on until they
settle: a point that lags behind its optimum would make the cost of the cameras fall slowly for many iterations. Where Newton's step is too
long, the weights' step lowers the cost.
*/
double RefineProblem::movePoint(int track, const CameraViews& views, const Camera& camera, Vector3d& X) const
{
    const PointStep start = stepOfPoint(track, views, camera, X, CURVATURE_SQUARE);
    const PointStep plain = stepOfPoint(track, views, camera, start.next, CURVATURE_WEIGHTS);
    double best = start.cost;
    const auto offer = [&](const Vector3d& candidate, double cost)
    {
        const bool isBetter = cost < best;
        if (cost <= best)
        {
            best = cost;
            X = candidate;
        }
        return isBetter;
    };
    const auto offerStep = [&](LossCurvature curvature)
    {
        const Vector3d next = stepOfPoint(track, views, camera, X, curvature).next;
        return offer(next, trackCost(track, views, camera, next));
    };
    offer(start.next, plain.cost);
    offer(plain.next, trackCost(track, views, camera, plain.next));
    const int maxSteps = 20;
    const double settled = 1e-10 * noise.point * noise.point;
    double before = start.isClipped || plain.isClipped ? infinity : best;
    for (int i = 0; i < maxSteps && before - best > settled; ++i)
    {
        before = best;
        if (!offerStep(CURVATURE_LOSS))
            offerStep(CURVATURE_WEIGHTS);
    }
    return best;
}

//! Moves the camera of a view as the linear model says, and the gripper with it. The images see the camera alone: a step of the
//! hand-eye transform and the robot's poses that cancel must leave it exactly where it is, or long steps along this valley fail.
static Pose movedPose(const Pose& pose, const Pose& cam2gripper, const Pose& movedCam2gripper,
                      const Vector6d& handEyeStep, const Vector6d& poseStep)
{
    const Vector3d turn = poseStep.head<3>(), arm = pose.R * cam2gripper.t;
    const Eigen::Matrix3d R_cam2base = expRotation(pose.R * handEyeStep.head<3>() + turn) * pose.R * cam2gripper.R;
    const Vector3d centre = pose.t + arm + turn.cross(arm) + pose.R * handEyeStep.tail<3>() + poseStep.tail<3>();
    const Eigen::Matrix3d R = nearestRotation(R_cam2base * movedCam2gripper.R.transpose());
    return Pose{R, centre - R * movedCam2gripper.t};
}

CalibrationState RefineProblem::moved(const VectorXd& step) const
{
    CalibrationState result = state;
    const CalibrationStep calibrationStep = unknowns.calibration * step.head(unknowns.calibration.cols());
    result.calibration = state.calibration.moved(calibrationStep);
    if (unknowns.object)
        result.object2base = active_handeye::moved(state.object2base, step.segment<6>(unknowns.objectColumn()));
    for (int s = 0; s < unknowns.surfaces; ++s)
    {
        const Vector4d& plane = state.surfaces[s];
        result.surfaces[s] = (plane + surfaceTangent(plane) * step.segment<3>(unknowns.surfaceColumn(s))).normalized();
    }
    for (int view = 0; view < int(reported.size()); ++view)
        if (unknowns.poses[view] != POSE_EXACT)
            result.gripper2base[view] =
                movedPose(state.gripper2base[view], state.calibration.cam2gripper, result.calibration.cam2gripper,
                          calibrationStep.segment<6>(COLUMN_ROTATION), step.segment<6>(unknowns.poseColumn(view)));
    for (int track = 0; track < tracks.count(); ++track)
        if (tracks.isKnown(track))
            result.points[track] = result.object2base.R * tracks.known[track] + result.object2base.t;
    return result;
}

double RefineProblem::pointCost(const CalibrationState& at) const
{
    const CameraViews views = at.views();
    double sum = 0;
    for (int track = 0; track < tracks.count(); ++track)
        if (tracks.isUsed(track))
            sum += trackCost(track, views, at.calibration.camera, at.points[track]);
    return sum / (meanSlope_ * noise.point * noise.point);
}

double RefineProblem::stripeCost(const CalibrationState& at) const
{
    if (segments.empty())
        return 0;
    const CameraViews views = at.views();
    double sum = 0;
    for (const StripeSegment& segment : segments)
        for (int end = 0; segment.used && end < 2; ++end)
        {
            StripeResidual residual;
            if (!residual.linearize(at.calibration, views[segment.view], at.surfaces[segment.surface],
                                    segment.ends[end]))
                return infinity;
            sum += std::pow(residual.error * segment.inverseSigma / noise.stripe, 2);
        }
    return at.calibration.light.d > 0 ? sum : infinity;
}

double RefineProblem::priorCost(const CalibrationState& at) const
{
    double sum = 0;
    for (size_t view = 0; view < reported.size(); ++view)
        if (unknowns.poses[view] == POSE_PRIOR)
        {
            const Vector3d w = logRotation(at.gripper2base[view].R * reported[view].R.transpose());
            sum += w.squaredNorm() / (noise.rotation * noise.rotation);
            sum += (at.gripper2base[view].t - reported[view].t).squaredNorm() / (noise.translation * noise.translation);
        }
    return sum;
}

double RefineProblem::cost(const CalibrationState& at) const
{
    const double sum = pointCost(at) + stripeCost(at) + priorCost(at);
    return std::isfinite(sum) ? sum : infinity;
}

double RefineProblem::costAfter(const VectorXd& step) const
{
    trial_ = moved(step);
    const CameraViews views = trial_.views();
    const Camera& camera = trial_.calibration.camera;
    if (!(camera.K(0, 0) > 0 && camera.K(1, 1) > 0))
        return infinity;
    double sum = 0;
    for (int track = 0; track < tracks.count() && sum < infinity; ++track)
        if (tracks.isUsed(track))
            sum += tracks.isKnown(track) ? trackCost(track, views, camera, trial_.points[track])
                                         : movePoint(track, views, camera, trial_.points[track]);
    sum /= meanSlope_ * noise.point * noise.point;
    sum += sum < infinity ? stripeCost(trial_) + priorCost(trial_) : 0;
    return std::isfinite(sum) ? sum : infinity;
}

void RefineProblem::apply(const VectorXd&)
{
    state = trial_; // of costAfter() for the same step
}

bool RefineProblem::updateClipping()
{
    const double k = huberThreshold_ * noise.point;
    const std::vector<double> errors = normalizedErrors(tracks, state);
    double slopes = 0;
    int used = 0;
    for (int track = 0; track < tracks.count(); ++track)
        for (int i = tracks.first[track]; tracks.isUsed(track) && i < tracks.first[track + 1]; ++i)
            if (tracks.observations[i].used)
            {
                slopes += errors[i] <= k ? 1 : 0.5 * k / errors[i];
                ++used;
            }
    const double before = meanSlope_;
    meanSlope_ = used ? std::max(0.1, slopes / used) : 1;
    return meanSlope_ != before;
}

double RefineProblem::linearize(MatrixXd& JtJ, VectorXd& Jtr)
{
    linearizeData();
    const double pointWeight = 1 / (noise.point * noise.point), stripeWeight = 1 / (noise.stripe * noise.stripe);
    JtJ = pointWeight * points_.JtJ;
    Jtr = pointWeight * points_.Jtr;
    if (unknowns.surfaces > 0)
    {
        JtJ += stripeWeight * stripes_.JtJ;
        Jtr += stripeWeight * stripes_.Jtr;
    }
    for (int view = 0; view < int(reported.size()); ++view)
        if (unknowns.poses[view] == POSE_PRIOR)
        {
            const int column = unknowns.poseColumn(view);
            Vector6d precision;
            precision << Vector3d::Constant(1 / (noise.rotation * noise.rotation)),
                Vector3d::Constant(1 / (noise.translation * noise.translation));
            JtJ.diagonal().segment<6>(column) += precision;
            Jtr.segment<6>(column) += precision.cwiseProduct(correction(view));
        }
    return cost(state);
}

}} // namespace cv::active_handeye
