// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_STRIPE_CENTRE_HPP
#define OPENCV_ACTIVE_HANDEYE_STRIPE_CENTRE_HPP

#include "stripe_frame.hpp"

namespace cv { namespace active_handeye {

//! signal(y) = albedo(y) (height exp(-(y - centre)^2 / (2 sigma^2)) + offset)
struct StripeProfile
{
    double height, offset, centre, sigma;
    double centreSigma; //!< standard deviation of centre
    double misfit;      //!< RMS residual, grey levels
};

/** Least-squares fit of the profile to the pixels of the window that are valid, started at `start` (centre and sigma).

For constant albedo and no saturation the condition for the centre is sum (y - c) exp(-(y - c)^2 / (2 sigma^2)) signal = 0,
the Gaussian-weighted centroid. Returns false when it does not converge inside the window or the residuals are not
those of one peak.
*/
bool fitStripeProfile(const StripeWindow& window, double pixelNoise, bool fitSigma, StripeProfile& profile);

}} // namespace cv::active_handeye

#endif
