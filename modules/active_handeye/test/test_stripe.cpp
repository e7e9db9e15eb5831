// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "point_scene.hpp"
#include <functional>

namespace opencv_test { namespace {

//! A Gaussian stripe with known centres: one per column, y = centre(x).
struct StripeImage
{
    int rows, cols, type;
    double sigma, height, noise, offset;
    std::function<double(int)> centre;
    std::function<double(int, int)> albedo; // (x, y), 1 = white

    StripeImage()
        : rows(240), cols(640), type(CV_8U), sigma(1.5), height(120), noise(0), offset(20),
          centre([](int x) { return 60 + 0.02 * x + 3 * std::sin(0.01 * x); }), albedo([](int, int) { return 1.; })
    {}

    Mat render(bool laser, uint64 seed = 1) const
    {
        RNG rng(seed);
        Mat grey(rows, cols, CV_64F);
        for (int y = 0; y < rows; ++y)
            for (int x = 0; x < cols; ++x)
            {
                const double d = (y - centre(x)) / sigma;
                const double light = offset + (laser ? height * std::exp(-0.5 * d * d) : 0.);
                grey.at<double>(y, x) = albedo(x, y) * light + rng.gaussian(noise);
            }
        Mat image;
        grey.convertTo(image, type);
        return image;
    }

    //! Smallest standard deviation an unbiased estimate of the centre can have.
    double bound() const { return noise / height * std::sqrt(2 * sigma / std::sqrt(CV_PI)); }
};

struct Accuracy
{
    size_t count;
    double bias, rmse, normalisedRmse;
};

Accuracy accuracy(const Mat& points, const Mat& sigmas, const std::function<double(int)>& centre)
{
    Accuracy a = {points.total() / 2, 0, 0, 0};
    for (int i = 0; i < points.rows; ++i)
    {
        const double error = points.at<double>(i, 1) - centre(cvRound(points.at<double>(i, 0)));
        a.bias += error / points.rows;
        a.rmse += error * error / points.rows;
        a.normalisedRmse += std::pow(error / sigmas.at<double>(i, 0), 2) / points.rows;
    }
    a.rmse = std::sqrt(a.rmse);
    a.normalisedRmse = std::sqrt(a.normalisedRmse);
    return a;
}

TEST(ActiveHandEye_detectStripe, NoiseFree16BitIsExact)
{
    StripeImage scene;
    scene.type = CV_16U;
    scene.height = 40000;
    Mat points, sigmas;
    detectStripe(scene.render(true), points, sigmas);
    ASSERT_EQ(640, points.rows);
    ASSERT_EQ(2, points.cols);
    ASSERT_EQ(640, sigmas.rows);
    EXPECT_LE(accuracy(points, sigmas, scene.centre).rmse, 3e-5); // rounding to whole grey levels
}

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
            EXPECT_NEAR(1, a.normalisedRmse, 0.15);
        }
}

TEST(ActiveHandEye_detectStripe, FindsItsWidth)
{
    StripeImage scene;
    scene.sigma = 2.4; // expected: 1.5
    scene.noise = 4;
    Mat points, sigmas;
    detectStripe(scene.render(true), points, sigmas);
    const Accuracy a = accuracy(points, sigmas, scene.centre);
    EXPECT_EQ(640u, a.count);
    EXPECT_LE(a.rmse, 1.2 * scene.bound());
}

TEST(ActiveHandEye_detectStripe, VerticalIsTheTransposedProblem)
{
    StripeImage scene;
    scene.noise = 3;
    const Mat image = scene.render(true);
    Mat points, sigmas, turnedPoints, turnedSigmas;
    detectStripe(image, points, sigmas);
    StripeParams params;
    params.orientation = STRIPE_VERTICAL;
    detectStripe(Mat(image.t()), turnedPoints, turnedSigmas, noArray(), params);
    ASSERT_EQ(points.rows, turnedPoints.rows);
    EXPECT_EQ(0, cv::norm(points.col(0), turnedPoints.col(1), NORM_INF));
    EXPECT_EQ(0, cv::norm(points.col(1), turnedPoints.col(0), NORM_INF));
    EXPECT_EQ(0, cv::norm(sigmas, turnedSigmas, NORM_INF));
}

TEST(ActiveHandEye_detectStripe, ThreeChannelsUseTheirMean)
{
    StripeImage scene;
    scene.noise = 5;
    std::vector<Mat> channels;
    for (uint64 seed = 1; seed <= 3; ++seed)
        channels.push_back(scene.render(true, seed));
    Mat image, points, sigmas;
    cv::merge(channels, image);
    detectStripe(image, points, sigmas);
    const Accuracy a = accuracy(points, sigmas, scene.centre);
    EXPECT_EQ(640u, a.count);
    EXPECT_LE(a.rmse, 1.15 * scene.bound() / std::sqrt(3.));
}

//! Texture with edges along and across the stripe.
double patches(int x, int y)
{
    return ((x / 9 + y / 7) % 2 ? 0.6 : 0.95) * (1 + 0.1 * std::sin(0.7 * x + 0.9 * y));
}

TEST(ActiveHandEye_detectStripe, BackgroundRemovesTheTexture)
{
    StripeImage scene;
    scene.albedo = patches;
    scene.offset = 80;
    scene.height = 120;
    scene.noise = 1;
    const Mat image = scene.render(true, 1), background = scene.render(false, 2);
    Mat points, sigmas, plainPoints, plainSigmas;
    detectStripe(image, points, sigmas, background);
    detectStripe(image, plainPoints, plainSigmas);
    const Accuracy divided = accuracy(points, sigmas, scene.centre),
                   plain = accuracy(plainPoints, plainSigmas, scene.centre);
    EXPECT_GE(divided.count, 630u);
    EXPECT_LE(divided.rmse, 0.04);
    EXPECT_LE(std::abs(divided.bias), 0.005);
    EXPECT_LE(divided.rmse, 0.3 * plain.rmse);
}

TEST(ActiveHandEye_detectStripe, SaturatedPlateauKeepsItsCentre)
{
    StripeImage scene;
    scene.noise = 3;
    scene.height = 900; // clipped at 255: about 5 rows
    Mat points, sigmas;
    detectStripe(scene.render(true), points, sigmas);
    const Accuracy a = accuracy(points, sigmas, scene.centre);
    EXPECT_EQ(640u, a.count);
    EXPECT_LE(a.rmse, 0.06);
    EXPECT_LE(std::abs(a.bias), 0.01);

    scene.type = CV_16U; // 12 bits in 16
    scene.height = 15000;
    scene.noise = 20;
    Mat image = scene.render(true);
    cv::min(image, Scalar::all(4095), image);
    StripeParams params;
    params.saturation = 4095;
    detectStripe(image, points, sigmas, noArray(), params);
    EXPECT_LE(accuracy(points, sigmas, scene.centre).rmse, 0.06);
}

TEST(ActiveHandEye_detectStripe, GapsGiveNoPoints)
{
    StripeImage scene;
    scene.noise = 3;
    scene.albedo = [](int x, int) { return x >= 200 && x < 260 ? 0. : 1.; };
    Mat points, sigmas;
    detectStripe(scene.render(true), points, sigmas);
    EXPECT_EQ(580, points.rows);
    for (int i = 0; i < points.rows; ++i)
        EXPECT_FALSE(points.at<double>(i, 0) >= 200 && points.at<double>(i, 0) < 260);
}

//! A second stripe of this brightness in some columns.
Mat reflectionAt(int begin, int end, double brightness)
{
    StripeImage reflection;
    reflection.centre = [](int) { return 90.; };
    reflection.albedo = [=](int x, int) { return x >= begin && x < end ? brightness : 0.; };
    reflection.offset = 0;
    return reflection.render(true);
}

TEST(ActiveHandEye_detectStripe, OfTwoPeaksTheOneInLineWithItsNeighboursWins)
{
    const StripeImage scene;
    for (double brightness : {0.8, 1.3}) // the reflection is the second peak, or the first
    {
        Mat points, sigmas;
        detectStripe(scene.render(true) + reflectionAt(300, 350, brightness), points, sigmas);
        const Accuracy a = accuracy(points, sigmas, scene.centre);
        EXPECT_EQ(640u, a.count);
        EXPECT_LE(a.rmse, 0.02);
    }
}

TEST(ActiveHandEye_detectStripe, DoublePeaksWithoutNeighboursAtBothSidesAreLeftOut)
{
    const StripeImage scene;
    Mat points, sigmas;
    detectStripe(scene.render(true) + reflectionAt(0, 50, 0.8), points, sigmas);
    const Accuracy a = accuracy(points, sigmas, scene.centre);
    EXPECT_EQ(590u, a.count);
    EXPECT_LE(a.rmse, 0.02);
}

TEST(ActiveHandEye_detectStripe, TwoStripesThatTouchAreLeftOut)
{
    StripeImage scene, step;
    scene.noise = 1;
    step.centre = [&](int x) { return scene.centre(x) + 5; };
    step.albedo = [](int x, int) { return x >= 300 && x < 320 ? 0.9 : 0.; };
    step.offset = 0;
    Mat points, sigmas;
    detectStripe(scene.render(true) + step.render(true), points, sigmas);
    const Accuracy a = accuracy(points, sigmas, scene.centre);
    EXPECT_EQ(620u, a.count);
    EXPECT_LE(a.rmse, 1.2 * scene.bound());
}

TEST(ActiveHandEye_detectStripe, NoStripeGivesNoPoints)
{
    StripeImage scene;
    scene.noise = 10;
    scene.offset = 100;
    Mat points, sigmas;
    detectStripe(scene.render(false, 7), points, sigmas);
    EXPECT_EQ(0u, points.total());
    EXPECT_EQ(0u, sigmas.total());
    detectStripe(Mat(480, 640, CV_8U, Scalar(255)), points, sigmas);
    EXPECT_EQ(0u, points.total());
    detectStripe(Mat(3, 3, CV_8U, Scalar(9)), points, sigmas);
    EXPECT_EQ(0u, points.total());
}

TEST(ActiveHandEye_detectStripe, RefusesWrongInput)
{
    const Mat image = StripeImage().render(true);
    const auto refuse = [](const Mat& laser, const Mat& dark, const StripeParams& params, int code, const string& text)
    {
        Mat points, sigmas;
        expectError([&] { detectStripe(laser, points, sigmas, dark, params); }, code, {text});
    };
    const StripeParams standard;
    refuse(Mat(), Mat(), standard, Error::StsBadArg, "image: is empty");
    refuse(Mat(9, 9, CV_32F), Mat(), standard, Error::StsBadArg, "image: needed 8 or 16 bits");
    refuse(Mat(9, 9, CV_8UC4), Mat(), standard, Error::StsBadArg, "given 9 x 9 pixels, 4 channels");
    refuse(image, Mat(9, 9, CV_8U), standard, Error::StsBadSize, "background: needed the size of image");
    refuse(image, Mat(image.size(), CV_16U), standard, Error::StsBadArg, "background: needed the type of image");
    StripeParams params;
    params.sigma = 0.1;
    refuse(image, Mat(), params, Error::StsOutOfRange, "params.sigma: needed a value from 0.5 to 20, given 0.1");
    params = StripeParams();
    params.minSnr = std::numeric_limits<double>::quiet_NaN();
    refuse(image, Mat(), params, Error::StsOutOfRange, "params.minSnr");
    params = StripeParams();
    params.orientation = 5;
    refuse(image, Mat(), params, Error::StsBadArg, "params.orientation");
}

}} // namespace opencv_test
