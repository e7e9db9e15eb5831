// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "stripe_scene.hpp"

namespace opencv_test { namespace {

//! Tracked points on the surfaces of the scene, with noise, and a share of wrong matches. A view sees a surface where its stripe is.
std::vector<Mat> track(const StripeScene& scene, double noise, double wrong, uint64 seed)
{
    RNG rng(seed);
    std::vector<Vec3d> points;
    for (int i = 0; i < 1500; ++i)
    {
        const SceneSurface& surface = scene.surfaces[i % scene.surfaces.size()];
        const int view = int(i / scene.surfaces.size()) %
                         int(scene.R.size()); // a pixel of that view, within the columns of the surface
        const Vec2d pixel(rng.uniform(surface.firstColumn, surface.lastColumn), rng.uniform(0., 480.));
        const Vec3d ray = scene.cam2base(view) * (scene.K.inv() * Vec3d(pixel[0], pixel[1], 1)),
                    origin = scene.cameraPosition(view);
        points.push_back(origin + ray * ((surface.offset - surface.normal.dot(origin)) / surface.normal.dot(ray)));
    }
    std::vector<Mat> tracks;
    for (int view = 0; view < int(scene.R.size()); ++view)
    {
        Mat seen(int(points.size()), 2, CV_64F);
        for (int i = 0; i < seen.rows; ++i)
        {
            const SceneSurface& surface = scene.surfaces[i % scene.surfaces.size()];
            const Vec3d X = scene.cam2base(view).t() * (points[i] - scene.cameraPosition(view)), x = scene.K * X;
            const Vec2d ideal(x[0] / x[2], x[1] / x[2]);
            Vec2d pixel = scene.distort(ideal) + Vec2d(rng.gaussian(noise), rng.gaussian(noise));
            const bool isSeen = ideal[0] >= surface.firstColumn && ideal[0] <= surface.lastColumn;
            if (isSeen && rng.uniform(0., 1.) < wrong)
                pixel = Vec2d(rng.uniform(0., 640.), rng.uniform(0., 480.));
            if (!isSeen || pixel[0] < 0 || pixel[0] > 639 || pixel[1] < 0 || pixel[1] > 479)
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
    associateStripes(scene.R, scene.t, scene.points, scene.views, tracks, scene.K, scene.D, scene.R_cam2gripper,
                     scene.t_cam2gripper, ids, light);
    EXPECT_EQ(scene.points.size(), ids.total());
    return Association{std::vector<int>(ids.ptr<int>(), ids.ptr<int>() + ids.total()), Vec4d(light.ptr<double>())};
}

//! Pairs of segments of one group: on the same surface in truth and by their ids.
void countPairs(const StripeScene& scene, const std::vector<int>& ids, int viewsPerGroup, int& wrong, int& missed,
                int& right)
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

//! Leaves the segments of a surface in some views only.
void keepViews(StripeScene& scene, int surface, const std::vector<int>& views)
{
    for (size_t i = scene.ids.size(); i-- > 0;)
        if (scene.ids[i] == surface && std::find(views.begin(), views.end(), scene.views[i]) == views.end())
        {
            scene.points.erase(scene.points.begin() + i);
            scene.views.erase(scene.views.begin() + i);
            scene.ids.erase(scene.ids.begin() + i);
        }
}

std::vector<int> idsOfSurface(const StripeScene& scene, const std::vector<int>& ids, int surface)
{
    std::vector<int> own;
    for (size_t i = 0; i < ids.size(); ++i)
        if (scene.ids[i] == surface)
            own.push_back(ids[i]);
    return own;
}

TEST(ActiveHandEye_associateStripes, ViewsOutsideTheGroupsJoinTheSurfacesOfTheGroups)
{
    StripeScene scene = StripeScene::standard();
    scene.addGroup(Vec3d(0, 0, 1), 50, {Vec3d(0.02, -0.01, 0.5)});
    scene.addGroup(Vec3d(1, 1, 0), 12, {Vec3d(0.01, 0.02, 0.52), Vec3d(0.03, 0, 0.48)});
    scene.shine(0.05);
    const Association found = associate(scene, track(scene, 0.1, 0, 7));
    for (int surface = 0; surface < 3; ++surface)
    {
        const std::vector<int> own = idsOfSurface(scene, found.ids, surface);
        ASSERT_EQ(13u, own.size());
        EXPECT_GE(own[0], 0);
        EXPECT_EQ(std::vector<int>(13, own[0]), own);
    }
}

TEST(ActiveHandEye_associateStripes, TwoViewsOfDifferentGroupsShareASurfaceThatPointsConfirm)
{
    StripeScene scene = StripeScene::standard();
    scene.addGroup(Vec3d(1, 0.3, 0), 4, StripeScene::star(0.05));
    scene.shine(0.05);
    keepViews(scene, 2, {0, 11});
    const std::vector<Mat> tracks = track(scene, 0.1, 0, 8);
    const std::vector<int> confirmed = idsOfSurface(scene, associate(scene, tracks).ids, 2);
    ASSERT_EQ(2u, confirmed.size());
    EXPECT_GE(confirmed[0], 0);
    EXPECT_EQ(confirmed[0], confirmed[1]);

    const int surfaces = int(scene.surfaces.size());
    for (const Mat& seen : tracks)
        for (int i = 2; i < seen.rows; i += surfaces) // the tracks of surface 2
            seen.row(i).setTo(std::numeric_limits<double>::quiet_NaN());
    EXPECT_EQ(std::vector<int>(2, -1), idsOfSurface(scene, associate(scene, tracks).ids, 2));
}

StripeScene fiveSurfaces()
{
    StripeScene scene = StripeScene::standard();
    scene.surfaces.clear();
    scene.addSurface(Vec3d(0, 0, 1), 0, 20, 120);
    scene.addSurface(Vec3d(0.1, -0.35, 1), 0.02, 140, 240);
    scene.addSurface(Vec3d(-0.4, 0.1, 1), 0.01, 260, 360);
    scene.addSurface(Vec3d(0.3, 0.3, 1), 0.03, 380, 480);
    scene.addSurface(Vec3d(-0.1, 0.45, 1), -0.01, 500, 600);
    return scene;
}

TEST(ActiveHandEye_associateStripes, SurfacesOfOneViewAloneChangeNothing)
{
    StripeScene scene = fiveSurfaces();
    scene.shine(0.05);
    for (int surface : {2, 3, 4})
        keepViews(scene, surface, {3});
    StripeScene without = scene;
    for (int surface : {2, 3, 4})
        keepViews(without, surface, {});
    scene.ids = associate(scene, track(scene, 0.1, 0, 9)).ids;
    EXPECT_EQ(3, std::count(scene.ids.begin(), scene.ids.end(), -1));
    Vec4d plane, expected;
    scene.calibrate(plane);
    without.calibrate(expected);
    EXPECT_LE(cv::norm(plane, expected, NORM_INF), 1e-12);
}

TEST(ActiveHandEye_associateStripes, ViewsThatMeetFiveSurfacesHelpTheLightPlane)
{
    Vec2d few, five; // mean squares of the errors of normal and offset, with two and with five surfaces a view
    double fewVariance = 0, fiveVariance = 0;
    const int trials = 20;
    for (int trial = 0; trial < trials; ++trial)
    {
        StripeScene scene = fiveSurfaces();
        scene.columnStep = 4;
        scene.shine(0.1, 20 + trial);
        const std::vector<int> truth = scene.ids;
        scene.ids = associate(scene, track(scene, 0.1, 0.02, 40 + trial)).ids;
        int wrong, missed, right;
        StripeScene labelled = scene;
        labelled.ids = truth;
        countPairs(labelled, scene.ids, 5, wrong, missed, right);
        EXPECT_EQ(0, wrong);
        EXPECT_LE(missed, right / 20);
        Mat covariance(4, 4, CV_64F);
        const auto add = [&](const StripeScene& s, Vec2d& squares, double& variance)
        {
            Vec4d plane;
            s.calibrate(plane, covariance);
            squares += Vec2d(std::pow(s.normalError(plane), 2), std::pow(plane[3] - s.d, 2)) / trials;
            variance += covariance.at<double>(3, 3) / trials;
        };
        add(scene, five, fiveVariance);
        StripeScene lean = scene;
        for (size_t i = 0; i < truth.size(); ++i)
            if (truth[i] > 1)
                lean.ids[i] = -1;
        add(lean, few, fewVariance);
    }
    EXPECT_LE(fiveVariance, 0.7 * fewVariance);
    EXPECT_LE(five[0], 0.8 * few[0]);
    EXPECT_LE(five[1], 0.8 * few[1]);
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
    const auto refuse = [](const StripeScene& s, const vector<Mat>& points, int code, const string& text)
    { expectError([&] { associate(s, points); }, code, {text}); };
    std::vector<Mat> few, scattered;
    for (const Mat& t : tracks)
    {
        few.push_back(t.rowRange(0, 30));
        Mat random(t.size(), CV_64F);
        theRNG().fill(random, RNG::UNIFORM, 0, 480);
        scattered.push_back(random);
    }
    refuse(scene, few, Error::StsNoConv, "imagePoints: too few tracked points near the stripes; needed at least 30");
    refuse(scene, scattered, Error::StsNoConv, "imagePoints:");
    refuse(scene, vector<Mat>(tracks.begin(), tracks.begin() + 3), Error::StsBadSize,
           "imagePoints: needed one array for each of the 10 views, given 3");
    StripeScene bad = scene;
    bad.views[2] = -1;
    refuse(bad, tracks, Error::StsOutOfRange, "stripeViews[2]: needed a view from 0 to 9, given -1");
}

}} // namespace opencv_test
