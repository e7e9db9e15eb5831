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
        return x < 100 ? 200 + 0.05 * x : x < 200 ? 206 + 0.05 * x // step of 6 px
             : x < 300 ? 216 - 0.2 * (x - 200)                     // bend
             : x < 320 ? none : x < 420 ? 196 - 0.2 * (x - 300)     // the same line behind a gap
             : 172 - 0.2 * (x - 420) + 0.5 * (x - 420);            // shallow valley
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
    const auto code = [&](const Mat& sigmas, double breakDistance, int minPoints)
    {
        try
        {
            splitStripe(points, sigmas, camera, noArray(), ids, breakDistance, 6, minPoints);
        }
        catch (const cv::Exception& e)
        {
            return std::string(e.err);
        }
        return std::string();
    };
    EXPECT_NE(std::string::npos, code(Mat(49, 1, CV_64F, Scalar(1)), 0.6, 20).find("sigmas: needed one number for each of the 50 points, given 49"));
    EXPECT_NE(std::string::npos, code(Mat(50, 1, CV_64F, Scalar(0)), 0.6, 20).find("sigmas: needed a positive number"));
    EXPECT_NE(std::string::npos, code(Mat(), -1, 20).find("breakDistance: needed a positive number"));
    EXPECT_NE(std::string::npos, code(Mat(), 0.6, 2).find("minPoints: needed at least 5, given 2"));
}

//! Tracked points on the surfaces of the scene, seen by all views, with noise; and their share of wrong matches.
std::vector<Mat> track(const StripeScene& scene, double noise, double wrong, uint64 seed)
{
    RNG rng(seed);
    std::vector<Vec3d> points;
    for (int i = 0; i < 1500; ++i)
    {
        const SceneSurface& surface = scene.surfaces[i % scene.surfaces.size()];
        const int view = int(i / scene.surfaces.size()) % int(scene.R.size()); // a pixel of that view, within the columns of the surface
        const Vec2d pixel(rng.uniform(surface.firstColumn, surface.lastColumn), rng.uniform(0., 480.));
        const Vec3d ray = scene.cam2base(view) * (scene.K.inv() * Vec3d(pixel[0], pixel[1], 1)), origin = scene.cameraPosition(view);
        points.push_back(origin + ray * ((surface.offset - surface.normal.dot(origin)) / surface.normal.dot(ray)));
    }
    std::vector<Mat> tracks;
    for (int view = 0; view < int(scene.R.size()); ++view)
    {
        Mat seen(int(points.size()), 2, CV_64F);
        for (int i = 0; i < seen.rows; ++i)
        {
            const Vec3d X = scene.cam2base(view).t() * (points[i] - scene.cameraPosition(view)), x = scene.K * X;
            Vec2d pixel = scene.distort(Vec2d(x[0] / x[2], x[1] / x[2])) + Vec2d(rng.gaussian(noise), rng.gaussian(noise));
            if (rng.uniform(0., 1.) < wrong)
                pixel = Vec2d(rng.uniform(0., 640.), rng.uniform(0., 480.));
            if (pixel[0] < 0 || pixel[0] > 639 || pixel[1] < 0 || pixel[1] > 479)
                pixel = Vec2d::all(std::numeric_limits<double>::quiet_NaN());
            seen.at<double>(i, 0) = pixel[0];
            seen.at<double>(i, 1) = pixel[1];
        }
        tracks.push_back(seen);
    }
    return tracks;
}

struct Association
{
    std::vector<int> ids;
    Vec4d light;
};

Association associate(const StripeScene& scene, const std::vector<Mat>& tracks)
{
    Mat ids, light;
    associateStripes(scene.R, scene.t, scene.points, scene.views, tracks, scene.K, scene.D, scene.R_cam2gripper, scene.t_cam2gripper, ids, light);
    EXPECT_EQ(scene.points.size(), ids.total());
    return Association{std::vector<int>(ids.ptr<int>(), ids.ptr<int>() + ids.total()), Vec4d(light.ptr<double>())};
}

//! Pairs of segments of one group: on the same surface in truth and by their ids.
void countPairs(const StripeScene& scene, const std::vector<int>& ids, int viewsPerGroup, int& wrong, int& missed, int& right)
{
    wrong = missed = right = 0;
    for (size_t i = 0; i < ids.size(); ++i)
        for (size_t j = i + 1; j < ids.size(); ++j)
        {
            if (scene.views[i] / viewsPerGroup != scene.views[j] / viewsPerGroup)
                continue;
            const bool same = scene.ids[i] == scene.ids[j], joined = ids[i] >= 0 && ids[i] == ids[j];
            wrong += joined && !same;
            missed += !joined && same;
            right += joined && same;
        }
}

TEST(ActiveHandEye_associateStripes, FindsTheSurfacesAndTheRoughPlane)
{
    StripeScene scene = StripeScene::standard();
    scene.shine(0.05);
    const Association found = associate(scene, track(scene, 0.1, 0, 3));
    int wrong, missed, right;
    countPairs(scene, found.ids, 5, wrong, missed, right);
    EXPECT_EQ(0, wrong);
    EXPECT_EQ(0, missed);
    EXPECT_LE(scene.normalError(found.light), 0.2);
    EXPECT_NEAR(scene.d, found.light[3], 0.001);
    for (size_t i = 0; i < found.ids.size(); ++i) // across groups too
        EXPECT_EQ(found.ids[scene.ids[i]], found.ids[i]);

    StripeScene labelled = scene;
    labelled.ids = found.ids;
    Vec4d plane, expected;
    scene.calibrate(expected);
    labelled.calibrate(plane);
    EXPECT_LE(cv::norm(plane, expected, NORM_INF), 1e-9);
}

TEST(ActiveHandEye_associateStripes, WrongTracksAndSegmentsAreLeftOut)
{
    StripeScene scene = StripeScene::standard();
    scene.shine(0.1);
    scene.points[5].col(1) += 30;
    scene.points[20].col(1) -= 15;
    const std::vector<int> wrongSegments = {5, 20};
    const Association found = associate(scene, track(scene, 0.2, 0.1, 4));
    int wrong, missed, right;
    for (int segment : wrongSegments)
        scene.ids[segment] = 100 + segment;
    countPairs(scene, found.ids, 5, wrong, missed, right);
    EXPECT_EQ(0, wrong);
    EXPECT_EQ(0, missed);
    EXPECT_EQ(-1, found.ids[5]);
    EXPECT_EQ(-1, found.ids[20]);
}

TEST(ActiveHandEye_associateStripes, UnitsOfLengthDoNotMatter)
{
    StripeScene scene = StripeScene::standard();
    scene.shine(0.1);
    const std::vector<Mat> tracks = track(scene, 0.1, 0.05, 5);
    const Association metres = associate(scene, tracks);
    for (Mat& t : scene.t)
        t = t * 1000;
    scene.t_cam2gripper *= 1000;
    const Association millimetres = associate(scene, tracks);
    EXPECT_EQ(metres.ids, millimetres.ids);
    EXPECT_NEAR(1, millimetres.light[3] / metres.light[3] / 1000, 1e-9);
}

TEST(ActiveHandEye_associateStripes, SaysWhatIsMissing)
{
    StripeScene scene = StripeScene::standard();
    scene.shine(0.1);
    const std::vector<Mat> tracks = track(scene, 0.1, 0, 6);
    const auto error = [&](const StripeScene& s, const std::vector<Mat>& points)
    {
        try
        {
            Mat ids, light;
            associateStripes(s.R, s.t, s.points, s.views, points, s.K, s.D, s.R_cam2gripper, s.t_cam2gripper, ids, light);
        }
        catch (const cv::Exception& e)
        {
            return cv::format("%d %s", int(e.code), e.err.c_str());
        }
        return std::string();
    };
    std::vector<Mat> few, scattered;
    for (const Mat& t : tracks)
    {
        few.push_back(t.rowRange(0, 30));
        Mat random(t.size(), CV_64F);
        theRNG().fill(random, RNG::UNIFORM, 0, 480);
        scattered.push_back(random);
    }
    EXPECT_NE(std::string::npos, error(scene, few).find("-7 imagePoints: too few tracked points near the stripes; needed at least 30"));
    EXPECT_NE(std::string::npos, error(scene, scattered).find("-7 imagePoints:"));
    EXPECT_NE(std::string::npos, error(scene, std::vector<Mat>(tracks.begin(), tracks.begin() + 3)).find("imagePoints: needed one array for each of the 10 views, given 3"));
    StripeScene bad = scene;
    bad.views[2] = -1;
    EXPECT_NE(std::string::npos, error(bad, tracks).find("-211 stripeViews[2]: needed a view from 0 to 9, given -1"));
}

}} // namespace opencv_test
