// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "measure_scene.hpp"

namespace opencv_test { namespace {

Vec3d row(const Mat& points, int i)
{
    return Vec3d(points.ptr<double>(i));
}

Matx33d block(const Mat& covariances, int i)
{
    return Matx33d(covariances.ptr<double>(i));
}

//! Errors of a calibration: A times standard normal numbers.
Matx20d errorFactor(const Vec4d& light, uint64 seed)
{
    const double size[] = {0.8,  0.8,  0.9,  0.9,  0.2,    2e-3,   1e-2,   2e-4, 2e-4, 5e-3,
                           2e-4, 2e-4, 2e-4, 1e-4, 1.2e-4, 1.5e-4, 1.5e-4, 2e-4, 2e-4, 1e-4};
    RNG rng(seed);
    Matx20d A;
    for (int i = 0; i < 20; ++i)
        for (int j = 0; j < 20; ++j)
            A(i, j) = size[i] * rng.gaussian(0.22);
    const Vec3d n(light[0], light[1], light[2]);
    for (int j = 0; j < 20; ++j) // |n| = 1
    {
        const Vec3d dn(A(16, j), A(17, j), A(18, j));
        const Vec3d tangent = dn - n * n.dot(dn);
        for (int i = 0; i < 3; ++i)
            A(16 + i, j) = tangent[i];
    }
    return A;
}

Mat calibrationCovariance(const Matx20d& A)
{
    return Mat(A * A.t()).clone();
}

double largest(const Matx33d& m)
{
    return cv::norm(m, NORM_INF);
}

TEST(ActiveHandEye_Measure, points_lie_on_surface_and_light_plane)
{
    const StripeScene scene = litScene();
    for (int segment = 0; segment < int(scene.points.size()); ++segment)
    {
        const Measurement m(scene, segment);
        const Mat inCamera = m.points(Measurement::CAMERA), inBase = m.points(Measurement::BASE);
        ASSERT_EQ(m.pixels.rows, inBase.rows);
        const SceneSurface& surface = scene.surfaces[scene.ids[segment]];
        for (int i = 0; i < inBase.rows; ++i)
        {
            EXPECT_NEAR(scene.d, scene.n.dot(row(inCamera, i)), 1e-12);
            EXPECT_NEAR(surface.offset, surface.normal.dot(row(inBase, i)), 1e-12);
        }
    }
}

TEST(ActiveHandEye_Measure, frames_follow_the_transforms_given)
{
    const Measurement m(litScene(), 20);
    const Mat inCamera = m.points(Measurement::CAMERA), inGripper = m.points(Measurement::GRIPPER),
              inBase = m.points(Measurement::BASE);
    for (int i = 0; i < inCamera.rows; ++i)
    {
        EXPECT_LT(cv::norm(m.R_cam2gripper * row(inCamera, i) + m.t_cam2gripper - row(inGripper, i)), 1e-14);
        EXPECT_LT(cv::norm(m.R_gripper2base * row(inGripper, i) + m.t_gripper2base - row(inBase, i)), 1e-14);
    }
}

TEST(ActiveHandEye_Measure, covariance_is_that_of_numerical_derivatives)
{
    const Measurement m(litScene(), 22);
    const Mat C = calibrationCovariance(errorFactor(m.light, 5));
    const double step[] = {1e-2, 1e-2, 1e-2, 1e-2, 1e-2, 1e-5, 1e-5, 1e-5, 1e-5, 1e-5,
                           1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 1e-5};
    for (Measurement::Frame frame : {Measurement::CAMERA, Measurement::GRIPPER, Measurement::BASE})
    {
        vector<Mat> derivatives;
        for (int k = 0; k < 20; ++k)
        {
            Vec20d error;
            error[k] = step[k];
            derivatives.push_back((m.corrected(error).points(frame) - m.corrected(-error).points(frame)) /
                                  (2 * step[k]));
        }
        const Mat covariances = m.covariances(frame, C);
        for (int i = 0; i < m.pixels.rows; ++i)
        {
            Mat J(3, 20, CV_64F);
            for (int k = 0; k < 20; ++k)
                Mat(row(derivatives[k], i)).copyTo(J.col(k));
            const Matx33d expected = Mat(J * C * J.t());
            EXPECT_LT(largest(block(covariances, i) - expected), 1e-6 * largest(expected)) << "frame " << int(frame);
        }
    }
}

TEST(ActiveHandEye_Measure, pixel_and_robot_errors_agree_with_numerical_derivatives)
{
    const Measurement m(litScene(), 22);
    const double pixel = 0.1, translation = 2e-5, turn = 1e-4, step = 1e-4;
    const Mat covariances = m.covariances(Measurement::BASE, noArray(), pixel, translation, turn);
    vector<Mat> derivatives;
    for (int k = 0; k < 5; ++k)
    {
        Measurement ahead = m, back = m;
        if (k < 2)
        {
            ahead.pixels = m.pixels.clone();
            back.pixels = m.pixels.clone();
            ahead.pixels.col(k) += step;
            back.pixels.col(k) -= step;
        }
        else
        {
            Vec3d w;
            w[k - 2] = step;
            ahead.R_gripper2base = rotation(w) * m.R_gripper2base;
            back.R_gripper2base = rotation(-w) * m.R_gripper2base;
        }
        const Mat difference = ahead.points(Measurement::BASE) - back.points(Measurement::BASE);
        derivatives.push_back(difference * ((k < 2 ? pixel : turn) / (2 * step)));
    }
    for (int i = 0; i < m.pixels.rows; ++i)
    {
        Matx33d expected = Matx33d::eye() * (translation * translation);
        for (const Mat& derivative : derivatives)
            expected += row(derivative, i) * row(derivative, i).t();
        EXPECT_LT(largest(block(covariances, i) - expected), 1e-6 * largest(expected));
    }
}

TEST(ActiveHandEye_Measure, covariance_is_that_of_a_simulation)
{
    StripeScene scene = StripeScene::standard();
    scene.columnStep = 90;
    scene.shine();
    const Measurement m(scene, 22);
    const Matx20d A = errorFactor(m.light, 6);
    const int trials = 4000, points = m.pixels.rows;
    const double pixel = 0.1, translation = 5e-5, turn = 2e-4;
    const Mat truth = m.points(Measurement::BASE);
    const Mat covariances = m.covariances(Measurement::BASE, calibrationCovariance(A),
                                          Mat(points, 1, CV_64F, Scalar(pixel)), translation, turn);

    RNG rng(7);
    vector<Matx33d> sums(points, Matx33d::zeros());
    for (int trial = 0; trial < trials; ++trial)
    {
        Vec20d standard;
        for (int k = 0; k < 20; ++k)
            standard[k] = rng.gaussian(1);
        Measurement erroneous = m.corrected(A * standard);
        erroneous.pixels = m.pixels.clone();
        for (int i = 0; i < 2 * points; ++i)
            erroneous.pixels.ptr<double>()[i] += rng.gaussian(pixel);
        const Vec3d w(rng.gaussian(turn), rng.gaussian(turn), rng.gaussian(turn));
        erroneous.R_gripper2base = rotation(w) * m.R_gripper2base;
        for (int i = 0; i < 3; ++i)
            erroneous.t_gripper2base[i] += rng.gaussian(translation);
        const Mat measured = erroneous.points(Measurement::BASE);
        for (int i = 0; i < points; ++i)
        {
            const Vec3d error = row(measured, i) - row(truth, i);
            sums[i] += error * error.t();
        }
    }
    for (int i = 0; i < points; ++i)
    {
        const Matx33d predicted = block(covariances, i), found = sums[i] * (1. / trials);
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b)
            {
                const double scale = std::sqrt(predicted(a, a) * predicted(b, b));
                EXPECT_NEAR(found(a, b) / scale, predicted(a, b) / scale, 4.5 * std::sqrt(2. / trials)) << a << b;
            }
    }
}

TEST(ActiveHandEye_Measure, lengths_may_have_any_unit)
{
    const Measurement m(litScene(), 22);
    Measurement mm = m;
    mm.light[3] *= 1000;
    mm.t_cam2gripper *= 1000;
    mm.t_gripper2base *= 1000;
    const Mat difference = mm.points(Measurement::BASE) / 1000 - m.points(Measurement::BASE);
    EXPECT_LT(cv::norm(difference, NORM_INF), 1e-14);
}

TEST(ActiveHandEye_Measure, what_hangs_on_an_unobserved_parameter_has_infinite_variance)
{
    const Measurement m(litScene(), 22);
    Mat C = calibrationCovariance(errorFactor(m.light, 5));
    C.at<double>(15, 15) = infinity; // tz
    C.at<double>(15, 14) = -infinity;
    const Mat camera = m.covariances(Measurement::CAMERA, C), gripper = m.covariances(Measurement::GRIPPER, C);
    for (int i = 0; i < m.pixels.rows; ++i)
    {
        EXPECT_TRUE(cv::checkRange(Mat(block(camera, i))));
        const Matx33d c = block(gripper, i);
        EXPECT_EQ(infinity, c(2, 2));
        EXPECT_EQ(0, c(0, 2));
        EXPECT_EQ(0, c(2, 1));
        EXPECT_GT(c(0, 0), 0);
        EXPECT_LT(c(0, 0) + c(1, 1), 1e-4);
        EXPECT_NE(0, c(0, 1));
    }
}

TEST(ActiveHandEye_Measure, without_a_source_of_error_there_is_no_covariance)
{
    const Measurement m(litScene());
    EXPECT_TRUE(m.covariances(Measurement::BASE, noArray()).empty());
    EXPECT_EQ(3, m.covariances(Measurement::BASE, noArray(), noArray(), 1e-5).dims);
}

TEST(ActiveHandEye_Measure, no_stripe_gives_no_points)
{
    Measurement m(litScene());
    m.pixels = Mat();
    EXPECT_TRUE(m.points(Measurement::BASE).empty());
    EXPECT_TRUE(m.covariances(Measurement::BASE, Mat(Matx20d::eye()), 0.1).empty());
}

}} // namespace opencv_test
