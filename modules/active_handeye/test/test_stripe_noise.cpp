// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "stripe_image.hpp"

namespace opencv_test { namespace {

TEST(ActiveHandEye_detectStripe, ReachesCramerRaoBound)
{
    for (double sigma : {1.0, 1.5, 2.5, 4.0})
        for (double snr : {6.0, 10.0, 20.0, 50.0})
        {
            SCOPED_TRACE(cv::format("sigma=%g snr=%g", sigma, snr));
            StripeImage scene;
            scene.type = CV_16U;
            scene.cols = 2000;
            scene.sigma = sigma;
            scene.centre = [](int x) { return 50.3 + 0.01 * x; };
            scene.offset = 3000;
            scene.height = 10000;
            scene.noise = scene.height / snr;
            scene.offset = 10 * scene.noise;
            StripeParams params;
            params.sigma = sigma;
            Mat points, sigmas;
            detectStripe(scene.render(true), points, sigmas, noArray(), params);
            const Accuracy a = accuracy(points, sigmas, scene.centre);
            EXPECT_GE(a.count, snr < 8 ? 1700u : 1960u);
            EXPECT_LE(a.rmse, 1.15 * scene.bound());
            EXPECT_LE(std::abs(a.bias), std::max(0.01, 4 * scene.bound() / std::sqrt(double(a.count))));
            EXPECT_NEAR(1, a.normalisedRmse, 0.08);
        }
}

//! With the laser's grain, all columns of some images: errors, and errors in units of the stated standard deviations.
Accuracy accuracyWithGrain(double sigma)
{
    Accuracy sum = {0, 0, 0, 0};
    const int images = 4;
    for (uint64 seed = 1; seed <= images; ++seed)
    {
        StripeImage scene;
        scene.cols = 1920;
        scene.sigma = sigma;
        scene.noise = 3;
        scene.grain = 0.06;
        StripeParams params;
        params.sigma = sigma;
        Mat points, sigmas;
        detectStripe(scene.render(true, seed), points, sigmas, noArray(), params);
        const Accuracy a = accuracy(points, sigmas, scene.centre);
        sum.count += a.count;
        sum.rmse += a.rmse * a.rmse / images;
        sum.normalisedRmse += a.normalisedRmse * a.normalisedRmse / images;
    }
    sum.rmse = std::sqrt(sum.rmse);
    sum.normalisedRmse = std::sqrt(sum.normalisedRmse);
    return sum;
}

//! Bounds: Cramer-Rao for noise whose covariance is that of noise and grain together, as benchmark/stripe_centre.py computes them.
TEST(ActiveHandEye_detectStripe, GrainOfTheLightIsWeighedByItsVariance)
{
    const double widths[] = {1.5, 2.5, 4.0}, bounds[] = {0.0571, 0.0779, 0.1006},
                 equalWeights[] = {0.0646, 0.0946, 0.126};
    for (int i = 0; i < 3; ++i)
    {
        SCOPED_TRACE(cv::format("sigma=%g", widths[i]));
        const Accuracy a = accuracyWithGrain(widths[i]);
        EXPECT_GE(a.count, 7600u);
        EXPECT_LE(a.rmse, 1.06 * bounds[i]);
        EXPECT_LE(a.rmse, 0.95 * equalWeights[i]);
    }
}

TEST(ActiveHandEye_detectStripe, SigmasHoldWithAndWithoutGrain)
{
    for (double sigma : {1.0, 1.5, 2.5, 4.0})
    {
        SCOPED_TRACE(cv::format("sigma=%g", sigma));
        EXPECT_NEAR(1, accuracyWithGrain(sigma).normalisedRmse, 0.1);
    }
}

TEST(ActiveHandEye_detectStripe, BentStripesHaveTheSigmasOfStraightOnes)
{
    StripeImage straight, bent;
    straight.noise = bent.noise = 3;
    straight.centre = [](int) { return 120.; };
    bent.centre = [](int x) { return 60 + 0.001 * (x - 320) * (x - 320); };
    Mat points, straightSigmas, bentSigmas;
    detectStripe(straight.render(true), points, straightSigmas);
    detectStripe(bent.render(true), points, bentSigmas);
    EXPECT_NEAR(1, cv::mean(bentSigmas)[0] / cv::mean(straightSigmas)[0], 0.1);
}

}} // namespace opencv_test
