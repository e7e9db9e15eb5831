// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Eigen's solvers that several sources need, instantiated once: each costs the compiler up to ten seconds wherever it is named.
#ifndef OPENCV_ACTIVE_HANDEYE_DECOMPOSITIONS_HPP
#define OPENCV_ACTIVE_HANDEYE_DECOMPOSITIONS_HPP

namespace cv { namespace active_handeye {

//! Eigenvalues of a symmetric matrix, ascending, and its eigenvectors. Matrix: Matrix2d, Matrix3d, MatrixXd.
template <class Matrix>
Eigen::SelfAdjointEigenSolver<Matrix> symmetricEigen(const Matrix& A);

//! A^-1 B for a symmetric A, positive definite or nearly so (LDL^T). Right: VectorXd, MatrixXd.
template <class Right>
Right solveSymmetric(const Eigen::MatrixXd& A, const Right& B);

Eigen::Vector3d solveSymmetric(const Eigen::Matrix3d& A, const Eigen::Vector3d& b);

Eigen::MatrixXd inverseOfSymmetric(const Eigen::MatrixXd& A);

//! x with the least |A x - b| (QR with column pivoting).
Eigen::VectorXd leastSquaresSolution(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

//! Singular values, descending, and the thin U and V.
Eigen::JacobiSVD<Eigen::MatrixXd> thinSVD(const Eigen::MatrixXd& A);

}} // namespace cv::active_handeye

#endif
