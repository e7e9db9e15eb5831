// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "closed_forms.hpp"
#include "decompositions.hpp"
#include "motion_groups.hpp"
#include "normalization.hpp"
#include "track_fit.hpp"
#include "turn_directions.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::Vector4d;

namespace {

//! Residuals linear in X_j and t (doc/method/rotation.md): p = (t, 1), lengths in units of the spread of the gripper positions.
class RotationProblem : public TrackProblem<RotationModel>
{
public:
    RotationProblem(const AlignedVector<Pose>& gripper2base, const std::vector<Pixels>& ideal, const Matrix3d& K,
                    const Matrix3d& R_cam2gripper, const MatrixXd& observed)
        : observed_(observed)
    {
        std::vector<const Pixels*> all;
        std::vector<int> views;
        Vector3d center = Vector3d::Zero();
        for (size_t view = 0; view < ideal.size(); ++view)
        {
            all.push_back(&ideal[view]);
            views.push_back(int(view));
            center += gripper2base[view].t / double(ideal.size());
        }
        for (const Pose& pose : gripper2base)
            length = std::max(length, (pose.t - center).norm());
        const Normalization T(all);
        std::vector<Pixels> normalized = ideal;
        for (Pixels& pixels : normalized)
            for (Eigen::Vector2d& x : pixels)
                x = T.apply(x);
        tracks.add(normalized, views);
        const Matrix3d gripperToImage = T.matrix() * K * R_cam2gripper.transpose();
        models.resize(ideal.size());
        for (size_t view = 0; view < models.size(); ++view)
        {
            const Pose& pose = gripper2base[view];
            toImage.push_back(gripperToImage * pose.R.transpose());
            models[view].negative << pose.R, (pose.t - center) / std::max(length, 1e-300);
        }
        pixelsPerUnit = 1 / T.scale;
        tracks.focalLength = std::sqrt(K(0, 0) * K(1, 1)) * T.scale;
        function = "calibrateHandEyeRotation";
    }

    Vector4d minimize(const Matrix4d& S) CV_OVERRIDE
    {
        const MatrixXd A = observed_.transpose() * S.topLeftCorner<3, 3>() * observed_;
        Vector4d p;
        p << -observed_ * solveSymmetric<Eigen::VectorXd>(A, observed_.transpose() * S.topRightCorner<3, 1>()), 1;
        return p;
    }

    bool updateImages(const Vector4d&) CV_OVERRIDE { return false; }
    bool mirror(const Matrix4d&, Vector4d&) CV_OVERRIDE { return false; }
    MatrixXd tangent() const CV_OVERRIDE { return Eigen::Matrix<double, 4, 3>::Identity() * observed_; }

    //! Covariance of t for residuals of standard deviation sigma, in units of length^2, within what is observed.
    Matrix3d covariance(const Matrix4d& S, double sigma) const
    {
        const MatrixXd A = observed_.transpose() * S.topLeftCorner<3, 3>() * observed_;
        return sigma * sigma * observed_ * inverseOfSymmetric(A) * observed_.transpose();
    }

    double length = 0; //!< unit of length of the problem

private:
    MatrixXd observed_;
};

void requireTurns(const TurnDirections& turns, const AlignedVector<Pose>& poses, bool allowPartial)
{
    double largest = 0;
    for (const Pose& pose : poses)
        largest = std::max(largest, angleBetween(poses[0].R, pose.R));
    if (turns.observed.cols() == 0)
        CV_Error(
            Error::StsNoConv,
            cv::format(
                "R_gripper2base: no change of orientation, t_cam2gripper is not observed; needed turns of more than %g deg "
                "about two axes that are not parallel, given at most %.3f deg",
                smallestTurn, largest));
    if (turns.observed.cols() == 3 || allowPartial)
        return;
    const Vector3d a = turns.axis, b = turns.axisInBase, across = b.unitOrthogonal();
    CV_Error(
        Error::StsNoConv,
        cv::format(
            "R_gripper2base: all rotation axes are parallel, t_cam2gripper along the axis is not observed; needed turns about two "
            "axes that are not parallel, given only turns about (%.2f, %.2f, %.2f) in the gripper frame, (%.2f, %.2f, %.2f) in "
            "base coordinates: add a turn about an axis across it, such as (%.2f, %.2f, %.2f) in base coordinates, or "
            "set ROTATION_ALLOW_PARTIAL",
            a.x(), a.y(), a.z(), b.x(), b.y(), b.z(), across.x(), across.y(), across.z()));
}

//! Infinite variance along the axis, and infinite covariance with what it touches.
void markUnobserved(const Vector3d& axis, Matrix3d& covariance)
{
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (std::abs(axis[i] * axis[j]) > 1e-12)
                covariance(i, j) = std::copysign(std::numeric_limits<double>::infinity(), axis[i] * axis[j]);
}

//! Robot noise instead of translations leaves the scale to chance.
void requireScale(const Matrix3d& covariance, const MatrixXd& observed, double depth)
{
    const double largestShare = 0.3;
    const MatrixXd known = observed.transpose() * covariance * observed;
    const double deviation = std::sqrt(known.diagonal().maxCoeff());
    if (!(deviation < largestShare * depth))
        CV_Error(
            Error::StsNoConv,
            cv::format(
                "t_gripper2base: t_cam2gripper is not determined; needed a standard deviation below %g of the distance of the "
                "scene, given %.3g at a distance of %.3g: translate farther and turn more",
                largestShare, deviation, depth));
}

//! Points seen in views of different orientation carry the answer.
void requireLinks(const Tracks& tracks, const AlignedVector<Pose>& poses, size_t points)
{
    std::vector<int> groupOf(poses.size());
    const std::vector<MotionGroup> groups = groupByOrientation(poses, smallestTurn);
    for (size_t g = 0; g < groups.size(); ++g)
        for (int view : groups[g].views)
            groupOf[view] = int(g);
    int linking = 0;
    for (int j = 0; j < tracks.count(); ++j)
    {
        const auto from = tracks.observations.begin() + tracks.first[j],
                   to = tracks.observations.begin() + tracks.first[j + 1];
        linking += std::any_of(from, to, [&](const Observation& o) { return groupOf[o.view] != groupOf[from->view]; });
    }
    if (linking < 2)
        CV_Error(
            Error::StsNoConv,
            cv::format(
                "imagePoints: too few points in common; needed 2 or more points that are seen in views of different "
                "orientation, given %d out of %d points in %d views",
                linking, int(points), int(poses.size())));
}

} // namespace

double rotationClosedForm(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base,
                          InputArrayOfArrays imagePoints, InputArray cameraMatrix, InputArray distCoeffs,
                          InputArray R_cam2gripper, OutputArray t_cam2gripper, OutputArray covariance, int flags,
                          ViewDoubts& doubts)
{
    const AlignedVector<Pose> poses = readRobotPoses(R_gripper2base, t_gripper2base);
    const Camera camera = readCamera(cameraMatrix, distCoeffs);
    const std::vector<Pixels> pixels = idealPixels(readImagePoints(imagePoints, poses.size()), camera);
    const Matrix3d R = readRotation(R_cam2gripper, "R_cam2gripper");
    if (flags & ~int(ROTATION_ALLOW_PARTIAL))
        CV_Error(Error::StsBadArg, cv::format("flags: needed 0 or ROTATION_ALLOW_PARTIAL (1), given %d", flags));

    const TurnDirections turns(poses);
    requireTurns(turns, poses, (flags & ROTATION_ALLOW_PARTIAL) != 0);
    RotationProblem problem(poses, pixels, camera.K, R, turns.observed);
    requireLinks(problem.tracks, poses, pixels[0].size());
    if (!(problem.length > 1e-9 * poses[0].t.norm()))
        CV_Error(
            Error::StsNoConv,
            "t_gripper2base: the gripper only turned, which leaves the scale of t_cam2gripper open; needed views at different "
            "places, given one place: add a translation");
    problem.largeResidual = doubts.threshold;
    const TrackFit<RotationModel> fit = fitTracks(problem);
    doubts.rejectedViews = fit.rejectedViews;
    const Vector3d t = fit.p.head<3>() * problem.length;
    const int parameters = int(turns.observed.cols());
    Matrix3d uncertainty = problem.covariance(fit.S, fit.sigma(parameters) * problem.length);
    requireScale(uncertainty, turns.observed, fit.medianDepth * problem.length);
    if (parameters < 3)
        markUnobserved(turns.axis, uncertainty);
    writeMatrix(t, t_cam2gripper);
    if (covariance.needed())
        writeMatrix(uncertainty, covariance);
    return fit.rms() * problem.pixelsPerUnit;
}

double calibrateHandEyeRotation(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base,
                                InputArrayOfArrays imagePoints, InputArray cameraMatrix, InputArray distCoeffs,
                                InputArray R_cam2gripper, OutputArray t_cam2gripper, OutputArray covariance, int flags)
{
    CV_TRACE_FUNCTION();
    ViewDoubts doubts = {largeImageNoise, {}};
    const double rms = rotationClosedForm(R_gripper2base, t_gripper2base, imagePoints, cameraMatrix, distCoeffs,
                                          R_cam2gripper, t_cam2gripper, covariance, flags, doubts);
    warnOfRejectedViews("calibrateHandEyeRotation", doubts);
    return rms;
}

}} // namespace cv::active_handeye
