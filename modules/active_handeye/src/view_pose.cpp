// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "view_pose.hpp"
#include "least_squares.hpp"
#include "residuals.hpp"

namespace cv { namespace active_handeye {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

struct SeenPoint
{
    Vector3d X;
    const PointObservation* observation;
};

//! Geman-McClure: wrong matches hardly count, however many pixels they are off.
class ViewPoseProblem : public LeastSquaresProblem
{
public:
    ViewPoseProblem(const HandEyeCalibration& calibration, const Pose& start, double scale)
        : pose(start), calibration_(calibration), squaredScale_(scale * scale)
    {}

    double linearize(MatrixXd& JtJ, VectorXd& Jtr) CV_OVERRIDE
    {
        Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
        Vector6d pull = Vector6d::Zero();
        const CameraView view(pose, calibration_.cam2gripper);
        for (const SeenPoint& point : seen)
        {
            PointResidual residual;
            if (!residual.linearizePoint(calibration_.camera, view, point.X, point.observation->pixel))
                continue;
            const double weight = point.observation->inverseSigma * point.observation->inverseSigma;
            const double share = squaredScale_ / (squaredScale_ + weight * residual.error.squaredNorm());
            const Eigen::Matrix<double, 2, 6> J = std::sqrt(weight) * share * residual.byPose(view, point.X);
            information += J.transpose().lazyProduct(J);
            pull += J.transpose() * (std::sqrt(weight) * share * residual.error);
        }
        JtJ = information;
        Jtr = pull;
        return cost(pose);
    }

    double costAfter(const VectorXd& step) const CV_OVERRIDE { return cost(moved(pose, step)); }
    void apply(const VectorXd& step) CV_OVERRIDE { pose = moved(pose, step); }

    AlignedVector<SeenPoint> seen;
    Pose pose;

private:
    double cost(const Pose& at) const
    {
        const CameraView view(at, calibration_.cam2gripper);
        double sum = 0;
        for (const SeenPoint& point : seen)
        {
            Eigen::Vector2d error;
            const bool isSeen =
                PointResidual::evaluate(calibration_.camera, view, point.X, point.observation->pixel, error);
            const double squared = error.squaredNorm() * std::pow(point.observation->inverseSigma, 2);
            sum += isSeen ? squaredScale_ * squared / (squaredScale_ + squared) : squaredScale_;
        }
        return sum;
    }

    const HandEyeCalibration& calibration_;
    const double squaredScale_;
};

//! Median distance of the points from their predictions; infinite where most are behind the camera.
double typicalError(const AlignedVector<SeenPoint>& seen, const HandEyeCalibration& calibration, const Pose& pose)
{
    const CameraView view(pose, calibration.cam2gripper);
    std::vector<double> errors;
    for (const SeenPoint& point : seen)
    {
        Eigen::Vector2d error;
        const bool isSeen = PointResidual::evaluate(calibration.camera, view, point.X, point.observation->pixel, error);
        errors.push_back(isSeen ? error.norm() * point.observation->inverseSigma
                                : std::numeric_limits<double>::infinity());
    }
    std::nth_element(errors.begin(), errors.begin() + errors.size() / 2, errors.end());
    return errors[errors.size() / 2];
}

} // namespace

Pose resectView(const SceneTracks& tracks, const CalibrationState& state, int view, double scale)
{
    const double coarseness[] = {1000, 100, 10, 3}; // in units of scale
    AlignedVector<SeenPoint> seen;
    for (int track = 0; track < tracks.count(); ++track)
        for (int i = tracks.first[track]; i < tracks.first[track + 1]; ++i)
            if (tracks.observations[i].view == view && state.points[track].allFinite())
                seen.push_back(SeenPoint{state.points[track], &tracks.observations[i]});
    Pose pose = state.gripper2base[view];
    if (seen.size() < 4)
        return pose;
    const double typical = typicalError(seen, state.calibration, pose);
    for (double factor : coarseness)
    {
        if (factor > 10 && factor * scale > 100 * typical)
            continue; // only a pose that is far off needs the wide ones first
        ViewPoseProblem problem(state.calibration, pose, factor * scale);
        problem.seen = seen;
        solveLeastSquares(problem, 20, 1e-2);
        pose = problem.pose;
    }
    return pose;
}

}} // namespace cv::active_handeye
