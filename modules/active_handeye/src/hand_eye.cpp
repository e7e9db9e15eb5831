// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "distributions.hpp"
#include "hand_eye_closed_forms.hpp"
#include "hand_eye_fit.hpp"
#include "input.hpp"
#include "observability.hpp"

#include "opencv2/core/utils/logger.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

HandEyeParams::HandEyeParams()
    : targetRotationSigma(-1), targetTranslationSigma(-1), robotRotationSigma(-1), robotTranslationSigma(0)
{}

HandEyeSummary::HandEyeSummary() : usable(false), iterations(0), chiSquare(0), chiSquareDof(0), chiSquarePValue(0) {}

namespace {

HandEyeViews readViews(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base,
                       InputArrayOfArrays R_target2cam, InputArrayOfArrays t_target2cam)
{
    HandEyeViews views;
    const size_t least = 3;
    views.gripper2base = readRobotPoses(R_gripper2base, t_gripper2base, least);
    views.target2cam = readPoses(R_target2cam, t_target2cam, "R_target2cam", "t_target2cam", least);
    if (views.target2cam.size() != views.gripper2base.size())
        CV_Error(
            Error::StsBadSize,
            cv::format("R_target2cam: needed one rotation for each of the %d rotations of R_gripper2base, given %d",
                       views.count(), int(views.target2cam.size())));
    requireTurns(views);
    return views;
}

NoiseVariances readNoise(const HandEyeParams& params)
{
    const double given[] = {params.targetRotationSigma, params.targetTranslationSigma, params.robotRotationSigma,
                            params.robotTranslationSigma};
    const char* const names[] = {"targetRotationSigma", "targetTranslationSigma", "robotRotationSigma",
                                 "robotTranslationSigma"};
    for (int k = 0; k < HAND_EYE_NOISES; ++k)
        if (!std::isfinite(given[k]))
            CV_Error(Error::StsOutOfRange,
                     cv::format("params.%s: needed a finite number (negative = estimated), given %g", names[k],
                                given[k]));
    for (int k : {NOISE_TARGET_ROTATION, NOISE_TARGET_TRANSLATION})
        if (given[k] == 0 && given[k + 2] == 0)
            CV_Error(Error::StsOutOfRange, cv::format("params.%s, params.%s: needed one that is not 0, given 0 and 0",
                                                      names[k], names[k + 2]));
    if (params.targetTranslationSigma < 0 && params.robotTranslationSigma < 0)
        CV_Error(Error::StsBadArg,
                 "params.robotTranslationSigma: needed 0 or more unless targetTranslationSigma is given (both "
                 "have the same effect), given two that are to be estimated");
    return NoiseVariances(given);
}

//! Of the arrangement of gripper and target.
double lengthOf(const HandEyeViews& views)
{
    Vector3d center = Vector3d::Zero();
    double squares = 0;
    for (const Pose& pose : views.gripper2base)
        center += pose.t / views.count();
    for (int view = 0; view < views.count(); ++view)
        squares += (views.gripper2base[view].t - center).squaredNorm() + views.target2cam[view].t.squaredNorm();
    const double length = std::sqrt(squares / views.count());
    if (!(length > 0))
        CV_Error(Error::StsNoConv, "t_gripper2base, t_target2cam: needed translations, given zeros alone");
    return length;
}

void requireDetermined(const HandEyeViews& views, const HandEyeVariances& variances, double length)
{
    const double largestAngle = 0.3, largestShare = 0.3;
    const Matrix12d& C = variances.covariance();
    const Eigen::SelfAdjointEigenSolver<Matrix3d> rotation(C.block<3, 3>(0, 0)), translation(C.block<3, 3>(3, 3));
    const double angle = std::sqrt(rotation.eigenvalues()(2)), share = std::sqrt(translation.eigenvalues()(2)) / length;
    if (angle < largestAngle && share < largestShare)
        return;
    CV_Error(
        Error::StsNoConv,
        cv::format(
            "R_gripper2base: the noise leaves the result open; needed standard deviations below %g rad and %g of the "
            "distances, given %.3g rad and %.3g; ",
            largestAngle, largestShare, angle, share) +
            unobservedTranslation(translation.eigenvectors().col(2), TurnDirections(views.gripper2base)));
}

//! Base frame in the middle of the gripper's positions: places far from it would only cost digits.
Vector3d moveToMiddle(AlignedVector<Pose>& poses)
{
    Vector3d middle = Vector3d::Zero();
    for (const Pose& pose : poses)
        middle += pose.t / double(poses.size());
    for (Pose& pose : poses)
        pose.t -= middle;
    return middle;
}

void writeIntervals(const HandEyeFit& fit, HandEyeSummary& summary)
{
    const Matrix6d C = fit.variances().covariance().topLeftCorner<6, 6>();
    const Vector6d deviations = C.diagonal().cwiseSqrt();
    Vector6d middle, dof, half;
    middle << Vector3d::Zero(), fit.state().cam2gripper.t;
    for (int i = 0; i < 6; ++i)
    {
        dof(i) = fit.variances().degreesOfFreedom(i);
        half(i) = studentQuantile(0.05, dof(i)) * deviations(i);
    }
    MatrixXd intervals(6, 2);
    intervals << middle - half, middle + half;
    writeMatrix(C, summary.covariance);
    writeMatrix(deviations, summary.standardDeviations);
    writeMatrix(dof, summary.degreesOfFreedom);
    writeMatrix(intervals, summary.intervals95);
}

void writeNoise(const HandEyeFit& fit, HandEyeSummary& summary)
{
    MatrixXd table(int(HAND_EYE_NOISES), 4);
    bool isGiven = true;
    for (int k = 0; k < HAND_EYE_NOISES; ++k)
    {
        table.row(k) << std::sqrt(fit.variances().variances()(k)), fit.variances().interval(k).transpose(),
            double(fit.isEstimated(k));
        isGiven = isGiven && !fit.isEstimated(k);
    }
    const double NaN = std::numeric_limits<double>::quiet_NaN();
    writeMatrix(table, summary.noiseLevels);
    summary.chiSquare = isGiven ? fit.variances().chiSquare() : NaN;
    summary.chiSquareDof = isGiven ? 6. * fit.usedViews() - 12 : NaN;
    summary.chiSquarePValue = isGiven ? chiSquareTail(summary.chiSquare, summary.chiSquareDof) : NaN;
}

void writeViews(const HandEyeViews& views, const HandEyeFit& fit, HandEyeSummary& summary)
{
    MatrixXd residuals(views.count(), 6), pValues(views.count(), 2);
    summary.rejectedViews.clear();
    summary.culprits.clear();
    for (int view = 0; view < views.count(); ++view)
    {
        const Vector6d residual = residualOf(views, view, fit.state());
        residuals.row(view) = residual.transpose();
        pValues.row(view) = fit.pValues(view).transpose();
        if (fit.isUsed(view))
            continue;
        summary.rejectedViews.push_back(view);
        summary.culprits.push_back(cv::format(
            "view %d: its poses of gripper and target contradict the other views, by %.3g deg (p = %.2g) and by %.3g "
            "(p = %.2g); it is left out",
            view, residual.head<3>().norm() * 180 / CV_PI, pValues(view, 0), residual.tail<3>().norm(),
            pValues(view, 1)));
    }
    writeMatrix(residuals, summary.residuals);
    writeMatrix(pValues, summary.viewPValues);
}

void judge(int views, HandEyeSummary& summary)
{
    const double leastPValue = 0.01;
    const int rejected = int(summary.rejectedViews.size());
    summary.usable = !(summary.chiSquarePValue < leastPValue);
    summary.message = summary.usable ? "usable"
                                     : cv::format("not usable: the poses do not fit the noise levels given (p = %.2g)",
                                                  summary.chiSquarePValue);
    if (rejected > 0)
        summary.message += cv::format("; %d of %d views contradict the others and were left out", rejected, views);
}

//! Maximum likelihood. Returns the standard deviation of the translation.
double refined(HandEyeViews views, const NoiseVariances& given, Pose& cam2gripper, HandEyeSummary& summary)
{
    requireSameUnit(motionsOf(views));
    const double length = lengthOf(views);
    const Vector3d middle = moveToMiddle(views.gripper2base);
    const HandEyeStart start = findHandEyeStart(views);
    requireAgreement(views, start.state.cam2gripper);
    HandEyeFit fit(views, given, length);
    fit.run(start);
    requireMostViews(views, fit.usedViews());
    requireDetermined(views, fit.variances(), length);
    cam2gripper = fit.state().cam2gripper;
    summary.iterations = fit.iterations();
    writeIntervals(fit, summary);
    writeNoise(fit, summary);
    writeViews(views, fit, summary);
    writeMatrix(fit.state().target2base.R, summary.R_target2base);
    writeMatrix(fit.state().target2base.t + middle, summary.t_target2base);
    judge(views.count(), summary);
    return std::sqrt(fit.variances().covariance().block<3, 3>(3, 3).trace());
}

} // namespace

void calibrateHandEye(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base,
                      InputArrayOfArrays R_target2cam, InputArrayOfArrays t_target2cam, OutputArray R_cam2gripper,
                      OutputArray t_cam2gripper, HandEyeMethod method)
{
    CV_TRACE_FUNCTION();
    if (method == CALIB_HAND_EYE_REFINED)
    {
        HandEyeSummary summary;
        calibrateHandEyeExtended(R_gripper2base, t_gripper2base, R_target2cam, t_target2cam, R_cam2gripper,
                                 t_cam2gripper, summary);
        for (const std::string& culprit : summary.culprits)
            CV_LOG_WARNING(NULL, "calibrateHandEye: " << culprit);
        return;
    }
    const HandEyeViews views = readViews(R_gripper2base, t_gripper2base, R_target2cam, t_target2cam);
    const HandEyeMotions motions = motionsOf(views);
    requireSameUnit(motions);
    const Pose cam2gripper = handEyeClosedForm(motions, method);
    requireAgreement(views, cam2gripper);
    writeMatrix(cam2gripper.R, R_cam2gripper);
    writeMatrix(cam2gripper.t, t_cam2gripper);
}

double calibrateHandEyeExtended(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base,
                                InputArrayOfArrays R_target2cam, InputArrayOfArrays t_target2cam,
                                OutputArray R_cam2gripper, OutputArray t_cam2gripper, HandEyeSummary& summary,
                                const HandEyeParams& params)
{
    CV_TRACE_FUNCTION();
    const HandEyeViews views = readViews(R_gripper2base, t_gripper2base, R_target2cam, t_target2cam);
    Pose cam2gripper;
    const double deviation = refined(views, readNoise(params), cam2gripper, summary);
    writeMatrix(cam2gripper.R, R_cam2gripper);
    writeMatrix(cam2gripper.t, t_cam2gripper);
    return deviation;
}

}} // namespace cv::active_handeye
