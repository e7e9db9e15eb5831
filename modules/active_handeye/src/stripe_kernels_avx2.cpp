// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Compiled with AVX2 and FMA, where the build defines ACTIVE_HANDEYE_AVX2. Includes nothing with inline functions: the linker could take
// theirs for processors that lack AVX2.
#ifdef ACTIVE_HANDEYE_AVX2
#include "opencv2/core/hal/interface.h"
#include "stripe_kernels.hpp"

namespace cv { namespace active_handeye {

namespace {
#include "stripe_kernels.simd.hpp"
} // namespace

StripeKernels stripeKernelsAvx2()
{
    return allKernels();
}

}} // namespace cv::active_handeye
#endif
