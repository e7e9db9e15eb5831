// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "input.hpp"
#include "stripe_centre.hpp"
#include "stripe_peaks.hpp"

namespace cv { namespace active_handeye {

StripeParams::StripeParams()
    : orientation(STRIPE_HORIZONTAL), sigma(1.5), minSnr(4.5), minContrast(0.02), maxSecondPeak(0.6), saturation(0),
      minRun(5)
{}

static void requireRange(double value, double low, double high, const char* name)
{
    if (!(value >= low && value <= high)) // also refuses NaN
        CV_Error(Error::StsOutOfRange,
                 cv::format("params.%s: needed a value from %g to %g, given %g", name, low, high, value));
}

static void checkParams(const StripeParams& params)
{
    if (params.orientation != STRIPE_HORIZONTAL && params.orientation != STRIPE_VERTICAL)
        CV_Error(Error::StsBadArg,
                 cv::format("params.orientation: needed STRIPE_HORIZONTAL (0) or STRIPE_VERTICAL (1), given %d",
                            params.orientation));
    requireRange(params.sigma, 0.5, 20, "sigma");
    requireRange(params.minSnr, 1, 1000, "minSnr");
    requireRange(params.minContrast, 0, 1, "minContrast");
    requireRange(params.maxSecondPeak, 0, 1, "maxSecondPeak");
    requireRange(params.saturation, 0, 65535, "saturation");
    requireRange(params.minRun, 1, 1e6, "minRun");
}

namespace {

struct StripePoint
{
    int column;
    double centre, sigma;
    double misfit, height; //!< grey levels
};

double median(std::vector<double>& values)
{
    std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
    return values[values.size() / 2];
}

//! From the peaks of the columns to the centre line.
class StripeDetector
{
public:
    StripeDetector(const StripeFrame& frame, const StripeParams& params)
        : frame_(frame), params_(params), peaks_(findStripePeaks(frame, params.sigma)), width_(params.sigma)
    {}

    std::vector<StripePoint> run()
    {
        findClearColumns();
        width_ = measureWidth();
        std::vector<StripePoint> points;
        points.reserve(clear_.size());
        for (int column : clear_)
        {
            StripeProfile profile;
            if (fitColumn(column, false, profile))
                points.push_back(StripePoint{column, profile.centre, profile.centreSigma, profile.misfit,
                                             profile.height});
        }
        return withoutShortRuns(withoutMisfits(points));
    }

private:
    void findClearColumns()
    {
        const double significant = params_.minSnr * peaks_.heightNoise;
        const double least = std::max(significant, params_.minContrast * frame_.saturation());
        for (int x = 0; x < frame_.cols(); ++x)
            if (peaks_.height[x] >= least &&
                peaks_.second[x] <= std::max(significant, params_.maxSecondPeak * peaks_.height[x]))
                clear_.push_back(x);
    }

    //! Median over a sample of columns; the profile is wider than sigma where the stripe is oblique or out of focus.
    double measureWidth()
    {
        const size_t sampleSize = 100;
        std::vector<double> widths;
        for (size_t i = 0; i < clear_.size(); i += 1 + clear_.size() / sampleSize)
        {
            StripeProfile profile;
            if (fitColumn(clear_[i], true, profile))
                widths.push_back(profile.sigma);
        }
        if (widths.size() < 5)
            return params_.sigma;
        return median(widths);
    }

    bool fitColumn(int x, bool fitSigma, StripeProfile& profile)
    {
        int top = peaks_.row[x], bottom = top;
        if (!growOverPlateau(x, top, bottom))
            return false;
        profile.centre = 0.5 * (top + bottom);
        profile.sigma = width_;
        const int margin = int(std::ceil(3.5 * width_));
        top = std::max(0, top - margin);
        bottom = std::min(frame_.rows() - 1, bottom + margin);
        frame_.window(x, top, bottom, peaks_.pixelNoise, window_);
        if (!fitStripeProfile(window_, peaks_.pixelNoise, fitSigma, profile))
            return false;
        return profile.height >= params_.minContrast * frame_.saturation();
    }

    //! Saturated pixels around the peak; false when they are too many to be a stripe.
    bool growOverPlateau(int x, int& top, int& bottom) const
    {
        const int largest = int(std::ceil(6 * params_.sigma));
        if (!frame_.isSaturated(x, top))
            return true;
        while (top > 0 && bottom - top <= largest && frame_.isSaturated(x, top - 1))
            --top;
        while (bottom < frame_.rows() - 1 && bottom - top <= largest && frame_.isSaturated(x, bottom + 1))
            ++bottom;
        return bottom - top < largest;
    }

    //! Two stripes in one, as at a step, fit worse than the others; how well those fit depends on speckle and texture.
    std::vector<StripePoint> withoutMisfits(const std::vector<StripePoint>& points) const
    {
        if (points.empty())
            return points;
        std::vector<double> ratios;
        for (const StripePoint& point : points)
            ratios.push_back(point.misfit / point.height);
        const double limit = 3 * median(ratios);
        std::vector<StripePoint> kept;
        for (const StripePoint& point : points)
            if (point.misfit <= std::max(2.5 * peaks_.pixelNoise, limit * point.height))
                kept.push_back(point);
        return kept;
    }

    bool areNeighbours(const StripePoint& a, const StripePoint& b) const
    {
        const int columns = b.column - a.column;
        return columns <= 3 && std::abs(b.centre - a.centre) <= columns + 3 * (a.sigma + b.sigma);
    }

    std::vector<StripePoint> withoutShortRuns(const std::vector<StripePoint>& points) const
    {
        std::vector<StripePoint> kept;
        for (size_t begin = 0, end; begin < points.size(); begin = end)
        {
            end = begin + 1;
            while (end < points.size() && areNeighbours(points[end - 1], points[end]))
                ++end;
            if (end - begin >= size_t(params_.minRun))
                kept.insert(kept.end(), points.begin() + begin, points.begin() + end);
        }
        return kept;
    }

    const StripeFrame& frame_;
    const StripeParams& params_;
    const StripePeaks peaks_;
    double width_;
    std::vector<int> clear_;
    StripeWindow window_;
};

} // namespace

void detectStripe(InputArray image, OutputArray stripePoints, OutputArray sigmas, InputArray background,
                  const StripeParams& params)
{
    CV_TRACE_FUNCTION();
    checkParams(params);
    const bool vertical = params.orientation == STRIPE_VERTICAL;
    const StripeFrame frame(image.getMat(), background.getMat(), vertical, params.saturation);
    const std::vector<StripePoint> points = StripeDetector(frame, params).run();
    Eigen::MatrixX2d positions(points.size(), 2);
    Eigen::VectorXd deviations(points.size());
    for (size_t i = 0; i < points.size(); ++i)
    {
        positions(i, vertical ? 1 : 0) = points[i].column;
        positions(i, vertical ? 0 : 1) = points[i].centre;
        deviations(i) = points[i].sigma;
    }
    writeMatrix(positions, stripePoints);
    writeMatrix(deviations, sigmas);
}

}} // namespace cv::active_handeye
