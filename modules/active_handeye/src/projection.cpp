// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "least_squares.hpp"
#include "decompositions.hpp"
#include "projection.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

typedef Eigen::Matrix<double, 9, PROJECTION_PARAMETERS> ProjectionJacobian;

Matrix3d toMatrix(const Vector9d& p)
{
    return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(p.data());
}

static Vector9d toVector(const Matrix3d& P)
{
    Vector9d p;
    p << P.row(0).transpose(), P.row(1).transpose(), P.row(2).transpose();
    return p;
}

Projection Projection::decompose(const Matrix3d& P)
{
    // P P^T = K K^T up to scale; K is upper triangular with positive diagonal and K(2,2) = 1.
    const Matrix3d C = P * P.transpose() / P.row(2).squaredNorm();
    Projection projection;
    const double cx = C(0, 2), cy = C(1, 2);
    const double fy = std::sqrt(std::max(C(1, 1) - cy * cy, 1e-300));
    const double skew = (C(0, 1) - cx * cy) / fy;
    const double fx = std::sqrt(std::max(C(0, 0) - cx * cx - skew * skew, 1e-300));
    projection.K << fx, skew, cx, 0, fy, cy, 0, 0, 1;
    const double sign = P.determinant() < 0 ? -1 : 1;
    projection.R = nearestRotation(sign * projection.K.inverse() * P / P.row(2).norm()).transpose();
    return projection;
}

Vector9d Projection::vector(const Matrix3d& T, ProjectionJacobian* jacobian) const
{
    const Vector9d p = toVector(T * K * R.transpose());
    const double norm = p.norm();
    const Vector9d unit = p / norm;
    if (!jacobian)
        return unit;
    const int row[5] = {0, 1, 0, 1, 0}, column[5] = {0, 1, 2, 2, 1}; // fx, fy, cx, cy, skew in K
    for (int k = 0; k < 5; ++k)
    {
        Matrix3d dK = Matrix3d::Zero();
        dK(row[k], column[k]) = 1;
        jacobian->col(k) = toVector(T * dK * R.transpose());
    }
    for (int k = 0; k < 3; ++k) // (exp(w) R)^T = R^T exp(-w)
        jacobian->col(5 + k) = toVector(-T * K * R.transpose() * skew(Vector3d::Unit(k)));
    *jacobian = (*jacobian - unit * (unit.transpose() * *jacobian)) / norm;
    return unit;
}

void Projection::apply(const Eigen::Matrix<double, PROJECTION_PARAMETERS, 1>& step)
{
    K(0, 0) += step[0];
    K(1, 1) += step[1];
    K(0, 2) += step[2];
    K(1, 2) += step[3];
    K(0, 1) += step[4];
    R = nearestRotation(expRotation(step.tail<3>()) * R);
}

MatrixXd freeParameters(int flags)
{
    const MatrixXd all = MatrixXd::Identity(PROJECTION_PARAMETERS, PROJECTION_PARAMETERS);
    if (flags & TRANSLATIONS_FIX_K)
        return all.rightCols(3);
    MatrixXd free(PROJECTION_PARAMETERS, 0);
    const auto add = [&free](const VectorXd& direction)
    {
        free.conservativeResize(Eigen::NoChange, free.cols() + 1);
        free.rightCols(1) = direction;
    };
    if (flags & TRANSLATIONS_SQUARE_PIXELS)
        add(all.col(0) + all.col(1));
    else
        add(all.col(0)), add(all.col(1));
    add(all.col(2)), add(all.col(3));
    if (!(flags & (TRANSLATIONS_ZERO_SKEW | TRANSLATIONS_SQUARE_PIXELS)))
        add(all.col(4));
    for (int k = 5; k < 8; ++k)
        add(all.col(k));
    return free;
}

namespace {

class FormProblem : public LeastSquaresProblem
{
public:
    FormProblem(const Matrix9d& S, const Matrix3d& T, const MatrixXd& free, const Projection& start)
        : projection(start), S_(S), T_(T), free_(free)
    {}

    double linearize(MatrixXd& JtJ, VectorXd& Jtr) CV_OVERRIDE
    {
        ProjectionJacobian J;
        const Vector9d p = projection.vector(T_, &J);
        JtJ = free_.transpose() * J.transpose() * S_ * J * free_;
        Jtr = free_.transpose() * J.transpose() * S_ * p;
        return p.dot(S_ * p);
    }

    double costAfter(const VectorXd& step) const CV_OVERRIDE
    {
        Projection moved = projection;
        moved.apply(free_ * step);
        const Vector9d p = moved.vector(T_);
        return p.dot(S_ * p);
    }

    void apply(const VectorXd& step) CV_OVERRIDE { projection.apply(free_ * step); }

    Projection projection;

private:
    const Matrix9d& S_;
    const Matrix3d& T_;
    const MatrixXd& free_;
};

} // namespace

ProjectionSolver::ProjectionSolver(const Normalization& T, const MatrixXd& directions, int flags, const Matrix3d& K)
    : T_(T.matrix()), directions_(directions), flags_(flags), K_(K), free_(freeParameters(flags))
{}

Projection ProjectionSolver::linearStart(const Matrix9d& S) const
{
    // P = M B^T: what the translations do not span stays zero.
    const int r = int(directions_.cols());
    MatrixXd span = MatrixXd::Zero(9, 3 * r);
    for (int row = 0; row < 3; ++row)
        span.block(3 * row, r * row, 3, r) = directions_;
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen = symmetricEigen<MatrixXd>(span.transpose() * S * span);
    const Vector9d p = span * eigen.eigenvectors().col(0);
    const Matrix3d P = T_.inverse() * toMatrix(p);
    Projection start;
    if (!(flags_ & TRANSLATIONS_FIX_K))
        return Projection::decompose(P);
    start.K = K_;
    const Matrix3d C = K_.inverse() * P;
    const bool leftHanded = r == 3 && C.determinant() < 0;
    start.R = nearestRotation(leftHanded ? Matrix3d(-C) : C).transpose();
    return start;
}

Projection ProjectionSolver::minimize(const Matrix9d& S) const
{
    Projection start = linearStart(S);
    if (freeCount() == PROJECTION_PARAMETERS)
        return start;
    if (flags_ & (TRANSLATIONS_ZERO_SKEW | TRANSLATIONS_SQUARE_PIXELS))
        start.K(0, 1) = flags_ & TRANSLATIONS_FIX_K ? K_(0, 1) : 0;
    if ((flags_ & TRANSLATIONS_SQUARE_PIXELS) && !(flags_ & TRANSLATIONS_FIX_K))
        start.K(0, 0) = start.K(1, 1) = std::sqrt(start.K(0, 0) * start.K(1, 1));
    return minimizeFrom(start, S);
}

Projection ProjectionSolver::minimizeFrom(const Projection& start, const Matrix9d& S) const
{
    FormProblem problem(S, T_, free_, start);
    solveLeastSquares(problem);
    return problem.projection;
}

MatrixXd ProjectionSolver::covariance(const Projection& projection, const Matrix9d& S, double sigma) const
{
    FormProblem problem(S, T_, free_, projection);
    MatrixXd JtJ;
    VectorXd Jtr;
    problem.linearize(JtJ, Jtr);
    // Pixels and radians differ by orders of magnitude: scale to a unit diagonal before the inversion.
    const VectorXd scale = JtJ.diagonal().cwiseSqrt().cwiseInverse();
    const MatrixXd scaled = scale.asDiagonal() * JtJ * scale.asDiagonal();
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen = symmetricEigen(scaled);
    const double rounding = 1e-15;
    const MatrixXd root = free_ * scale.asDiagonal() * eigen.eigenvectors() *
                          eigen.eigenvalues().cwiseMax(rounding).cwiseSqrt().cwiseInverse().asDiagonal();
    return sigma * sigma * root * root.transpose();
}

bool ProjectionSolver::mirror(Projection& projection) const
{
    if (directions_.cols() == 3)
        return false;
    const Vector3d normal = Vector3d(directions_.col(0)).cross(Vector3d(directions_.col(1))).normalized();
    projection.R = (2 * normal * normal.transpose() - Matrix3d::Identity()) * projection.R;
    return true;
}

MatrixXd ProjectionSolver::tangent(const Projection& projection) const
{
    ProjectionJacobian jacobian;
    projection.vector(T_, &jacobian);
    return jacobian * free_;
}

}} // namespace cv::active_handeye
