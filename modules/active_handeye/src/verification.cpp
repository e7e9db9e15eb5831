// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "verification.hpp"
#include "decompositions.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

static const double wildError = 6; // sigmas

static CalibrationState stateOf(const HandEyeCalibration& calibration, const AlignedVector<Pose>& gripper2base)
{
    CalibrationState state;
    state.calibration = calibration;
    state.gripper2base = gripper2base;
    return state;
}

Verification::Verification(const AlignedVector<Pose>& gripper2base, const SceneTracks& tracks,
                           const HandEyeCalibration& calibration, const MatrixXd& covariance, const NoiseLevels& noise)
    : gripper2base_(gripper2base), tracks_(tracks), covariance_(covariance),
      problem_(tracks_, noSegments_, gripper2base, stateOf(calibration, gripper2base), verificationHuberThreshold)
{
    problem_.noise = noise;
    problem_.unknowns.calibration.resize(CALIBRATION_COLUMNS, 0);
    problem_.unknowns.poses.assign(gripper2base.size(), noise.rotation > 0 ? POSE_PRIOR : POSE_EXACT);
}

//! Columns of the calibration whose variance is known and not zero, in units of their standard deviations.
MatrixXd Verification::testedColumns() const
{
    MatrixXd columns = MatrixXd::Zero(CALIBRATION_COLUMNS, POINT_COLUMNS);
    int count = 0;
    for (int i = 0; i < POINT_COLUMNS; ++i)
        if (covariance_(i, i) > 0 && covariance_.row(i).allFinite())
            columns(i, count++) = std::sqrt(covariance_(i, i));
    return columns.leftCols(count);
}

//! Covariance of the calibration in units of testedColumns().
MatrixXd Verification::testedCorrelation() const
{
    const MatrixXd B = testedColumns().topRows<POINT_COLUMNS>(), signs = B.cwiseSign();
    const VectorXd inverseScale = VectorXd(B.colwise().sum()).cwiseInverse(); // one entry a column
    return inverseScale.asDiagonal() * (signs.transpose() * covariance_ * signs) * inverseScale.asDiagonal();
}

void Verification::settle(RefineProblem& problem) const
{
    problem.updateClipping();
    if (problem.unknowns.count() > 0)
        solveLeastSquares(problem, 50, 1e-10);
    else
        for (int pass = 0; pass < 5; ++pass)
        {
            problem.costAfter(VectorXd(0));
            problem.apply(VectorXd(0));
        }
}

void Verification::leaveOut(double limit)
{
    const std::vector<double> errors = normalizedErrors(tracks_, problem_.state);
    used = rejected = 0;
    for (size_t i = 0; i < errors.size(); ++i)
    {
        tracks_.observations[i].used = errors[i] <= limit;
        used += tracks_.observations[i].used;
        rejected += !tracks_.observations[i].used;
    }
}

//! Its points are no wrong matches, then: the view as a whole contradicts the others.
bool Verification::isMostlyRejected(int view) const
{
    int balance = 0;
    for (const PointObservation& o : tracks_.observations)
        if (o.view == view)
            balance += o.used ? -1 : 1;
    return balance > 0;
}

static double typicalError(const SceneTracks& tracks, const CalibrationState& state)
{
    std::vector<double> errors = normalizedErrors(tracks, state);
    std::nth_element(errors.begin(), errors.begin() + errors.size() / 2, errors.end());
    return errors[errors.size() / 2];
}

void Verification::findScene()
{
    if (tracks_.count() == 0)
        CV_Error(Error::StsNoConv, "imagePoints: needed points that two views see, given none");
    triangulate(tracks_, std::numeric_limits<double>::infinity(), problem_.state);
    const double limit = wildError * std::max(typicalError(tracks_, problem_.state), problem_.noise.point);
    triangulate(tracks_, limit, problem_.state);
    leaveOut(limit);
    settle(problem_);
    leaveOut(wildError * std::max(typicalError(tracks_, problem_.state), problem_.noise.point));
    settle(problem_);
}

//! Factor of 1 or more at which the squared length, which falls with it, is that of `dof` normal numbers.
template <class Length>
static double largerCovariance(const Length& length, int dof)
{
    double low = 1, high = 1;
    const double largest = 1e8;
    while (length(high) > dof && high < largest)
        low = high, high *= 4;
    for (int i = 0; i < 20 && high > low; ++i)
    {
        const double middle = std::sqrt(low * high);
        (length(middle) > dof ? low : high) = middle;
    }
    return high;
}

void Verification::testDrift()
{
    problem_.unknowns.calibration = testedColumns();
    MatrixXd H;
    VectorXd gradient;
    problem_.linearize(H, gradient);
    const int f = int(problem_.unknowns.calibration.cols()), poses = int(H.rows()) - f;
    MatrixXd S = H.topLeftCorner(f, f);
    VectorXd g = gradient.head(f);
    double squares = problem_.points().squares / std::pow(problem_.noise.point, 2);
    if (poses > 0)
    {
        const Eigen::LDLT<MatrixXd> poseInformation = H.bottomRightCorner(poses, poses).ldlt();
        S -= H.topRightCorner(f, poses) * poseInformation.solve(H.bottomLeftCorner(poses, f));
        g -= H.topRightCorner(f, poses) * poseInformation.solve(gradient.tail(poses));
        for (int view = 0; view < int(gripper2base_.size()); ++view)
        {
            const Vector6d correction = problem_.correction(view);
            squares += correction.head<3>().squaredNorm() / std::pow(problem_.noise.rotation, 2) +
                       correction.tail<3>().squaredNorm() / std::pow(problem_.noise.translation, 2);
        }
    }
    // In the eigenvectors of S the gradient has variance lambda from the views and lambda^2 times that of the calibration.
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen = symmetricEigen(S);
    const double smallestShare = 1e-4; // of the calibration's own information: less is no test
    int first = 0;
    while (first < f && !(eigen.eigenvalues()(first) > smallestShare))
        ++first;
    driftDof = f - first;
    const MatrixXd U = eigen.eigenvectors().rightCols(driftDof);
    const VectorXd root = eigen.eigenvalues().tail(driftDof).cwiseSqrt();
    const VectorXd z = root.cwiseInverse().asDiagonal() * (U.transpose() * g);
    fitChiSquare = squares - z.squaredNorm();
    fitDof = problem_.points().redundancy - driftDof;
    noiseFactor = fitDof > 0 ? std::max(1., fitChiSquare / fitDof) : 1;

    const MatrixXd B = problem_.unknowns.calibration.topRows<POINT_COLUMNS>(), correlation = testedCorrelation();
    const MatrixXd ofCalibration = root.asDiagonal() * (U.transpose() * correlation * U) * root.asDiagonal();
    const auto length = [&](double factor) // squared, when the calibration's covariance is larger by a factor
    {
        MatrixXd spread = factor * ofCalibration;
        spread.diagonal().array() += noiseFactor;
        return z.dot(solveSymmetric(spread, z));
    };
    driftChiSquare = length(1);
    estimateShift(B * correlation * U * root.asDiagonal(), ofCalibration, z, B.rowwise().sum(),
                  largerCovariance(length, driftDof));
}

/** Regression of the parameters on z.

After a change the calibration is farther off than its covariance says: by as much as makes the squared length of z the expected one.
byScore: covariance of the parameters with z. tested: standard deviations of the calibration, 0 where it is not tested.
*/
void Verification::estimateShift(const MatrixXd& byScore, const MatrixXd& ofCalibration, const VectorXd& z,
                                 const VectorXd& tested, double factor)
{
    MatrixXd spread = factor * ofCalibration;
    spread.diagonal().array() += noiseFactor;
    const Eigen::LDLT<MatrixXd> inverse(spread);
    const MatrixXd gain = factor * byScore;
    shift = -gain * inverse.solve(z);
    const VectorXd explained = (gain * inverse.solve(gain.transpose())).diagonal();
    shiftDeviation = (factor * tested.cwiseAbs2() - explained).cwiseMax(0).cwiseSqrt();
}

}} // namespace cv::active_handeye
