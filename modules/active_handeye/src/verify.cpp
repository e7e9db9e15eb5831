// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "distributions.hpp"
#include "numbers.hpp"
#include "refine_input.hpp"
#include "verification.hpp"

namespace cv { namespace active_handeye {

using Eigen::MatrixXd;

VerifyParams::VerifyParams() : pointSigma(0.1), robotTranslationSigma(0), robotRotationSigma(0), significance(0.01) {}

VerifySummary::VerifySummary()
    : valid(false), driftChiSquare(0), driftDof(0), driftPValue(0), fitChiSquare(0), fitDof(0), fitPValue(0),
      usedObservations(0), rejectedObservations(0)
{}

namespace {

//! The first POINT_COLUMNS rows and columns of RefineSummary::covariance.
MatrixXd readCovariance(InputArray covariance)
{
    const int parameters = 20;
    const Numbers numbers = numbersOf(covariance.getMat());
    if (int(numbers.values.size()) != parameters * parameters)
        CV_Error(Error::StsBadSize, "covariance: needed 20 x 20 numbers, given " + numbers.shape);
    const MatrixXd all = Eigen::Map<const Eigen::Matrix<double, 20, 20, Eigen::RowMajor>>(numbers.values.data());
    for (int i = 0; i < parameters; ++i)
        if (!(all(i, i) >= 0))
            CV_Error(Error::StsBadArg,
                     cv::format("covariance: needed variances of 0 or more, given %g at position %d", all(i, i), i));
    return all.topLeftCorner(int(POINT_COLUMNS), int(POINT_COLUMNS));
}

void checkVerifyParams(const VerifyParams& params)
{
    readPositive(params.pointSigma, "params.pointSigma");
    readPositive(params.significance, "params.significance");
    if (!(params.robotTranslationSigma >= 0 && params.robotRotationSigma >= 0) ||
        (params.robotTranslationSigma == 0) != (params.robotRotationSigma == 0))
        CV_Error(
            Error::StsOutOfRange,
            cv::format(
                "params.robotTranslationSigma, params.robotRotationSigma: needed two positive numbers, or 0 and 0 for "
                "an exact robot, given %g and %g",
                params.robotTranslationSigma, params.robotRotationSigma));
}

void summarizeViews(const Verification& verification, int views, VerifySummary& summary)
{
    const double farBeyond = 3; // times what is expected
    MatrixXd errors(views, 4);
    for (int view = 0; view < views; ++view)
    {
        const ViewPrediction p = verification.predict(view);
        errors.row(view) << p.pixels, p.expectedPixels, p.length, p.expectedLength;
        if (p.pixels > farBeyond * p.expectedPixels)
            summary.contradictingViews.push_back(view);
    }
    writeMatrix(errors, summary.viewErrors);
}

void summarizeTests(const Verification& v, const VerifyParams& params, VerifySummary& summary)
{
    summary.driftChiSquare = v.driftChiSquare;
    summary.driftDof = v.driftDof;
    summary.driftPValue = v.driftDof > 0 ? chiSquareTail(v.driftChiSquare, v.driftDof) : 1;
    summary.fitChiSquare = v.fitChiSquare;
    summary.fitDof = v.fitDof;
    summary.fitPValue = v.fitDof > 0 ? chiSquareTail(v.fitChiSquare, v.fitDof) : 1;
    summary.valid = v.driftDof > 0 && summary.driftPValue >= params.significance;
    MatrixXd shift = MatrixXd::Zero(20, 1), deviation = MatrixXd::Zero(20, 1);
    shift.topRows<POINT_COLUMNS>() = v.shift;
    deviation.topRows<POINT_COLUMNS>() = v.shiftDeviation;
    writeMatrix(shift, summary.shift);
    writeMatrix(deviation, summary.shiftDeviations);
    summary.usedObservations = v.used;
    summary.rejectedObservations = v.rejected;
    const std::string noise =
        v.noiseFactor > 1.2 && summary.fitPValue < params.significance
            ? cv::format("; residuals are %.2g times what the noise levels say, which is taken into account",
                         std::sqrt(v.noiseFactor))
            : std::string();
    if (v.driftDof == 0)
        summary.message = "no answer: the new views say nothing about the calibration; add views that differ more";
    else
        summary.message =
            cv::format("%s: the views ask for a shift of chi-square %.3g for %d degrees of freedom (p = %.2g)",
                       summary.valid ? "valid" : "not valid", v.driftChiSquare, v.driftDof, summary.driftPValue) +
            noise;
}

} // namespace

double verifyHandEye(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base,
                     InputArrayOfArrays imagePoints, InputArray cameraMatrix, InputArray distCoeffs,
                     InputArray R_cam2gripper, InputArray t_cam2gripper, InputArray covariance, VerifySummary& summary,
                     InputArrayOfArrays pointSigmas, const VerifyParams& params)
{
    CV_TRACE_FUNCTION();
    checkVerifyParams(params);
    const AlignedVector<Pose> poses = readRobotPoses(R_gripper2base, t_gripper2base);
    const std::vector<Pixels> pixels = readImagePoints(imagePoints, poses.size());
    HandEyeCalibration calibration;
    calibration.camera = readCamera(cameraMatrix, distCoeffs);
    calibration.cam2gripper.R = readRotation(R_cam2gripper, "R_cam2gripper");
    calibration.cam2gripper.t = readVector3(t_cam2gripper, "t_cam2gripper");
    const SceneTracks tracks(pixels, readPointSigmas(pointSigmas, pixels), AlignedVector<Eigen::Vector3d>());
    Verification verification(poses, tracks, calibration, readCovariance(covariance),
                              NoiseLevels{params.pointSigma, 1, params.robotTranslationSigma,
                                          params.robotRotationSigma});
    verification.findScene();
    verification.testDrift();
    summary = VerifySummary();
    summarizeTests(verification, params, summary);
    summarizeViews(verification, int(poses.size()), summary);
    double squares = 0;
    int views = 0;
    const Mat errors = summary.viewErrors;
    for (int view = 0; view < errors.rows; ++view)
        if (!std::isnan(errors.at<double>(view, 0)))
        {
            squares += std::pow(errors.at<double>(view, 0), 2);
            ++views;
        }
    if (views == 0)
        CV_Error(Error::StsNoConv,
                 "imagePoints: no view can be predicted from the others; needed points that three or more views "
                 "see, and a calibration and poses that belong to the images");
    return std::sqrt(squares / views);
}

}} // namespace cv::active_handeye
