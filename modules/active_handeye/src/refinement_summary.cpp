// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// The verdict, and everything that supports it.
#include "precomp.hpp"
#include "distributions.hpp"
#include "decompositions.hpp"
#include "refinement.hpp"
#include "residuals.hpp"

namespace cv { namespace active_handeye {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

static const double NaN = std::numeric_limits<double>::quiet_NaN();
static const double infinity = std::numeric_limits<double>::infinity();

MatrixXd parametersByStep(const HandEyeCalibration& calibration)
{
    MatrixXd J(20, CALIBRATION_COLUMNS);
    J.setZero();
    J.topLeftCorner<POINT_COLUMNS, POINT_COLUMNS>().setIdentity();
    J.block<3, 2>(POINT_COLUMNS, COLUMN_NORMAL) = tangentBasis(calibration.light.n);
    J(POINT_COLUMNS + 3, COLUMN_OFFSET) = 1;
    return J;
}

static Eigen::Matrix<double, 20, 1> parameterValues(const HandEyeCalibration& c)
{
    Eigen::Matrix<double, 20, 1> values;
    values << c.camera.K(0, 0), c.camera.K(1, 1), c.camera.K(0, 2), c.camera.K(1, 2), c.camera.K(0, 1), c.camera.D[0],
        c.camera.D[1], c.camera.D[2], c.camera.D[3], c.camera.D[4], 0, 0, 0, c.cam2gripper.t, c.light.n, c.light.d;
    return values;
}

bool HandEyeRefinement::observesTranslation() const
{
    return turns_.observed.cols() == 3 || params_.flags & REFINE_FIX_TRANSLATION;
}

//! Infinite (co)variances of a position in the gripper frame where the turns do not tell it.
static void markUnobserved(const TurnDirections& turns, Eigen::Ref<MatrixXd> covariance)
{
    const Eigen::Matrix3d unseen = Eigen::Matrix3d::Identity() - turns.observed * turns.observed.transpose();
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (std::abs(unseen(i, j)) > 1e-12)
                covariance(i, j) = std::copysign(infinity, unseen(i, j));
}

void HandEyeRefinement::summarizeParameters(RefineSummary& summary) const
{
    const char* const names[] = {"fx", "fy", "cx", "cy", "skew", "k1", "k2", "p1", "p2", "k3",
                                 "rx", "ry", "rz", "tx", "ty",   "tz", "nx", "ny", "nz", "d"};
    summary.parameterNames.assign(names, names + 20);
    const MatrixXd J = parametersByStep(calibration()) * problem_.unknowns.calibration;
    MatrixXd covariance = J * components_->covariance().topLeftCorner(J.cols(), J.cols()) * J.transpose();
    VectorXd dof(20), deviation(20);
    MatrixXd intervals(20, 2);
    const auto values = parameterValues(calibration());
    if (!observesTranslation())
        markUnobserved(turns_, covariance.block<3, 3>(COLUMN_TRANSLATION, COLUMN_TRANSLATION));
    for (int i = 0; i < 20; ++i)
    {
        VectorXd direction = VectorXd::Zero(problem_.unknowns.count());
        direction.head(J.cols()) = J.row(i);
        deviation(i) = std::sqrt(covariance(i, i));
        dof(i) = deviation(i) > 0 ? components_->degreesOfFreedom(direction) : infinity;
        const double half = deviation(i) > 0 ? studentQuantile(0.05, std::max(1., dof(i))) * deviation(i) : 0;
        intervals.row(i) << values(i) - half, values(i) + half;
    }
    writeMatrix(covariance, summary.covariance);
    writeMatrix(deviation, summary.standardDeviations);
    writeMatrix(dof, summary.degreesOfFreedom);
    writeMatrix(intervals, summary.intervals95);
}

void HandEyeRefinement::summarizeNoise(RefineSummary& summary) const
{
    const double levels[] = {problem_.noise.point, problem_.noise.stripe, problem_.noise.translation,
                             problem_.noise.rotation};
    const double given[] = {params_.pointSigma, params_.stripeSigma, params_.robotTranslationSigma,
                            params_.robotRotationSigma};
    summary.pointSigma = levels[0];
    summary.stripeSigma = levels[1];
    summary.robotTranslationSigma = params_.robotTranslationSigma == 0 ? 0 : levels[2];
    summary.robotRotationSigma = params_.robotRotationSigma == 0 ? 0 : levels[3];
    Eigen::Matrix4d table;
    summary.chiSquare = summary.chiSquareDof = 0;
    for (int k = 0; k < NOISE_COMPONENTS; ++k)
    {
        const bool isPresent = components_->isPresent(k);
        const double spread =
            std::exp(0.5 * 1.96 *
                     std::sqrt(components_->logVarianceCovariance()(k, k))); // of a variance: half of its logarithm
        const double level = isPresent ? levels[k] : given[k] == 0 ? 0 : NaN;
        table.row(k) << level, level / spread, level * spread, components_->isEstimated(k);
        if (!isPresent || !(given[k] > 0))
            continue;
        summary.chiSquare += components_->sumOfSquares(k) / (given[k] * given[k]);
        summary.chiSquareDof += components_->effectiveRedundancy(k);
    }
    const bool isTested = summary.chiSquareDof >= 1;
    summary.chiSquarePValue = isTested ? chiSquareTail(summary.chiSquare, summary.chiSquareDof) : NaN;
    summary.chiSquare = isTested ? summary.chiSquare : NaN;
    writeMatrix(table, summary.noiseLevels);

    summary.lensModel = lensModel_;
    MatrixXd tests(int(LENS_MODELS), 4);
    for (int model = 0; model < LENS_MODELS; ++model)
        tests.row(model) << lensTests_[model].statistic, lensTests_[model].lacking, lensTests_[model].pValue,
            lensTests_[model].informationCriterion();
    writeMatrix(tests, summary.lensTests);
}

void HandEyeRefinement::summarizeResiduals(RefineSummary& summary) const
{
    const int views = int(measurements_.gripper2base.size()), points = int(measurements_.imagePoints[0].size());
    MatrixXd residuals = MatrixXd::Constant(views, 2 * points, NaN), corrections(views, 6);
    MatrixXd scene = MatrixXd::Constant(points, 3, NaN);
    VectorXd squares = VectorXd::Zero(views), used = VectorXd::Zero(views);
    summary.rejectedObservations.create(views, points, CV_8U);
    summary.rejectedObservations.setTo(0);
    const CameraViews cameras = problem_.state.views();
    for (int track = 0; track < tracks_.count(); ++track)
    {
        const Vector3d& X = problem_.state.points[track];
        const int column = tracks_.column[track];
        if (tracks_.isUsed(track))
            scene.row(column) = X;
        for (int i = tracks_.first[track]; i < tracks_.first[track + 1]; ++i)
        {
            const PointObservation& o = tracks_.observations[i];
            Eigen::Vector2d error(NaN, NaN);
            PointResidual::evaluate(problem_.state.calibration.camera, cameras[o.view], X, o.pixel, error);
            residuals.block<1, 2>(o.view, 2 * column) = error.transpose();
            const bool isUsed = o.used && tracks_.isUsed(track);
            summary.rejectedObservations.at<uchar>(o.view, column) = !isUsed;
            squares(o.view) += isUsed ? error.squaredNorm() : 0;
            used(o.view) += isUsed;
        }
    }
    for (int view = 0; view < views; ++view)
        corrections.row(view) = problem_.correction(view);
    writeMatrix(residuals, summary.residuals);
    writeMatrix(corrections, summary.poseCorrections);
    writeMatrix(squares.cwiseQuotient(used).cwiseSqrt(), summary.viewRms);
    writeMatrix(scene, summary.scenePoints);
}

//! Covariance in the gripper frame of a point on the central ray at the working distance.
static Eigen::Matrix3d toolCovariance(const RefineProblem& problem, const MatrixXd& calibrationCovariance, double depth)
{
    const HandEyeCalibration& c = problem.state.calibration;
    Eigen::Vector2d centre = Eigen::Vector2d::Zero();
    double used = 0;
    for (const PointObservation& o : problem.tracks.observations)
        if (o.used)
        {
            centre += o.pixel;
            used += 1;
        }
    const Vector3d Y = depth * c.camera.ray(centre / used);
    Eigen::Matrix<double, 3, CALIBRATION_COLUMNS> J = Eigen::Matrix<double, 3, CALIBRATION_COLUMNS>::Zero();
    J.leftCols<10>() = depth * c.cam2gripper.R.leftCols<2>() * rayByCamera(c.camera, Y.head<2>() / Y.z());
    J.middleCols<3>(COLUMN_ROTATION) = -skew(c.cam2gripper.R * Y);
    J.middleCols<3>(COLUMN_TRANSLATION).setIdentity();
    const MatrixXd byUnknowns = J * problem.unknowns.calibration;
    return byUnknowns * calibrationCovariance * byUnknowns.transpose();
}

void HandEyeRefinement::summarizeVerdict(RefineSummary& summary) const
{
    const int f = int(problem_.unknowns.calibration.cols());
    summary.workingDistance = workingDistance();
    MatrixXd tool = toolCovariance(problem_, components_->covariance().topLeftCorner(f, f), summary.workingDistance);
    const double deviation = std::sqrt(symmetricEigen(tool).eigenvalues()(2));
    if (!observesTranslation())
        markUnobserved(turns_, tool);
    writeMatrix(tool, summary.toolCovariance);
    summary.rejectedViews = doubtedViews_;
    std::sort(summary.rejectedViews.begin(), summary.rejectedViews.end());
    summary.culprits = culprits_;
    for (int view : doubtedViews_)
        if (problem_.unknowns.poses[view] == POSE_FREE)
        {
            const Vector6d correction = problem_.correction(view);
            summary.culprits.push_back(cv::format(
                "view %d: its pose is off by %.3g (unit of t_gripper2base) and %.3g deg, far more than the robot's noise; "
                "the reported pose is not used",
                view, correction.tail<3>().norm(), correction.head<3>().norm() * 180 / CV_PI));
        }
    summary.weakDirections = weakDirections_;
    summary.iterations = iterations_;
    summary.stopReason = "converged: a step no longer lowers the cost";
    const LensTest& lens = lensTests_[lensModel_];
    const bool lensFits = lens.pValue > 1e-4;
    const bool noiseFits = !(summary.chiSquarePValue < 1e-4);
    const bool aspectFits = aspectPValue_ > 1e-4;
    summary.usable = lensFits && noiseFits && aspectFits;
    if (!lensFits)
        summary.message = cv::format("not usable: the lens has distortion that lensModel = %d lacks (p = %.2g)",
                                     lensModel_, lens.pValue);
    else if (!aspectFits)
        summary.message = cv::format("not usable: fy / fx is not %.6g as REFINE_FIX_ASPECT says (p = %.2g)",
                                     calibration().camera.K(1, 1) / calibration().camera.K(0, 0), aspectPValue_);
    else if (!noiseFits)
        summary.message =
            cv::format("not usable: residuals and pose corrections are larger than the noise levels given "
                       "(chi-square %.4g for %.0f degrees of freedom, p = %.2g)",
                       summary.chiSquare, summary.chiSquareDof, summary.chiSquarePValue);
    else if (!observesTranslation())
        summary.message = "usable in part: " + weakDirections_.back();
    else
        summary.message = cv::format("usable: a point at the working distance of %.4g is known to %.2g (unit of "
                                     "t_gripper2base, 95 %%) in the gripper frame",
                                     summary.workingDistance, 1.96 * deviation);
}

void HandEyeRefinement::summarize(RefineSummary& summary) const
{
    summary.rms = rms();
    summarizeParameters(summary);
    summarizeNoise(summary);
    summarizeResiduals(summary);
    summarizeStripes(summary);
    summarizeStripeGroups(summary);
    summarizeVerdict(summary);
}

}} // namespace cv::active_handeye
