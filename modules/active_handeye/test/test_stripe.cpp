// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "stripe_image.hpp"

namespace opencv_test { namespace {

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

//! The result inside is that of the cropped image, moved.
void expectRoiIsCropped(const Mat& image, const Mat& background, int orientation)
{
    StripeParams params;
    params.orientation = orientation;
    params.roi = orientation == STRIPE_HORIZONTAL ? Rect(100, 30, 400, 150) : Rect(30, 100, 150, 400);
    Mat points, sigmas, cropped, croppedSigmas;
    detectStripe(image, points, sigmas, background, params);
    const Mat part = image(params.roi).clone(), dark = background.empty() ? Mat() : background(params.roi).clone();
    const Point2d corner = params.roi.tl();
    params.roi = Rect();
    detectStripe(part, cropped, croppedSigmas, dark, params);
    ASSERT_EQ(400, points.rows);
    ASSERT_EQ(points.rows, cropped.rows);
    cropped.col(0) += corner.x;
    cropped.col(1) += corner.y;
    EXPECT_EQ(0, cv::norm(points, cropped, NORM_INF));
    EXPECT_EQ(0, cv::norm(sigmas, croppedSigmas, NORM_INF));
}

TEST(ActiveHandEye_detectStripe, RoiEqualsTheCroppedImage)
{
    StripeImage scene;
    scene.noise = 3;
    const Mat image = scene.render(true, 1), background = scene.render(false, 2);
    for (const Mat& dark : {Mat(), background})
    {
        expectRoiIsCropped(image, dark, STRIPE_HORIZONTAL);
        expectRoiIsCropped(Mat(image.t()), dark.empty() ? Mat() : Mat(dark.t()), STRIPE_VERTICAL);
    }
}

TEST(ActiveHandEye_detectStripe, RoiWithoutTheStripeGivesNoPoints)
{
    StripeImage scene;
    scene.noise = 3;
    StripeParams params;
    params.roi = Rect(0, 140, 640, 100);
    Mat points, sigmas;
    detectStripe(scene.render(true), points, sigmas, noArray(), params);
    EXPECT_EQ(0, points.rows);
}

TEST(ActiveHandEye_detectStripe, ImagesWithGapsBetweenTheirRowsAreReadAsTheyAre)
{
    for (int type : {CV_8U, CV_16U})
    {
        StripeImage scene;
        scene.noise = 3;
        scene.type = type;
        const Mat image = scene.render(true);
        Mat wide(image.rows + 20, image.cols + 37, type, Scalar(200)), points, sigmas, widePoints, wideSigmas;
        Mat inside = wide(Rect(17, 11, image.cols, image.rows));
        image.copyTo(inside);
        StripeParams params;
        params.saturation = 255;
        detectStripe(image, points, sigmas, noArray(), params);
        detectStripe(inside, widePoints, wideSigmas, noArray(), params);
        EXPECT_EQ(640, points.rows);
        EXPECT_EQ(0, cv::norm(points, widePoints, NORM_INF));
        EXPECT_EQ(0, cv::norm(sigmas, wideSigmas, NORM_INF));
    }
}

TEST(ActiveHandEye_detectStripe, VectorsAsOutputsHoldTheSame)
{
    StripeImage scene;
    scene.noise = 3;
    const Mat image = scene.render(true);
    Mat points, sigmas;
    std::vector<Point2d> pointList;
    std::vector<double> sigmaList;
    detectStripe(image, points, sigmas);
    detectStripe(image, pointList, sigmaList);
    ASSERT_EQ(size_t(points.rows), pointList.size());
    // In OpenCV 5 the header of a vector has one dimension.
    EXPECT_EQ(0, cv::norm(points.reshape(2), Mat(pointList).reshape(2, points.rows), NORM_INF));
    EXPECT_EQ(0, cv::norm(sigmas, Mat(sigmaList).reshape(1, points.rows), NORM_INF));
}

}} // namespace opencv_test
