// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// The kernels that this processor runs, against those for every processor and against the formulas.
#include "../src/precomp.hpp"
#include "../src/stripe_kernels.hpp"

#include <gtest/gtest.h>
#include <memory>

namespace opencv_test { namespace {

using namespace cv;
using namespace cv::active_handeye;

const PixelModel models[] = {PIXELS_EQUAL, PIXELS_GRAINY, PIXELS_ANY};

struct NoisyFit
{
    std::unique_ptr<StripeFit> fit{new StripeFit()};
    std::vector<double> centres;

    NoisyFit(double sigma, double noise, PixelModel model)
    {
        const bool isWeighted = model == PIXELS_ANY;
        RNG rng(3);
        StripeFit& f = *fit;
        const int middle = int(std::ceil(3.5 * sigma));
        f.taps = 2 * middle + 1;
        f.inverseVariance = float(1 / (sigma * sigma));
        f.largestStep = float(sigma);
        f.pixelNoise = float(noise);
        f.grain = 1e-3f;
        for (int i = 0; i < f.taps; ++i)
            f.gauss[i] = float(std::exp(-0.5 * (i - middle) * (i - middle) / (sigma * sigma)));
        for (int x = 0; x < FIT_LANES; ++x)
        {
            centres.push_back(rng.uniform(-0.8, 0.8));
            f.background[x] = isWeighted && x % 2 ? 60.f : 0.f;
            f.centre[x] = f.height[x] = f.failed[x] = 0;
            for (int i = 0; i < f.taps; ++i)
            {
                const double d = (i - middle - centres[x]) / sigma;
                const double albedo = isWeighted ? 1 + 0.3 * std::sin(i + x) : 1;
                f.weight[i * FIT_LANES + x] = isWeighted && (i + x) % 7 == 0 ? 0.f : 1.f;
                f.albedo[i * FIT_LANES + x] = float(albedo);
                f.signal[i * FIT_LANES + x] = float(albedo * (20 + 100 * std::exp(-0.5 * d * d)) + rng.gaussian(noise));
            }
        }
    }

    void run(const StripeKernels& kernels, PixelModel model)
    {
        for (int i = 0; i < 10; ++i)
            kernels.fit[model](*fit);
        kernels.assess[model](*fit);
    }
};

TEST(ActiveHandEye_stripeKernels, exact_profiles_give_their_centre_height_and_offset)
{
    for (double sigma : {0.5, 1.5, 6., 40.})
        for (PixelModel model : models)
        {
            if (model == PIXELS_ANY && sigma < 1)
                continue; // too few pixels without those that do not count
            SCOPED_TRACE(cv::format("sigma=%g model=%d", sigma, int(model)));
            NoisyFit columns(sigma, 1e-9, model);
            columns.fit->pixelNoise = 1;
            columns.run(stripeKernels(), model);
            for (int x = 0; x < FIT_LANES; ++x)
            {
                ASSERT_EQ(0, columns.fit->failed[x]);
                EXPECT_NEAR(columns.centres[x], columns.fit->centre[x], 2e-5 * sigma);
                EXPECT_NEAR(100, columns.fit->height[x], 1e-3);
                EXPECT_NEAR(20, columns.fit->offset[x], 1e-3);
            }
        }
}

TEST(ActiveHandEye_stripeKernels, this_processors_and_the_portable_ones_agree)
{
    for (PixelModel model : models)
    {
        NoisyFit fast(1.5, 8, model), portable(1.5, 8, model);
        fast.run(stripeKernels(), model);
        portable.run(portableStripeKernels(), model);
        for (int x = 0; x < FIT_LANES; ++x)
        {
            EXPECT_EQ(portable.fit->failed[x], fast.fit->failed[x]);
            EXPECT_NEAR(portable.fit->centre[x], fast.fit->centre[x], 1e-5);
            EXPECT_NEAR(portable.fit->squares[x], fast.fit->squares[x], 1e-3 * portable.fit->squares[x]);
            EXPECT_NEAR(portable.fit->information[x], fast.fit->information[x], 1e-3 * portable.fit->information[x]);
        }
    }
}

//! Peaks of random rows: the kernels against a search of each column by itself.
template <typename T>
void expectPeaks(const StripeRowKernels<T>& kernels)
{
    const int n = 75, windows = 5, strips = 40, apart = 4;
    RNG rng(11);
    std::vector<T> rows[6], highest(n, T(0)), which(n, T(0));
    for (std::vector<T>& row : rows)
        row.assign(n, T(0));
    const StripePeakRows<T> peaks = {&rows[0][0], &rows[1][0], &rows[2][0], &rows[3][0], &rows[4][0], &rows[5][0]};
    std::vector<std::vector<int>> scores(n);
    for (int strip = 0; strip < strips; ++strip)
    {
        for (int window = 0; window < windows; ++window)
        {
            std::vector<T> centre(n), before(n), after(n);
            for (int x = 0; x < n; ++x)
            {
                centre[x] = T(rng.uniform(0, 256));
                before[x] = after[x] = T(rng.uniform(0, 256));
                scores[x].push_back(std::max(0, int(centre[x]) - int(before[x])));
            }
            kernels.score(n, T(window), &centre[0], &before[0], &after[0], &highest[0], &which[0]);
        }
        kernels.merge(n, T(strip), T(windows), T(apart), &highest[0], &which[0], peaks);
    }
    for (int x = 0; x < n; ++x)
    {
        const int best = int(*std::max_element(scores[x].begin(), scores[x].end()));
        const int place = int(peaks.bestStrip[x]) * windows + int(peaks.bestWhich[x]);
        const int secondPlace = int(peaks.secondStrip[x]) * windows + int(peaks.secondWhich[x]);
        EXPECT_EQ(best, int(peaks.best[x]));
        EXPECT_EQ(best, scores[x][place]);
        EXPECT_EQ(int(peaks.second[x]), scores[x][secondPlace]);
        EXPECT_GT(std::abs(place - secondPlace), apart);
        EXPECT_GE(int(peaks.second[x]), 150) << "of 200 windows";
    }
}

TEST(ActiveHandEye_stripeKernels, best_and_second_peak_of_random_rows)
{
    expectPeaks(stripeKernels().bytes);
    expectPeaks(stripeKernels().floats);
    expectPeaks(portableStripeKernels().bytes);
    expectPeaks(portableStripeKernels().floats);
}

}} // namespace opencv_test
