// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "stripe_image.hpp"

namespace opencv_test { namespace {

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
}

TEST(ActiveHandEye_detectStripe, RefusesParamsThatAreNoNumberOrOutOfRange)
{
    struct Field
    {
        double StripeParams::* value;
        double wrong;
        const char* name;
    };
    const Field fields[] = {{&StripeParams::sigma, 0.1, "params.sigma: needed a value from 0.5 to 20"},
                            {&StripeParams::minSnr, 0, "params.minSnr: needed a value from 1 to 1000"},
                            {&StripeParams::minContrast, 1.5, "params.minContrast: needed a value from 0 to 1"},
                            {&StripeParams::maxSecondPeak, -1, "params.maxSecondPeak: needed a value from 0 to 1"},
                            {&StripeParams::saturation, 1e6, "params.saturation: needed a value from 0 to 65535"}};
    const Mat image = StripeImage().render(true);
    Mat points, sigmas;
    for (const Field& field : fields)
        for (double wrong : {field.wrong, std::numeric_limits<double>::quiet_NaN()})
        {
            StripeParams params;
            params.*field.value = wrong;
            expectError([&] { detectStripe(image, points, sigmas, noArray(), params); }, Error::StsOutOfRange,
                        {field.name, cv::format("given %g", wrong)});
        }
    StripeParams params;
    params.minRun = 0;
    expectError([&] { detectStripe(image, points, sigmas, noArray(), params); }, Error::StsOutOfRange,
                {"params.minRun"});
    params = StripeParams();
    params.orientation = 5;
    expectError([&] { detectStripe(image, points, sigmas, noArray(), params); }, Error::StsBadArg,
                {"params.orientation", "given 5"});
}

TEST(ActiveHandEye_detectStripe, RefusesARoiThatIsNotInsideTheImage)
{
    const Mat image = StripeImage().render(true); // 640 x 240
    Mat points, sigmas;
    for (const Rect& roi : {Rect(-1, 0, 9, 9), Rect(0, 0, 641, 9), Rect(632, 0, 9, 9), Rect(0, 232, 9, 9),
                            Rect(5, 5, 0, 9), Rect(5, 5, 9, -9), Rect(1, 1, INT_MAX, INT_MAX)})
    {
        StripeParams params;
        params.roi = roi;
        expectError([&] { detectStripe(image, points, sigmas, noArray(), params); }, Error::StsOutOfRange,
                    {"params.roi: needed a part of the image (640 x 240 pixels)"});
    }
}

TEST(ActiveHandEye_detectStripe, NoiseAloneGivesNoPoints)
{
    int points = 0;
    for (uint64 seed = 1; seed <= 20; ++seed)
        for (double noise : {1., 3., 10.})
        {
            StripeImage scene;
            scene.noise = noise;
            scene.offset = 100;
            Mat found, sigmas;
            detectStripe(scene.render(false, seed), found, sigmas);
            points += found.rows;
        }
    EXPECT_EQ(0, points) << "in 38400 columns without a stripe";
}

TEST(ActiveHandEye_detectStripe, TextureAloneGivesNoPoints)
{
    StripeImage scene;
    scene.noise = 3;
    scene.offset = 120;
    scene.albedo = [](int x, int y) { return RNG(uint64(x / 3 * 4099 + y / 3 * 31 + 7)).uniform(0.4, 1.2); };
    Mat points, sigmas;
    detectStripe(scene.render(false), points, sigmas);
    EXPECT_EQ(0, points.rows);
    const Mat image = scene.render(false, 1), background = scene.render(false, 2);
    detectStripe(image, points, sigmas, background);
    EXPECT_EQ(0, points.rows);
}

//! A second stripe 60 rows below along the whole image.
Mat twoStripes(double brightness)
{
    StripeImage scene, second;
    scene.noise = second.noise = 2;
    second.centre = [&](int x) { return scene.centre(x) + 60; };
    second.albedo = [=](int, int) { return brightness; };
    second.offset = 0;
    return scene.render(true, 1) + second.render(true, 2);
}

TEST(ActiveHandEye_detectStripe, OfTwoStripesTheStrongerWinsAndEqualOnesAreLeftOut)
{
    Mat points, sigmas;
    detectStripe(twoStripes(0.95), points, sigmas);
    EXPECT_EQ(0, points.rows);
    detectStripe(twoStripes(0.4), points, sigmas);
    const Accuracy a = accuracy(points, sigmas, StripeImage().centre);
    EXPECT_EQ(640u, a.count);
    EXPECT_LE(a.rmse, 0.05);
}

}} // namespace opencv_test
