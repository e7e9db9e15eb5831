// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Views predicted from the others, with what noise and calibration let expect.
#include "precomp.hpp"
#include "residuals.hpp"
#include "decompositions.hpp"
#include "verification.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

/** Errors of the image points of one view, predicted from a problem without them.

The unknowns are the tested columns of the calibration and the poses; `covariance` is theirs.
*/
class PredictionErrors
{
public:
    PredictionErrors(const RefineProblem& problem, int view, const MatrixXd& covariance)
        : problem_(problem), view_(view), covariance_(covariance), cameras_(problem.state.views())
    {}

    //! A point of the view, whose track the problem has from the other views.
    void add(int track, const PointObservation& seen)
    {
        const CalibrationState& state = problem_.state;
        const Vector3d& X = state.points[track];
        PointResidual residual;
        if (!residual.linearize(state.calibration.camera, cameras_[view_], X, seen.pixel))
            return;
        Matrix3d pointCovariance;
        const MatrixXd pointByUnknowns = followsUnknowns(track, pointCovariance);
        const MatrixXd J = byUnknowns(residual, view_, X) - residual.byPoint * pointByUnknowns;
        const double variance = std::pow(problem_.noise.point / seen.inverseSigma, 2);
        const double expected = (J * covariance_ * J.transpose()).trace() +
                                (residual.byPoint * pointCovariance * residual.byPoint.transpose()).trace() +
                                2 * variance;
        const double pixel = cameras_[view_].toCamera(X).z() / state.calibration.camera.K(0, 0); // on the scene
        sums_ += Eigen::Array4d(residual.error.squaredNorm(), expected, residual.error.squaredNorm() * pixel * pixel,
                                expected * pixel * pixel);
        ++count_;
    }

    ViewPrediction rms() const
    {
        const double none = std::numeric_limits<double>::quiet_NaN();
        const Eigen::Array4d rms = count_ ? (sums_ / count_).sqrt() : Eigen::Array4d(Eigen::Array4d::Constant(none));
        return ViewPrediction{rms(0), rms(1), rms(2), rms(3)};
    }

private:
    MatrixXd byUnknowns(const PointResidual& residual, int view, const Vector3d& X) const
    {
        const MatrixXd& B = problem_.unknowns.calibration;
        MatrixXd J = MatrixXd::Zero(2, covariance_.rows());
        J.leftCols(B.cols()) = residual.byCalibration * B.topRows<POINT_COLUMNS>();
        const int column = problem_.unknowns.poseColumn(view);
        if (column >= 0)
        {
            J.middleCols<3>(column) = residual.byPoint * skew(X - cameras_[view].gripper.t);
            J.middleCols<3>(column + 3) = -residual.byPoint;
        }
        return J;
    }

    //! How a scene point that fits its track moves with the unknowns (sign changed), and its covariance at given unknowns.
    MatrixXd followsUnknowns(int track, Matrix3d& pointCovariance) const
    {
        Matrix3d A = Matrix3d::Zero();
        MatrixXd b = MatrixXd::Zero(3, covariance_.rows());
        const SceneTracks& tracks = problem_.tracks;
        const Vector3d& X = problem_.state.points[track];
        for (int i = tracks.first[track]; i < tracks.first[track + 1]; ++i)
        {
            const PointObservation& o = tracks.observations[i];
            PointResidual residual;
            if (!o.used || !residual.linearize(problem_.state.calibration.camera, cameras_[o.view], X, o.pixel))
                continue;
            const double information = std::pow(o.inverseSigma / problem_.noise.point, 2);
            A += information * residual.byPoint.transpose() * residual.byPoint;
            b += information * residual.byPoint.transpose() * byUnknowns(residual, o.view, X);
        }
        pointCovariance = A.inverse();
        return pointCovariance * b;
    }

    const RefineProblem& problem_;
    const int view_;
    const MatrixXd& covariance_;
    const CameraViews cameras_;
    Eigen::Array4d sums_ = Eigen::Array4d::Zero();
    int count_ = 0;
};

} // namespace

//! Of the tested columns and the poses: an error e of the calibration moves the corrected poses by -P^-1 H_pc e.
MatrixXd Verification::covarianceOf(RefineProblem& problem) const
{
    MatrixXd H;
    VectorXd gradient;
    problem.linearize(H, gradient);
    const int f = int(problem.unknowns.calibration.cols()), n = int(H.rows()), poses = n - f;
    MatrixXd T = MatrixXd::Identity(n, f), covariance = MatrixXd::Zero(n, n);
    if (poses > 0)
    {
        const MatrixXd P = inverseOfSymmetric(H.bottomRightCorner(poses, poses));
        T.bottomRows(poses) = -P * H.bottomLeftCorner(poses, f);
        covariance.bottomRightCorner(poses, poses) = P;
    }
    return covariance + T * testedCorrelation() * T.transpose();
}

ViewPrediction Verification::predict(int view) const
{
    SceneTracks others = tracks_;
    for (PointObservation& o : others.observations)
        o.used = o.used && o.view != view;
    StripeSegments noSegments;
    RefineProblem problem(others, noSegments, gripper2base_, problem_.state, verificationHuberThreshold);
    problem.noise = problem_.noise;
    problem.unknowns = problem_.unknowns;
    problem.unknowns.calibration.resize(CALIBRATION_COLUMNS, 0);
    problem.state.gripper2base[view] = gripper2base_[view];
    settle(problem);

    problem.unknowns.calibration = testedColumns();
    const MatrixXd covariance = covarianceOf(problem);
    const bool isDoubted = isMostlyRejected(view);
    PredictionErrors errors(problem, view, covariance);
    for (int track = 0; track < tracks_.count(); ++track)
        for (int i = tracks_.first[track]; others.isUsed(track) && i < tracks_.first[track + 1]; ++i)
        {
            const PointObservation& o = tracks_.observations[i];
            if (o.view == view && (o.used || isDoubted))
                errors.add(track, o);
        }
    return errors.rms();
}

}} // namespace cv::active_handeye
