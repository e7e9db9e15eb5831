// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "stripe_search.hpp"

namespace cv { namespace active_handeye {

namespace {

const int largestHalf = 16, mostStrips = 255, mostWindows = 127; // of a strip: their numbers are bytes
const int mostLevels = 4, windowRing = 8;

//! A power of two near 1.4 sigma: a window of twice as many rows sees most of the stripe.
int halfWindow(double sigma)
{
    const int power = cvRound(std::log2(1.4 * sigma));
    return std::max(1, std::min(largestHalf, 1 << std::max(0, power)));
}

struct PlainPixels
{
    typedef int Value;
    const uchar* data;
    size_t step;
    int operator()(int x, int y) const { return data[size_t(y) * step + size_t(x)]; }
};

struct AnyPixels
{
    typedef float Value;
    const StripeFrame& frame;
    float operator()(int x, int y) const { return frame.signal(x, y); }
};

//! Scores of a box kernel at successive rows of a column.
template <class Pixels>
class BoxScores
{
    typedef typename Pixels::Value Value;

public:
    BoxScores(const Pixels& pixels, const BoxKernel& kernel, int x, int y)
        : pixels_(pixels), x_(x), y_(y), inner_(kernel.inner), outer_(kernel.outer),
          ofInner_(1.f / float(2 * kernel.inner + 1)), ofOuter_(0.5f / float(kernel.outer - kernel.inner))
    {
        for (int i = -inner_; i <= inner_; ++i)
            near_ += pixels(x, y + i);
        for (int i = inner_ + 1; i <= outer_; ++i)
            far_ += pixels(x, y - i) + pixels(x, y + i);
    }

    float score() const { return float(near_) * ofInner_ - float(far_) * ofOuter_; }

    void next()
    {
        const Value in = pixels_(x_, y_ + inner_ + 1), out = pixels_(x_, y_ - inner_);
        near_ += in - out;
        far_ += out - in + pixels_(x_, y_ + outer_ + 1) - pixels_(x_, y_ - outer_);
        ++y_;
    }

private:
    const Pixels& pixels_;
    const int x_;
    int y_;
    const int inner_, outer_;
    const float ofInner_, ofOuter_;
    Value near_ = 0, far_ = 0;
};

const uchar* sourceRow(const StripeFrame& frame, int y, uchar*)
{
    return frame.row(y);
}

const float* sourceRow(const StripeFrame& frame, int y, float* out)
{
    frame.signalRow(y, out);
    return out;
}

} // namespace

BoxKernel::BoxKernel(double sigma)
    : inner(std::max(1, cvRound(1.4 * sigma))), outer(inner + std::max(3, cvRound(2 * sigma))), gain(0)
{
    const double innerSize = 2 * inner + 1, outerSize = 2 * (outer - inner);
    noiseGain = std::sqrt(1 / innerSize + 1 / outerSize);
    for (int i = -outer; i <= outer; ++i)
        gain += std::exp(-0.5 * i * i / (sigma * sigma)) * (std::abs(i) <= inner ? 1 / innerSize : -1 / outerSize);
}

//! Mean of `size` rows, a power of two: in `out`, or the row of the image itself.
template <typename T>
const T* StripeSearch::meanRow(const Scan<T>& scan, int first, int size, T* out, int level)
{
    if (size == 1)
        return sourceRow(scan.frame, first, out);
    const int n = scan.frame.cols();
    T* spare = &scan.rows.partial[size_t(2 * level * n)];
    const T *a = meanRow(scan, first, size / 2, spare, level + 1),
            *b = meanRow(scan, first + size / 2, size / 2, spare + n, level + 1);
    scan.kernels.average(n, a, b, out);
    return out;
}

//! Fills best and second with windows and their scores.
template <typename T>
void StripeSearch::findWindows(const StripeFrame& frame, const StripeRowKernels<T>& kernels, Rows<T>& rows, int apart)
{
    const int n = frame.cols(), blocks = frame.rows() / half_, lastWindow = blocks - 4;
    const Scan<T> scan = {frame, kernels, rows};
    rows.partial.resize(size_t(2 * mostLevels * n));
    rows.ring.resize(size_t((2 + windowRing) * n));
    rows.peaks.assign(size_t(8 * n), T(0));
    T *highest = &rows.peaks[0], *which = highest + n, *p = which + n;
    const StripePeakRows<T> peaks = {p, p + n, p + 2 * n, p + 3 * n, p + 4 * n, p + 5 * n};
    const auto window = [&](int i) { return &rows.ring[size_t((2 + i % windowRing) * n)]; };
    const T* previous = nullptr;
    for (int i = 0; i < blocks; ++i)
    {
        const T* block = meanRow(scan, i * half_, half_, &rows.ring[size_t((i % 2) * n)], 0);
        if (i > 0)
            kernels.average(n, previous, block, window(i - 1));
        previous = block;
        const int centre = i - 3, strip = (centre - 2) / windowsOfStrip_,
                  place = (centre - 2) % windowsOfStrip_; // the windows before and after do not overlap it
        if (centre < 2)
            continue;
        kernels.score(n, T(place), window(centre), window(centre - 2), window(centre + 2), highest, which);
        if (place == windowsOfStrip_ - 1 || centre == lastWindow)
            kernels.merge(n, T(strip), T(windowsOfStrip_), T(apart), highest, which, peaks);
    }
    const auto middleRow = [&](T strip, T place)
    { return (int(strip) * windowsOfStrip_ + int(place) + 3) * half_ - 1; };
    for (int x = 0; x < n; ++x)
    {
        best[x] = StripePeak{middleRow(peaks.bestStrip[x], peaks.bestWhich[x]), float(peaks.best[x])};
        second[x] = StripePeak{middleRow(peaks.secondStrip[x], peaks.secondWhich[x]), float(peaks.second[x])};
    }
}

//! The row of the box kernel's highest score in a window, and its height instead of the window's score.
template <class Pixels>
StripePeak StripeSearch::sharpened(const Pixels& pixels, const StripeFrame& frame, const BoxKernel& kernel, int x,
                                   const StripePeak& window) const
{
    const int first = std::max(kernel.outer, window.row - half_);
    const int last = std::min(frame.rows() - 1 - kernel.outer, window.row + half_ + 1);
    StripePeak peak = {-1, 0};
    if (!(window.height > 0) || first > last)
        return peak;
    BoxScores<Pixels> scores(pixels, kernel, x, first);
    for (int y = first; y <= last; ++y)
    {
        if (y > first)
            scores.next(); // not beyond the last: it would read outside of the image
        const float score = scores.score();
        if (score > peak.height)
            peak = StripePeak{y, score};
    }
    peak.height *= float(1 / kernel.gain);
    return peak;
}

template <class Pixels>
void StripeSearch::sharpen(const Pixels& pixels, const StripeFrame& frame, const BoxKernel& kernel)
{
    for (int x = 0; x < frame.cols(); ++x)
    {
        const StripePeak first = best[x], other = second[x];
        best[x] = sharpened(pixels, frame, kernel, x, first);
        second[x] =
            other.height > comparable_ * first.height ? sharpened(pixels, frame, kernel, x, other) : StripePeak{-1, 0};
    }
}

//! Robust, from places spread evenly over the image (the R2 sequence).
template <class Pixels>
void StripeSearch::measureNoise(const Pixels& pixels, const StripeFrame& frame, const BoxKernel& kernel)
{
    const int count = 600, rows = frame.rows() - 2 * kernel.outer;
    double spread = 0;
    samples_.clear();
    double u = 0.5, v = 0.5;
    for (int i = 0; i < count && rows > 0; ++i)
    {
        u += u < 1 - 0.7548776662466927 ? 0.7548776662466927 : 0.7548776662466927 - 1;
        v += v < 1 - 0.5698402909980532 ? 0.5698402909980532 : 0.5698402909980532 - 1;
        const int x = int(u * frame.cols()), y = kernel.outer + int(v * rows);
        samples_.push_back(std::abs(BoxScores<Pixels>(pixels, kernel, x, y).score()));
    }
    if (!samples_.empty())
    {
        std::nth_element(samples_.begin(), samples_.begin() + samples_.size() / 2, samples_.end());
        spread = samples_[samples_.size() / 2] / 0.6745;
    }
    const double rounding = std::sqrt(1. / 12); // of the grey levels
    pixelNoise = std::max(spread / kernel.noiseGain, rounding);
    heightNoise = pixelNoise * kernel.noiseGain / kernel.gain;
}

template <class Pixels>
void StripeSearch::finish(const Pixels& pixels, const StripeFrame& frame, const BoxKernel& kernel)
{
    sharpen(pixels, frame, kernel);
    measureNoise(pixels, frame, kernel);
}

void StripeSearch::run(const StripeFrame& frame, double sigma, double leastSecond)
{
    const BoxKernel kernel(sigma);
    const double windowError = 0.2; // of a window's score, against the kernel's
    comparable_ = float((1 - windowError) * leastSecond);
    half_ = halfWindow(sigma);
    const int apart = (2 * kernel.outer + half_ - 1) / half_, windows = std::max(0, frame.rows() / half_ - 5);
    windowsOfStrip_ = std::max(apart, (windows + mostStrips - 1) / mostStrips);
    best.assign(size_t(frame.cols()), StripePeak{-1, 0});
    second.assign(size_t(frame.cols()), StripePeak{-1, 0});
    if (frame.isPlain() && windowsOfStrip_ <= mostWindows)
        findWindows(frame, stripeKernels().bytes, bytes_, apart);
    else
        findWindows(frame, stripeKernels().floats, floats_, apart);
    if (frame.isPlain())
        finish(PlainPixels{frame.row(0), frame.step()}, frame, kernel);
    else
        finish(AnyPixels{frame}, frame, kernel);
}

}} // namespace cv::active_handeye
