// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "perf_precomp.hpp"
#include "../test/measure_scene.hpp"
#include "../test/stripe_image.hpp"

namespace opencv_test { namespace {

typedef TestBaseWithParam<tuple<Size, MatDepth>> StripeFrame;

PERF_TEST_P(StripeFrame, detectStripe,
            testing::Combine(testing::Values(szVGA, Size(1920, 1200)), testing::Values(CV_8U, CV_16U)))
{
    StripeImage stripe;
    stripe.rows = get<0>(GetParam()).height;
    stripe.cols = get<0>(GetParam()).width;
    stripe.type = get<1>(GetParam());
    const double grey = stripe.type == CV_16U ? 257 : 1;
    stripe.height *= grey;
    stripe.offset *= grey;
    stripe.noise = grey;
    const Mat image = stripe.render(true);
    Mat points, sigmas;
    TEST_CYCLE() detectStripe(image, points, sigmas);
    EXPECT_GT(int(points.total()), stripe.cols);
    SANITY_CHECK_NOTHING();
}

PERF_TEST(Stripe, calibrateLightPlane)
{
    StripeScene scene = StripeScene::standard();
    scene.shine(0.05);
    Vec4d plane;
    TEST_CYCLE() scene.calibrate(plane);
    EXPECT_LT(scene.normalError(plane), 0.1);
    SANITY_CHECK_NOTHING();
}

typedef TestBaseWithParam<tuple<int, bool>> StripePixels;

PERF_TEST_P(StripePixels, reprojectStripe, testing::Combine(testing::Values(640, 100000), testing::Bool()))
{
    Measurement call(litScene());
    cv::repeat(Mat(call.pixels), get<0>(GetParam()) / call.pixels.rows + 1, 1, call.pixels);
    if (!get<1>(GetParam()))
        call.D.release();
    Mat points;
    TEST_CYCLE() points = call.points(Measurement::BASE);
    EXPECT_EQ(call.pixels.rows, points.rows);
    SANITY_CHECK_NOTHING();
}

PERF_TEST(Stripe, reprojectStripe_with_covariances)
{
    const Measurement call(litScene());
    const Mat calibration = Mat::eye(20, 20, CV_64F) * 1e-8, sigmas(call.pixels.rows, 1, CV_64F, Scalar(0.05));
    Mat covariances;
    TEST_CYCLE() covariances = call.covariances(Measurement::BASE, calibration, sigmas, 2e-5, 5e-5);
    EXPECT_EQ(call.pixels.rows, covariances.size[0]);
    SANITY_CHECK_NOTHING();
}

}} // namespace opencv_test
