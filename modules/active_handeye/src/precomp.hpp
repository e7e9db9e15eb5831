// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// The only place that knows OpenCV 4 from 5: everything the module needs of OpenCV is in opencv_core, which both have.
#ifndef OPENCV_ACTIVE_HANDEYE_PRECOMP_HPP
#define OPENCV_ACTIVE_HANDEYE_PRECOMP_HPP

#include "opencv2/core.hpp"
#include "opencv2/core/utils/trace.hpp"
#include "opencv2/active_handeye.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <Eigen/StdVector>
#include "eigen_kernels.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace cv { namespace active_handeye {

//! std::vector whose storage respects the alignment Eigen's fixed-size types ask for (C++11 does not do it by itself).
template <typename T>
using AlignedVector = std::vector<T, Eigen::aligned_allocator<T>>;

typedef Eigen::Matrix<double, 9, 1> Vector9d;
typedef Eigen::Matrix<double, 9, 9> Matrix9d;

}} // namespace cv::active_handeye

#endif
