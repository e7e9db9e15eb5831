// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "stripe_fitter.hpp"

namespace cv { namespace active_handeye {

//! Rows of a window to each side of the peak.
static int marginOf(double sigma)
{
    return int(std::ceil(3.5 * sigma));
}

void StripeFitter::begin(const StripeFrame& frame, double pixelNoise, double expectedSigma)
{
    frame_ = &frame;
    pixelNoise_ = pixelNoise;
    expectedSigma_ = expectedSigma;
    grain_ = 0;
    if (!fit_)
        fit_.reset(new StripeFit());
}

//! Saturated pixels around the peak; false when they are too many to be a stripe.
bool StripeFitter::growOverPlateau(int x, Rows& rows) const
{
    const int longest = int(std::ceil(6 * expectedSigma_));
    if (!frame_->isSaturated(x, rows.top))
        return true;
    while (rows.top > 0 && rows.bottom - rows.top <= longest && frame_->isSaturated(x, rows.top - 1))
        --rows.top;
    while (rows.bottom < frame_->rows() - 1 && rows.bottom - rows.top <= longest &&
           frame_->isSaturated(x, rows.bottom + 1))
        ++rows.bottom;
    return rows.bottom - rows.top < longest;
}

//! False where a window leaves the image or holds a saturated pixel.
bool StripeFitter::loadPlain(const StripeStart* starts, int count, int margin)
{
    const size_t step = frame_->step();
    const int taps = 2 * margin + 1;
    fit_->taps = taps;
    for (int lane = 0; lane < count; ++lane)
    {
        const int top = starts[lane].row - margin;
        if (top < 0 || top + taps > frame_->rows())
            return false;
        const uchar* pixel = frame_->row(top) + starts[lane].column;
        float* signal = fit_->signal + lane;
        int largest = 0;
        for (int i = 0; i < taps; ++i, pixel += step, signal += FIT_LANES)
        {
            const int value = *pixel;
            *signal = float(value);
            largest = std::max(largest, value);
        }
        if (largest >= frame_->saturation())
            return false;
        middle_[lane] = starts[lane].row;
        isLoaded_[lane] = 1;
    }
    return true;
}

void StripeFitter::loadColumn(int lane, int x, const Rows& rows, int first)
{
    for (int i = 0; i < fit_->taps; ++i)
    {
        const int y = first + i, at = i * FIT_LANES + lane;
        const bool isInside = y >= rows.top && y <= rows.bottom;
        fit_->signal[at] = isInside ? frame_->signal(x, y) : 0.f;
        fit_->weight[at] = isInside && !frame_->isSaturated(x, y) ? 1.f : 0.f;
        fit_->albedo[at] = isInside && frame_->hasBackground() ? frame_->background(x, y) : 1.f;
    }
    fit_->background[lane] = 0;
    if (frame_->hasBackground())
        normaliseAlbedo(lane, rows.top - first, rows.bottom - first);
}

//! Background -> albedo relative to its mean, with as much contrast as stands out of the noise.
void StripeFitter::normaliseAlbedo(int lane, int first, int last)
{
    const double noise = pixelNoise_ / std::sqrt(2.), darkest = 0.05, size = last - first + 1;
    double mean = 0, variance = 0;
    for (int i = first; i <= last; ++i)
        mean += fit_->albedo[i * FIT_LANES + lane] / size;
    for (int i = first; i <= last; ++i)
        variance += std::pow(fit_->albedo[i * FIT_LANES + lane] - mean, 2) / size;
    const double contrast =
        mean > 3 * noise ? std::max(0., 1 - 1.5 * noise * noise / std::max(variance, noise * noise)) : 0;
    for (int i = first; i <= last; ++i)
    {
        float& albedo = fit_->albedo[i * FIT_LANES + lane];
        albedo = contrast > 0 ? float(std::max(darkest, 1 + contrast * (albedo / mean - 1))) : 1.f;
    }
    fit_->background[lane] = contrast > 0 ? float(mean) : 0.f;
}

void StripeFitter::loadWeighted(const StripeStart* starts, int count, int margin)
{
    Rows windows[FIT_LANES];
    int half = margin;
    for (int lane = 0; lane < count; ++lane)
    {
        Rows rows = {starts[lane].row, starts[lane].row};
        isLoaded_[lane] = growOverPlateau(starts[lane].column, rows) ? 1.f : 0.f;
        middle_[lane] = (rows.top + rows.bottom) / 2;
        half = std::max(half, margin + (rows.bottom - rows.top + 1) / 2);
        windows[lane] = Rows{std::max(0, rows.top - margin), std::min(frame_->rows() - 1, rows.bottom + margin)};
    }
    fit_->taps = 2 * half + 1;
    CV_Assert(fit_->taps <= FIT_MAX_TAPS);
    for (int lane = 0; lane < count; ++lane)
        loadColumn(lane, starts[lane].column, windows[lane], middle_[lane] - half);
}

void StripeFitter::load(const StripeStart* starts, int count, int margin)
{
    isPlain_ = frame_->isPlain() && loadPlain(starts, count, margin);
    if (!isPlain_)
        loadWeighted(starts, count, margin);
    std::fill(isLoaded_ + count, isLoaded_ + FIT_LANES, 0.f);
    std::fill(fit_->failed, fit_->failed + FIT_LANES, 1.f); // nothing to begin with
}

PixelModel StripeFitter::model() const
{
    return !isPlain_ ? PIXELS_ANY : grain_ > 0 ? PIXELS_GRAINY : PIXELS_EQUAL;
}

void StripeFitter::solve(double sigma)
{
    StripeFit& fit = *fit_;
    const int middle = fit.taps / 2, maxIterations = 30;
    for (int i = 0; i < fit.taps; ++i)
        fit.gauss[i] = float(std::exp(-0.5 * (i - middle) * (i - middle) / (sigma * sigma)));
    fit.inverseVariance = float(1 / (sigma * sigma));
    fit.largestStep = float(sigma);
    fit.pixelNoise = float(pixelNoise_);
    fit.grain = float(grain_);
    for (int lane = 0; lane < FIT_LANES; ++lane)
    {
        if (fit.failed[lane] != 0)
            fit.centre[lane] = fit.height[lane] = 0;
        fit.failed[lane] = 1 - isLoaded_[lane];
    }
    const StripeKernels& kernels = stripeKernels();
    float move = 2;
    for (int i = 0; i < maxIterations && move > 1; ++i)
    {
        kernels.fit[model()](fit);
        move = *std::max_element(fit.move, fit.move + FIT_LANES);
    }
    for (int lane = 0; lane < FIT_LANES; ++lane)
        if (fit.move[lane] > 1)
            fit.failed[lane] = 1;
    kernels.assess[model()](fit);
}

//! The width at the bottom of the parabola through the smallest of the squares and its neighbours; negative where no width fits.
static double bestWidth(const double* squares, double smallest, double ratio, int count)
{
    const int k = int(std::min_element(squares, squares + count) - squares);
    if (!std::isfinite(squares[k]))
        return -1;
    const double before = k > 0 ? squares[k - 1] - squares[k] : 0,
                 after = k < count - 1 ? squares[k + 1] - squares[k] : 0;
    if (k == 0 || k == count - 1 || !(before + after > 0) || !std::isfinite(before + after))
        return smallest * std::pow(ratio, k);
    return smallest * std::pow(ratio, k + 0.5 * (before - after) / (before + after));
}

//! Of the widths that explain the loaded columns best, tried at smallest, smallest * ratio, ...
double StripeFitter::medianWidth(int lanes, double smallest, double ratio, int count)
{
    squares_.assign(size_t(lanes * count), std::numeric_limits<double>::infinity());
    for (int k = 0; k < count; ++k)
    {
        solve(smallest * std::pow(ratio, k));
        for (int lane = 0; lane < lanes; ++lane)
            if (fit_->failed[lane] == 0)
                squares_[size_t(lane * count + k)] = fit_->squares[lane];
    }
    widths_.clear();
    for (int lane = 0; lane < lanes; ++lane)
    {
        const double width = bestWidth(&squares_[size_t(lane * count)], smallest, ratio, count);
        if (width > 0)
            widths_.push_back(width);
    }
    const size_t fewest = 5;
    if (widths_.size() < fewest)
        return expectedSigma_;
    return medianOf(widths_);
}

//! Starts spread evenly over all; their number.
int StripeFitter::loadSample(const std::vector<StripeStart>& starts, double sigma)
{
    StripeStart sample[FIT_LANES];
    const int count = int(std::min(starts.size(), size_t(FIT_LANES)));
    for (int i = 0; i < count; ++i)
        sample[i] = starts[starts.size() * size_t(i) / size_t(count)];
    load(sample, count, marginOf(sigma));
    return count;
}

double StripeFitter::measureWidth(const std::vector<StripeStart>& starts)
{
    const int count = loadSample(starts, expectedSigma_);
    if (count == 0)
        return expectedSigma_;
    const double coarse = std::sqrt(2.), fine = 1.1;
    const double rough = medianWidth(count, 0.5 * expectedSigma_, coarse, 5); // half to twice
    const double width = medianWidth(count, rough / fine, fine, 3);
    return std::max(0.5 * expectedSigma_, std::min(2 * expectedSigma_, width));
}

void StripeFitter::measureGrain(const std::vector<StripeStart>& starts, double sigma)
{
    int count = int(std::min(starts.size(), size_t(FIT_LANES)));
    if (marginOf(sigma) > fit_->taps / 2) // wider than was loaded to measure the width
        count = loadSample(starts, sigma);
    solve(sigma);
    grain_ = residuals_.grain(*fit_, count, !isPlain_);
}

void StripeFitter::append(const StripeStart* starts, int count, double sigma, std::vector<StripePoint>& points) const
{
    const double priorFreedom = 12; // the residuals are few: held by the noise of the image
    const StripeFit& fit = *fit_;
    for (int lane = 0; lane < count; ++lane)
    {
        const double freedom = fit.pixels[lane] - 3, squares = fit.squares[lane], height = fit.height[lane];
        if (fit.failed[lane] != 0 || freedom < 1)
            continue;
        const double variance = (squares + priorFreedom * pixelNoise_ * pixelNoise_) / (freedom + priorFreedom);
        const double square = variance / fit.information[lane], misfit = squares / freedom;
        const bool isObserved = square > 0 && square < sigma * sigma; // also false for NaN
        if (isObserved && misfit <= std::max(16 * pixelNoise_ * pixelNoise_, 0.04 * height * height))
            points.push_back(StripePoint{starts[lane].column, double(middle_[lane]) + fit.centre[lane],
                                         std::sqrt(square), height, misfit});
    }
}

void StripeFitter::fit(const std::vector<StripeStart>& starts, double sigma, std::vector<StripePoint>& points)
{
    for (size_t first = 0; first < starts.size(); first += FIT_LANES)
    {
        const int count = int(std::min(starts.size() - first, size_t(FIT_LANES)));
        load(&starts[first], count, marginOf(sigma));
        solve(sigma);
        append(&starts[first], count, sigma, points);
    }
}

}} // namespace cv::active_handeye
