// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "stripe_kernels.hpp"

namespace cv { namespace active_handeye {

namespace {
#include "stripe_kernels.simd.hpp"
} // namespace

StripeKernels portableStripeKernels()
{
    return allKernels();
}

static StripeKernels choose()
{
#ifdef ACTIVE_HANDEYE_AVX2
    if (checkHardwareSupport(CV_CPU_AVX2) && checkHardwareSupport(CV_CPU_FMA3))
        return stripeKernelsAvx2();
#endif
    return portableStripeKernels();
}

const StripeKernels& stripeKernels()
{
    static const StripeKernels kernels = choose();
    return kernels;
}

}} // namespace cv::active_handeye
