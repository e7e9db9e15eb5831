// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "decompositions.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

template <class Matrix>
Eigen::SelfAdjointEigenSolver<Matrix> symmetricEigen(const Matrix& A)
{
    return Eigen::SelfAdjointEigenSolver<Matrix>(A);
}

template Eigen::SelfAdjointEigenSolver<Matrix2d> symmetricEigen(const Matrix2d& A);
template Eigen::SelfAdjointEigenSolver<Matrix3d> symmetricEigen(const Matrix3d& A);
template Eigen::SelfAdjointEigenSolver<MatrixXd> symmetricEigen(const MatrixXd& A);

template <class Right>
Right solveSymmetric(const MatrixXd& A, const Right& B)
{
    return A.ldlt().solve(B);
}

template VectorXd solveSymmetric(const MatrixXd& A, const VectorXd& b);
template MatrixXd solveSymmetric(const MatrixXd& A, const MatrixXd& B);

Vector3d solveSymmetric(const Matrix3d& A, const Vector3d& b)
{
    return A.ldlt().solve(b);
}

MatrixXd inverseOfSymmetric(const MatrixXd& A)
{
    return solveSymmetric<MatrixXd>(A, MatrixXd::Identity(A.rows(), A.cols()));
}

VectorXd leastSquaresSolution(const MatrixXd& A, const VectorXd& b)
{
    return A.colPivHouseholderQr().solve(b);
}

Eigen::JacobiSVD<MatrixXd> thinSVD(const MatrixXd& A)
{
    return Eigen::JacobiSVD<MatrixXd>(A, Eigen::ComputeThinU | Eigen::ComputeThinV);
}

}} // namespace cv::active_handeye
