// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "stripe_residuals.hpp"

namespace cv { namespace active_handeye {

double medianOf(std::vector<double>& values)
{
    std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
    return values[values.size() / 2];
}

//! The pixels of a column that count.
void StripeResiduals::collect(const StripeFit& fit, int lane, bool isAny)
{
    const double height = fit.height[lane], dark = isAny ? fit.background[lane] : 0;
    const int middle = fit.taps / 2;
    double n = 0, g1 = 0, gg = 0, qq = 0;
    residuals_.clear();
    for (int i = 0; i < fit.taps; ++i)
    {
        const int at = i * FIT_LANES + lane;
        if (isAny && fit.weight[at] == 0)
            continue;
        const double apart = double(i - middle) - double(fit.centre[lane]), albedo = isAny ? fit.albedo[at] : 1;
        const double g = std::exp(-0.5 * apart * apart * fit.inverseVariance), q = g * apart;
        const double gain = dark > 0 ? 1 + height * g / dark : 1, variance = 0.5 * (1 + gain * gain);
        const double residual = fit.signal[at] - albedo * (height * g + fit.offset[lane]);
        residuals_.push_back(Residual{g, albedo * height * g / std::sqrt(variance), residual * residual / variance, q});
        n += 1;
        g1 += g;
        gg += g * g;
        qq += q * q;
    }
    for (Residual& r : residuals_) // leverages of centre, height and offset
    {
        const double ofCentre = r.expected * r.expected / qq, g = r.profile;
        r.expected = 1 - ofCentre - (n * g * g - 2 * g1 * g + gg) / (n * gg - g1 * g1);
    }
}

//! What the residuals of one column say of noise and grain.
StripeResiduals::Column StripeResiduals::sums() const
{
    double flank = 0, flankExpected = 0, peak = 0, peakExpected = 0, power = 0;
    for (const Residual& r : residuals_)
    {
        const double beside = (1 - r.profile) * (1 - r.profile), square = r.light * r.light;
        flank += beside * r.square;
        flankExpected += beside * r.expected;
        peak += square * r.square;
        peakExpected += square * r.expected;
        power += square * square;
    }
    return Column{flank / flankExpected, peak / power, peakExpected / power};
}

/** Grain is wider than a pixel: it averages less than white noise, and the fitted profile follows much of it, so that residuals show only
a part of what moves the centre: between a half and a tenth for grain of 0.7 px and stripes of 4 to 1 px.
*/
double StripeResiduals::grain(const StripeFit& fit, int lanes, bool isAny)
{
    const double shown = 0.2, least = 0.3; // of the noise's variance, at the peak
    columns_.clear();
    values_.clear();
    heights_.clear();
    for (int lane = 0; lane < lanes; ++lane)
        if (fit.failed[lane] == 0)
        {
            collect(fit, lane, isAny);
            columns_.push_back(sums());
            values_.push_back(columns_.back().flank);
            heights_.push_back(fit.height[lane]);
        }
    if (columns_.empty())
        return 0;
    const double rounding = 1. / 12, variance = std::max(rounding, medianOf(values_)), height = medianOf(heights_);
    for (size_t i = 0; i < columns_.size(); ++i)
        values_[i] = columns_[i].peak - variance * columns_[i].peakExpected;
    const double grain = medianOf(values_) / (shown * variance);
    return grain * height * height > least ? grain : 0;
}

}} // namespace cv::active_handeye
