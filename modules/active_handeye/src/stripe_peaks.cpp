// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "stripe_peaks.hpp"

namespace cv { namespace active_handeye {

namespace {

//! Zero-mean box kernel matched to a Gaussian stripe: rows -inner..inner minus the other rows of -outer..outer.
struct BoxKernel
{
    int inner, outer;
    double innerWeight, outerWeight; // score = innerWeight * innerSum - outerWeight * outerSum
    double gain;                     // score of a Gaussian of height 1
    double noiseGain;                // standard deviation of the score of white noise of variance 1

    explicit BoxKernel(double sigma)
        : inner(std::max(1, cvRound(1.4 * sigma))), outer(inner + std::max(3, cvRound(2 * sigma))), gain(0)
    {
        const double innerSize = 2 * inner + 1, surroundSize = 2 * (outer - inner);
        outerWeight = 1 / surroundSize;
        innerWeight = 1 / innerSize + outerWeight;
        noiseGain = std::sqrt(1 / innerSize + 1 / surroundSize);
        for (int i = -outer; i <= outer; ++i)
            gain += std::exp(-0.5 * i * i / (sigma * sigma)) * (std::abs(i) <= inner ? 1 / innerSize : -outerWeight);
    }
};

class PeakSearch
{
public:
    PeakSearch(const StripeFrame& frame, double sigma)
        : frame_(frame), kernel_(sigma), depth_(2 * kernel_.outer + 2), cols_(size_t(frame.cols())),
          ring_(depth_ * cols_), innerSum_(cols_), outerSum_(cols_), score_(cols_)
    {
        peaks_.row.assign(cols_, 0);
        peaks_.height.assign(cols_, 0.f);
        peaks_.second.assign(cols_, 0.f);
    }

    StripePeaks run()
    {
        for (int y = 0; y < frame_.rows(); ++y)
        {
            frame_.signalRow(y, row(y));
            addToSums(y);
            if (y < 2 * kernel_.outer)
                continue;
            const int centre = y - kernel_.outer;
            computeScores();
            updatePeaks(centre);
            if (centre % 4 == 0)
                sampleNoise(centre);
        }
        normalise();
        return peaks_;
    }

private:
    float* row(int y) { return &ring_[size_t(y % depth_) * cols_]; }

    void addToSums(int y)
    {
        add(outerSum_, y, 1.f);
        add(outerSum_, y - 2 * kernel_.outer - 1, -1.f);
        add(innerSum_, y - kernel_.outer + kernel_.inner, 1.f);
        add(innerSum_, y - kernel_.outer - kernel_.inner - 1, -1.f);
    }

    void add(std::vector<float>& sums, int y, float sign)
    {
        if (y < 0)
            return;
        const float* source = row(y);
        float* target = sums.data();
        for (size_t x = 0; x < cols_; ++x)
            target[x] += sign * source[x];
    }

    void computeScores()
    {
        const float a = float(kernel_.innerWeight), b = float(kernel_.outerWeight);
        const float *inner = innerSum_.data(), *outer = outerSum_.data();
        float* score = score_.data();
        for (size_t x = 0; x < cols_; ++x)
            score[x] = a * inner[x] - b * outer[x];
    }

    void updatePeaks(int y)
    {
        const int apart = 2 * kernel_.outer;
        for (size_t x = 0; x < cols_; ++x)
        {
            const float s = score_[x];
            if (s <= peaks_.second[x])
                continue;
            const bool separate = y - peaks_.row[x] > apart;
            if (s > peaks_.height[x])
            {
                if (separate)
                    peaks_.second[x] = peaks_.height[x];
                peaks_.height[x] = s;
                peaks_.row[x] = y;
            }
            else if (separate)
                peaks_.second[x] = s;
        }
    }

    void sampleNoise(int y)
    {
        for (size_t x = size_t(y / 4) % 8; x < cols_; x += 8)
            samples_.push_back(std::abs(score_[x]));
    }

    void normalise()
    {
        const double scale = 1 / (kernel_.gain * frame_.channels());
        for (size_t x = 0; x < cols_; ++x)
        {
            peaks_.height[x] = float(peaks_.height[x] * scale);
            peaks_.second[x] = float(peaks_.second[x] * scale);
        }
        double spread = 0;
        if (!samples_.empty())
        {
            std::nth_element(samples_.begin(), samples_.begin() + samples_.size() / 2, samples_.end());
            spread = samples_[samples_.size() / 2] / 0.6745 / frame_.channels();
        }
        const double rounding = std::sqrt(1. / 12); // of the grey levels
        peaks_.pixelNoise = std::max(spread / kernel_.noiseGain, rounding);
        peaks_.heightNoise = peaks_.pixelNoise * kernel_.noiseGain / kernel_.gain;
    }

    const StripeFrame& frame_;
    const BoxKernel kernel_;
    const int depth_;
    const size_t cols_;
    std::vector<float> ring_, innerSum_, outerSum_, score_, samples_;
    StripePeaks peaks_;
};

} // namespace

StripePeaks findStripePeaks(const StripeFrame& frame, double sigma)
{
    return PeakSearch(frame, sigma).run();
}

}} // namespace cv::active_handeye
