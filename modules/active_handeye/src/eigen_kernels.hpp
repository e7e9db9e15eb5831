// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Eigen's kernels of matrix products, instantiated once, in eigen_kernels.cpp: compiled into every source that multiplies matrices
// they were 29 % of the code of eight that were measured. They are internals of Eigen 3.4; beside another version each source compiles its own.
#ifndef OPENCV_ACTIVE_HANDEYE_EIGEN_KERNELS_HPP
#define OPENCV_ACTIVE_HANDEYE_EIGEN_KERNELS_HPP

#include <Eigen/Core>

#if EIGEN_WORLD_VERSION == 3 && EIGEN_MAJOR_VERSION == 4

// DECLARED: extern, or nothing for the definition.
// NOLINTBEGIN(bugprone-macro-parentheses): a keyword cannot stand in parentheses
#define ACTIVE_HANDEYE_EIGEN_KERNELS(DECLARED)                                                                         \
    DECLARED template struct gebp_kernel<double, double, Index, MatrixOfDoubles, gebp_traits<double, double>::mr,      \
                                         gebp_traits<double, double>::nr, false, false>;                               \
    DECLARED template struct general_matrix_matrix_product<Index, double, ColMajor, false, double, ColMajor, false,    \
                                                           ColMajor, 1>;                                               \
    DECLARED template struct general_matrix_matrix_product<Index, double, RowMajor, false, double, ColMajor, false,    \
                                                           ColMajor, 1>;                                               \
    DECLARED template struct general_matrix_matrix_product<Index, double, ColMajor, false, double, RowMajor, false,    \
                                                           ColMajor, 1>;                                               \
    DECLARED template struct general_matrix_vector_product<Index, double, ColumnsOfDoubles, ColMajor, false, double,   \
                                                           RowsOfDoubles, false, 0>;                                   \
    DECLARED template struct general_matrix_vector_product<Index, double, RowsOfDoubles, RowMajor, false, double,      \
                                                           ColumnsOfDoubles, false, 0>;                                \
    DECLARED template void evaluateProductBlockingSizesHeuristic<double, double, 1, Index>(Index&, Index&, Index&,     \
                                                                                           Index);                     \
    DECLARED template void evaluateProductBlockingSizesHeuristic<double, double, 4, Index>(Index&, Index&, Index&,     \
                                                                                           Index);
// NOLINTEND(bugprone-macro-parentheses)

namespace Eigen { namespace internal {

typedef blas_data_mapper<double, Index, ColMajor, Unaligned, 1> MatrixOfDoubles;
typedef const_blas_data_mapper<double, Index, ColMajor> ColumnsOfDoubles;
typedef const_blas_data_mapper<double, Index, RowMajor> RowsOfDoubles;

ACTIVE_HANDEYE_EIGEN_KERNELS(extern)

}} // namespace Eigen::internal

#endif

#endif
