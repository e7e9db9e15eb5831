// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "stripe_scene.hpp"

namespace opencv_test { namespace {

Vec4d truth(const StripeScene& scene)
{
    return Vec4d(scene.n[0], scene.n[1], scene.n[2], scene.d);
}

void expectExact(const StripeScene& scene)
{
    Vec4d plane;
    const double rms = scene.calibrate(plane, Mat());
    EXPECT_LE(rms, 1e-8);
    EXPECT_LE(cv::norm(plane, truth(scene), NORM_INF), 1e-9);
}

//! Bound from the model itself, by numerical differentiation over every single pixel: n (2), d, and 3 per surface and group.
class NumericalBound
{
public:
    NumericalBound(const StripeScene& scene, int viewsPerGroup) : scene_(scene), viewsPerGroup_(viewsPerGroup)
    {
        const Vec3d axis = std::abs(scene.n[0]) < 0.9 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0);
        a_ = scene.n.cross(axis);
        a_ = a_ / cv::norm(a_);
        b_ = scene.n.cross(a_);
        groups_ = int(scene.R.size()) / viewsPerGroup;
    }

    //! 4 x 4 covariance of (n, d) for pixel noise of this size.
    Mat covariance(double noise) const
    {
        const int unknowns = 3 + 3 * groups_ * int(scene_.surfaces.size());
        const double h = 1e-6;
        std::vector<double> step(unknowns, 0.);
        const int count = int(rows(step).size());
        Mat J(count, unknowns, CV_64F);
        for (int k = 0; k < unknowns; ++k)
        {
            step[k] = h;
            const std::vector<double> plus = rows(step);
            step[k] = -h;
            const std::vector<double> minus = rows(step);
            step[k] = 0;
            for (int i = 0; i < count; ++i)
                J.at<double>(i, k) = (plus[i] - minus[i]) / (2 * h);
        }
        const Mat inverse = Mat(J.t() * J).inv(DECOMP_SVD) * (noise * noise);
        Mat toPlane = Mat::zeros(4, 3, CV_64F);
        for (int i = 0; i < 3; ++i)
        {
            toPlane.at<double>(i, 0) = a_[i];
            toPlane.at<double>(i, 1) = b_[i];
        }
        toPlane.at<double>(3, 2) = 1;
        return toPlane * inverse(Rect(0, 0, 3, 3)) * toPlane.t();
    }

private:
    std::vector<double> rows(const std::vector<double>& step) const
    {
        Vec3d n = scene_.n + step[0] * a_ + step[1] * b_;
        n = n / cv::norm(n);
        std::vector<double> result;
        for (int view = 0; view < int(scene_.R.size()); ++view)
            for (size_t s = 0; s < scene_.surfaces.size(); ++s)
            {
                const size_t at = 3 + 3 * ((view / viewsPerGroup_) * scene_.surfaces.size() + s);
                SceneSurface surface = scene_.surfaces[s];
                surface.normal += Vec3d(step[at], step[at + 1], 0); // normal.X = offset, z component fixed: 3 unknowns
                surface.offset += step[at + 2];
                for (double column = surface.firstColumn; column <= surface.lastColumn; column += scene_.columnStep)
                    result.push_back(scene_.stripeRow(view, surface, column, n, scene_.d + step[2]));
            }
        return result;
    }

    const StripeScene& scene_;
    const int viewsPerGroup_;
    int groups_;
    Vec3d a_, b_;
};

TEST(ActiveHandEye_calibrateLightPlane, ExactDataGiveTheExactPlane)
{
    StripeScene scene = StripeScene::standard();
    scene.shine();
    expectExact(scene);
}

TEST(ActiveHandEye_calibrateLightPlane, OneSurfaceInTwoGroups)
{
    StripeScene scene = StripeScene::standard();
    scene.surfaces.resize(1);
    scene.shine();
    expectExact(scene);
}

TEST(ActiveHandEye_calibrateLightPlane, ThreeSurfacesInOneGroup)
{
    StripeScene scene = StripeScene::standard();
    scene.R.resize(5);
    scene.t.resize(5);
    scene.shine();
    expectExact(scene);
}

TEST(ActiveHandEye_calibrateLightPlane, ThreeViewsAreTheMinimum)
{
    StripeScene scene = StripeScene::standard();
    scene.R.resize(3);
    scene.t.resize(3);
    scene.t[1] = Mat(Vec3d(Vec3d(scene.t[1]) + Vec3d(0, 0.03, 0.04)));
    scene.t[2] = Mat(Vec3d(Vec3d(scene.t[2]) + Vec3d(0, -0.04, 0.05)));
    scene.shine();
    expectExact(scene);
}

TEST(ActiveHandEye_calibrateLightPlane, ViewsAloneInTheirGroupAndUnknownSurfacesAreIgnored)
{
    StripeScene scene = StripeScene::standard();
    scene.addGroup(Vec3d(0, 0, 1), 80, {Vec3d(0, 0, 0.5)});
    scene.shine();
    scene.ids[4] = -1;
    scene.points[4].col(1) += 40;
    expectExact(scene);
}

TEST(ActiveHandEye_calibrateLightPlane, ManyViewsOfOneSurfaceInOneGroupSuffice)
{
    StripeScene scene;
    scene.columnStep = 4;
    std::vector<Vec3d> positions;
    for (int i = 0; i < 25; ++i)
        positions.push_back(Vec3d(0.01 * (i % 3), 0.03 * (i % 5) - 0.06, 0.5 + 0.03 * (i / 5) - 0.06));
    scene.addGroup(Vec3d(1, 0, 0), 0, positions);
    scene.addSurface(Vec3d(0, 0.2, 1), 0, 40, 600);
    scene.shine();
    Vec4d plane;
    Mat covariance(4, 4, CV_64F);
    scene.calibrate(plane, covariance);
    EXPECT_LE(cv::norm(plane, truth(scene), NORM_INF), 1e-7);
    EXPECT_GT(std::sqrt(covariance.at<double>(3, 3)), 0.0003); // weak, and said so
}

TEST(ActiveHandEye_calibrateLightPlane, NoisyStripesReachTheBound)
{
    StripeScene scene = StripeScene::standard();
    scene.columnStep = 8; // few points, so that the floor of the lines' sigma (0.02 px) does not matter
    const double noise = 0.3;
    const Mat bound = NumericalBound(scene, 5).covariance(noise);
    const int trials = 200;
    Vec4d squares, predicted;
    for (int trial = 0; trial < trials; ++trial)
    {
        scene.shine(noise, 100 + trial);
        Vec4d plane;
        Mat covariance(4, 4, CV_64F);
        const double rms = scene.calibrate(plane, covariance);
        EXPECT_NEAR(noise, rms, 0.15 * noise);
        const Vec4d error = plane - truth(scene);
        for (int i = 0; i < 4; ++i)
        {
            squares[i] += error[i] * error[i] / trials;
            predicted[i] += covariance.at<double>(i, i) / trials;
        }
    }
    for (int i = 0; i < 4; ++i)
    {
        SCOPED_TRACE(cv::format("component %d: rmse %.3g, bound %.3g", i, std::sqrt(squares[i]),
                                std::sqrt(bound.at<double>(i, i))));
        EXPECT_LE(std::sqrt(squares[i]), 1.15 * std::sqrt(bound.at<double>(i, i)));
        EXPECT_GE(std::sqrt(squares[i]), 0.85 * std::sqrt(bound.at<double>(i, i)));
        EXPECT_NEAR(1, std::sqrt(predicted[i] / bound.at<double>(i, i)), 0.15);
    }
}

TEST(ActiveHandEye_calibrateLightPlane, CovarianceHasRankThree)
{
    StripeScene scene = StripeScene::standard();
    scene.shine(0.1);
    Vec4d plane;
    Mat covariance(4, 4, CV_64F), values;
    scene.calibrate(plane, covariance);
    EXPECT_LE(cv::norm(covariance - covariance.t(), NORM_INF), 1e-20);
    const Mat alongNormal = (Mat_<double>(4, 1) << plane[0], plane[1], plane[2], 0.);
    EXPECT_LE(cv::norm(covariance * alongNormal, NORM_INF), 1e-18);
    cv::eigen(covariance, values);
    EXPECT_GT(values.at<double>(2), 0);
}

TEST(ActiveHandEye_calibrateLightPlane, UnitsOfLengthScaleTheOffsetOnly)
{
    StripeScene scene = StripeScene::standard();
    scene.shine(0.1);
    Vec4d metres, millimetres;
    Mat covariance(4, 4, CV_64F), scaled(4, 4, CV_64F);
    const double rms = scene.calibrate(metres, covariance);
    for (Mat& t : scene.t)
        t = t * 1000;
    EXPECT_NEAR(rms, scene.calibrate(millimetres, scaled), 1e-9);
    for (int i = 0; i < 4; ++i)
        EXPECT_NEAR(1, millimetres[i] / metres[i] / (i < 3 ? 1 : 1000), 1e-9);
    EXPECT_NEAR(1, scaled.at<double>(3, 3) / covariance.at<double>(3, 3) / 1e6, 1e-7);
    EXPECT_NEAR(1, scaled.at<double>(0, 0) / covariance.at<double>(0, 0), 1e-7);
}

TEST(ActiveHandEye_calibrateLightPlane, BaseFrameAndOrderDoNotMatter)
{
    StripeScene scene = StripeScene::standard();
    scene.shine(0.1);
    Vec4d plane, moved;
    scene.calibrate(plane);
    StripeScene other = scene;
    const Matx33d turn = rotationAbout(Vec3d(1, 2, -0.5), 77);
    const int views = int(scene.R.size());
    for (int v = 0; v < views; ++v)
    {
        other.R[views - 1 - v] = Mat(turn * Matx33d(scene.R[v]));
        other.t[views - 1 - v] = Mat(Vec3d(turn * Vec3d(scene.t[v]) + Vec3d(0.3, -1, 2)));
    }
    const size_t segments = scene.points.size();
    for (size_t i = 0; i < segments; ++i)
    {
        const size_t from = (7 * i + 3) % segments; // 30 segments: a permutation
        other.points[i] = scene.points[from];
        other.views[i] = views - 1 - scene.views[from];
        other.ids[i] = 5 - scene.ids[from];
    }
    other.calibrate(moved);
    EXPECT_LE(cv::norm(plane, moved, NORM_INF), 1e-9);
}

TEST(ActiveHandEye_calibrateLightPlane, InputOfOtherTypesAndShapesGivesTheSame)
{
    StripeScene scene = StripeScene::standard();
    scene.shine();
    Vec4d plane;
    scene.calibrate(plane);
    std::vector<Mat> turned, points;
    for (const Mat& t : scene.t)
        turned.push_back(t.t());
    for (const Mat& p : scene.points)
        points.push_back(p.reshape(2));
    Mat light;
    calibrateLightPlane(scene.R, turned, points, Mat(scene.views).reshape(1, 1), scene.ids, scene.K,
                        Mat(scene.D).reshape(1, 1), scene.R_cam2gripper, light);
    EXPECT_EQ(4, light.rows);
    EXPECT_EQ(0, cv::norm(plane, Vec4d(light.ptr<double>()), NORM_INF));
}

TEST(ActiveHandEye_calibrateLightPlane, OneWrongSegmentDoesNotSpoilTheResult)
{
    for (int wrong : {0, 7, 17, 29})
    {
        SCOPED_TRACE(wrong);
        StripeScene scene = StripeScene::standard();
        scene.shine(0.1);
        Vec4d clean, plane;
        scene.calibrate(clean);
        scene.points[wrong].col(1) += 25; // as on another surface
        scene.calibrate(plane);
        EXPECT_LE(scene.normalError(plane), scene.normalError(clean) + 0.03);
        EXPECT_NEAR(scene.d, plane[3], 0.0003);
    }
}

TEST(ActiveHandEye_calibrateLightPlane, OneMislabelledSegmentDoesNotSpoilTheResult)
{
    StripeScene scene = StripeScene::standard();
    scene.shine(0.1);
    std::swap(scene.ids[3], scene.ids[4]); // view 1: two surfaces exchanged
    Vec4d plane;
    scene.calibrate(plane);
    EXPECT_LE(scene.normalError(plane), 0.05);
    EXPECT_NEAR(scene.d, plane[3], 0.0004);
}

}} // namespace opencv_test
