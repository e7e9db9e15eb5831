// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "point_equations.hpp"
#include "residuals.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

//! C += A B^T, column by column: Eigen's products of matrices this small take twice as long.
template <int M, int N>
void addProduct(const Eigen::Matrix<double, M, 2>& A, const Eigen::Matrix<double, N, 2>& B,
                Eigen::Matrix<double, M, N>& C)
{
    for (int j = 0; j < N; ++j)
        C.col(j) += A.col(0) * B(j, 0) + A.col(1) * B(j, 1);
}

//! C += A A^T, upper triangle; the entries below it are not all right.
void addSquare(const CalibrationByPixel& A, Eigen::Matrix<double, POINT_COLUMNS, POINT_COLUMNS>& C)
{
    const int half = POINT_COLUMNS / 2;
    for (int j = 0; j < half; ++j)
        C.col(j).head<half>() += A.col(0).head<half>() * A(j, 0) + A.col(1).head<half>() * A(j, 1);
    for (int j = half; j < POINT_COLUMNS; ++j)
        C.col(j) += A.col(0) * A(j, 0) + A.col(1) * A(j, 1);
}

//! C -= A B^T
template <int M, int N>
void subtractProduct(const Eigen::Matrix<double, M, 3>& A, const Eigen::Matrix<double, N, 3>& B,
                     Eigen::Matrix<double, M, N>& C)
{
    for (int j = 0; j < N; ++j)
        C.col(j) -= A.col(0) * B(j, 0) + A.col(1) * B(j, 1) + A.col(2) * B(j, 2);
}

//! The same for the block of C at (row, column).
void subtractProduct(const Matrix63d& A, const Matrix63d& B, MatrixXd& C, int row, int column)
{
    for (int j = 0; j < 6; ++j)
        C.block<6, 1>(row, column + j) -= A.col(0) * B(j, 0) + A.col(1) * B(j, 1) + A.col(2) * B(j, 2);
}

//! skew(v)^T M
Matrix32d turned(const Vector3d& v, const Matrix32d& M)
{
    Matrix32d result;
    result << M.col(0).cross(v), M.col(1).cross(v);
    return result;
}

} // namespace

AllColumns::AllColumns(const RefineUnknowns& unknowns) : shift(CALIBRATION_COLUMNS - int(unknowns.calibration.cols()))
{
    object = unknowns.object ? unknowns.objectColumn() + shift : -1;
    for (int view = 0; view < int(unknowns.poses.size()); ++view)
        pose.push_back(unknowns.poses[view] == POSE_EXACT ? -1 : unknowns.poseColumn(view) + shift);
    size = unknowns.count() + shift;
}

void PoseTerm::add(const Matrix62d& pose, const CalibrationByPixel& calibration, const Vector2d& error)
{
    addProduct(pose, pose, JtJ);
    addProduct(calibration, pose, byCalibration);
    Jtr += pose * error;
}

void PoseTerm::addTo(DataTerm& term, int column) const
{
    term.JtJ.block<6, 6>(column, column) += JtJ;
    term.JtJ.block<POINT_COLUMNS, 6>(0, column) += byCalibration;
    term.Jtr.segment<6>(column) += Jtr;
}

PointEquations::PointEquations(const SceneTracks& tracks, const CalibrationState& state, const CameraViews& views,
                               const AllColumns& columns, double huberLimit, double meanSlope)
    : tracks_(tracks), state_(state), views_(views), columns_(columns), huberLimit_(huberLimit), meanSlope_(meanSlope),
      poses_(views.size())
{
    term.JtJ.setZero(columns.size, columns.size);
    term.Jtr.setZero(columns.size);
    calibration_.setZero();
    calibrationPull_.setZero();
}

void PointEquations::addTrack(int track)
{
    seenBy_.clear();
    A_.setZero();
    b_.setZero();
    calibrationByPoint_.setZero();
    for (int i = tracks_.first[track]; i < tracks_.first[track + 1]; ++i)
        if (tracks_.observations[i].used)
            addObservation(tracks_.observations[i], track);
    if (!tracks_.isKnown(track))
        eliminatePoint();
}

void PointEquations::addObservation(const PointObservation& o, int track)
{
    const Vector3d& X = state_.points[track];
    const CameraView& view = views_[o.view];
    PointResidual residual;
    if (!residual.linearize(state_.calibration.camera, view, X, o.pixel))
        return;
    const double pull = std::min(1., huberLimit_ / (residual.error.norm() * o.inverseSigma)) / meanSlope_;
    const Vector2d error = o.inverseSigma * pull * residual.error;
    const CalibrationByPixel calibration = o.inverseSigma * residual.byCalibration.transpose();
    const Matrix32d point = o.inverseSigma * residual.byPoint.transpose();
    term.squares += error.squaredNorm();
    term.redundancy += 2;
    addSquare(calibration, calibration_);
    calibrationPull_ += calibration * error;
    Matrix62d pose, object; // a step of the robot's or the object's pose moves the point, seen from the camera
    pose << turned(X - view.gripper.t, point), -point;
    const int column = columns_.pose[o.view];
    if (column >= 0)
        poses_[o.view].add(pose, calibration, error);
    if (tracks_.isKnown(track))
    {
        object << turned(state_.object2base.t - X, point), point;
        object_.add(object, calibration, error);
        if (column >= 0)
            term.JtJ.block<6, 6>(columns_.object, column) += object * pose.transpose();
        return;
    }
    addProduct(point, point, A_);
    b_ += point * error;
    addProduct(calibration, point, calibrationByPoint_);
    if (column >= 0)
        seenBy_.push_back(SeenBy{o.view, column, pose * point.transpose()});
}

//! W A^-1 W^T = (W L^-T) (W L^-T)^T with A = L L^T.
void PointEquations::eliminatePoint()
{
    const Eigen::LLT<Matrix3d> llt(A_);
    Matrix3d inverse = Matrix3d::Identity();
    llt.matrixU().solveInPlace(inverse);
    const Vector3d b = inverse.transpose() * b_;
    const CalibrationByPoint calibration = calibrationByPoint_ * inverse;
    term.redundancy -= 3;
    term.squares -= b.squaredNorm();
    subtractProduct(calibration, calibration, calibration_);
    calibrationPull_ -= calibration * b;
    for (size_t j = 0; j < seenBy_.size(); ++j)
    {
        const Matrix63d W = seenBy_[j].W * inverse;
        seenBy_[j].W = W;
        PoseTerm& pose = poses_[seenBy_[j].view];
        subtractProduct(W, W, pose.JtJ);
        subtractProduct(calibration, W, pose.byCalibration);
        pose.Jtr -= W * b;
        for (size_t i = 0; i < j; ++i)
            subtractProduct(seenBy_[i].W, W, term.JtJ, seenBy_[i].column, seenBy_[j].column);
    }
}

void PointEquations::finish()
{
    term.JtJ.topLeftCorner<POINT_COLUMNS, POINT_COLUMNS>() += calibration_;
    term.Jtr.head<POINT_COLUMNS>() += calibrationPull_;
    for (size_t view = 0; view < poses_.size(); ++view)
        if (columns_.pose[view] >= 0)
            poses_[view].addTo(term, columns_.pose[view]);
    if (columns_.object >= 0)
        object_.addTo(term, columns_.object);
}

}} // namespace cv::active_handeye
