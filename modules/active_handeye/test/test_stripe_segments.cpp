// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "stripe_scene.hpp"
#include <functional>

namespace opencv_test { namespace {

const Matx33d camera(1400, 0, 320, 0, 1400, 240, 0, 0, 1);

//! Points (x, row(x) + noise) of the columns 0 .. columns - 1 where row is finite.
Mat stripe(int columns, double noise, const std::function<double(double)>& row, uint64 seed = 5)
{
    RNG rng(seed);
    std::vector<Vec2d> points;
    for (int x = 0; x < columns; ++x)
        if (std::isfinite(row(x)))
            points.push_back(Vec2d(x, row(x) + rng.gaussian(noise)));
    return Mat(points).reshape(1, int(points.size())).clone();
}

std::vector<int> split(const Mat& points, double breakDistance = 0.6)
{
    Mat ids;
    splitStripe(points, noArray(), camera, noArray(), ids, breakDistance);
    EXPECT_EQ(points.rows, ids.rows);
    EXPECT_EQ(CV_32S, ids.type());
    return std::vector<int>(ids.ptr<int>(), ids.ptr<int>() + ids.total());
}

int segments(const std::vector<int>& ids)
{
    return 1 + *std::max_element(ids.begin(), ids.end());
}

//! Share of the points inside the columns that have the id, and no other id.
double share(const Mat& points, const std::vector<int>& ids, double first, double last, int id)
{
    int right = 0, other = 0, all = 0;
    for (size_t i = 0; i < ids.size(); ++i)
        if (points.at<double>(int(i), 0) >= first && points.at<double>(int(i), 0) <= last)
        {
            ++all;
            right += ids[i] == id;
            other += ids[i] != id && ids[i] != -1;
        }
    EXPECT_EQ(0, other);
    return double(right) / all;
}

TEST(ActiveHandEye_splitStripe, StraightStripeIsOneSegment)
{
    for (double noise : {0., 0.05, 0.15})
    {
        const Mat points = stripe(640, noise, [](double x) { return 200 + 0.1 * x; });
        const std::vector<int> ids = split(points);
        EXPECT_EQ(1, segments(ids)) << noise;
        EXPECT_GE(share(points, ids, 3, 636, 0), 0.99);
    }
}

TEST(ActiveHandEye_splitStripe, StepsBendsAndGapsCutTheStripe)
{
    const double none = std::numeric_limits<double>::quiet_NaN();
    const auto row = [&](double x)
    {
        return x < 100   ? 200 + 0.05 * x
               : x < 200 ? 206 + 0.05 * x        // step of 6 px
               : x < 300 ? 216 - 0.2 * (x - 200) // bend
               : x < 320 ? none
               : x < 420 ? 196 - 0.2 * (x - 300)                    // the same line behind a gap
                         : 172 - 0.2 * (x - 420) + 0.5 * (x - 420); // shallow valley
    };
    const Mat points = stripe(640, 0.05, row);
    const std::vector<int> ids = split(points);
    ASSERT_EQ(5, segments(ids));
    const double first[] = {3, 103, 204, 323, 426}, last[] = {96, 196, 296, 414, 636};
    for (int k = 0; k < 5; ++k)
        EXPECT_GE(share(points, ids, first[k], last[k], k), 0.97) << "segment " << k;
}

TEST(ActiveHandEye_splitStripe, StepAboveTheBreakDistanceSplitsAndBelowDoesNot)
{
    const auto step = [](double height) { return [height](double x) { return x < 300 ? 200. : 200. + height; }; };
    EXPECT_EQ(2, segments(split(stripe(600, 0.03, step(0.9)))));
    EXPECT_EQ(1, segments(split(stripe(600, 0.03, step(0.3)))));
    EXPECT_EQ(1, segments(split(stripe(600, 0.03, step(0.9)), 2.0)));
}

TEST(ActiveHandEye_splitStripe, WorksInUndistortedCoordinates)
{
    StripeScene scene = StripeScene::standard();
    scene.surfaces.resize(1);
    scene.surfaces[0].lastColumn = 610;
    scene.D = {-0.9, 0.4, 0.02, 0, 0}; // bends the stripe by more than a pixel
    scene.shine(0.05);
    Mat ids;
    splitStripe(scene.points[1], noArray(), scene.K, scene.D, ids);
    EXPECT_GE(cv::countNonZero(ids == 0), 560);
    EXPECT_EQ(0, cv::countNonZero(ids > 0));
    splitStripe(scene.points[1], noArray(), scene.K, noArray(), ids);
    EXPECT_GT(cv::countNonZero(ids > 0), 0); // without distCoeffs it is a curve
}

TEST(ActiveHandEye_splitStripe, OutliersAndShortPiecesBelongToNone)
{
    Mat points = stripe(400, 0.05, [](double x) { return x < 370 ? 200 + 0.1 * x : x < 382 ? 260. : 150.; });
    for (int i : {40, 41, 120, 250})
        points.at<double>(i, 1) += 5;
    const std::vector<int> ids = split(points);
    EXPECT_EQ(1, segments(ids));
    for (int i : {40, 41, 120, 250, 375, 390})
        EXPECT_EQ(-1, ids[i]) << i;
    EXPECT_GE(share(points, ids, 3, 366, 0), 0.97);
}

TEST(ActiveHandEye_splitStripe, VerticalStripe)
{
    const Mat points = stripe(400, 0.05, [](double x) { return x < 200 ? 300 + 0.1 * x : 330.; });
    Mat turned(points.rows, 2, CV_64F);
    points.col(0).copyTo(turned.col(1));
    points.col(1).copyTo(turned.col(0));
    EXPECT_EQ(split(points), split(turned));
}

TEST(ActiveHandEye_splitStripe, EmptyStripeAndWrongInput)
{
    Mat ids;
    splitStripe(Mat(0, 2, CV_64F), noArray(), camera, noArray(), ids);
    EXPECT_EQ(0u, ids.total());
    const Mat points = stripe(50, 0, [](double) { return 10.; });
    const auto refuse = [&](const Mat& sigmas, double breakDistance, int minPoints, int code, const string& text)
    {
        expectError([&] { splitStripe(points, sigmas, camera, noArray(), ids, breakDistance, 6, minPoints); }, code,
                    {text});
    };
    refuse(Mat(49, 1, CV_64F, Scalar(1)), 0.6, 20, Error::StsBadSize,
           "sigmas: needed one number for each of the 50 points, given 49");
    refuse(Mat(50, 1, CV_64F, Scalar(0)), 0.6, 20, Error::StsOutOfRange, "sigmas: needed a positive number");
    refuse(Mat(), -1, 20, Error::StsOutOfRange, "breakDistance: needed a positive number");
    refuse(Mat(), 0.6, 2, Error::StsOutOfRange, "minPoints: needed at least 5, given 2");
}

}} // namespace opencv_test
