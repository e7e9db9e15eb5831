// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"

#ifdef ACTIVE_HANDEYE_EIGEN_KERNELS

namespace Eigen { namespace internal {

ACTIVE_HANDEYE_EIGEN_KERNELS()

}} // namespace Eigen::internal

#endif
