// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_STRIPE_RESIDUALS_HPP
#define OPENCV_ACTIVE_HANDEYE_STRIPE_RESIDUALS_HPP

#include "stripe_kernels.hpp"

namespace cv { namespace active_handeye {

//! Of at least one value; changes their order.
double medianOf(std::vector<double>& values);

//! What the residuals of fitted columns say of the light's grain: speckle, and texture where there is no background.
class StripeResiduals
{
public:
    /** StripeFit::grain that suits columns fitted with equal pixels; 0 where the grain is lost in the noise.

    isAny: weight, albedo and background of the fit are set.
    */
    double grain(const StripeFit& fit, int lanes, bool isAny);

private:
    struct Residual
    {
        double profile;  //!< 1 at the peak
        double light;    //!< grey levels, in units of the deviation that a background adds
        double square;   //!< of the residual, in the same units
        double expected; //!< what a fit leaves of it where the noise is white and of variance 1
    };

    struct Column
    {
        double flank;              //!< variance of the noise beside the peak
        double peak, peakExpected; //!< squared contrast of the light, and of noise of variance 1, under the peak
    };

    void collect(const StripeFit& fit, int lane, bool isAny);
    Column sums() const;

    std::vector<Residual> residuals_;
    std::vector<Column> columns_;
    std::vector<double> values_, heights_;
};

}} // namespace cv::active_handeye

#endif
