// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "refine_scene.hpp"

#include "opencv2/core/utility.hpp"

namespace opencv_test { namespace {

using namespace refine;

void expectTruth(const RefineScene& scene, const Refinement& found)
{
    EXPECT_TRUE(found.summary.usable) << found.summary.message;
    EXPECT_LE(found.rms, 1e-9);
    EXPECT_LE(cv::norm(Matx33d(found.K) - scene.K), 1e-9 * cv::norm(scene.K));
    EXPECT_LE(cv::norm(found.D - scene.dist().t(), NORM_INF), 1e-8);
    EXPECT_LE(cv::norm(Matx33d(found.R_cam2gripper) - scene.R_cam2gripper), 1e-10);
    EXPECT_LE(cv::norm(found.translation() - scene.t_cam2gripper), 1e-9 * cv::norm(scene.t_cam2gripper));
    for (size_t j = 0; j < scene.X.size(); ++j)
        EXPECT_LE(cv::norm(Vec3d(found.summary.scenePoints.ptr<double>(int(j))) - scene.X[j]), 1e-8);
    EXPECT_LE(cv::norm(found.summary.residuals, NORM_INF), 1e-8);
    EXPECT_TRUE(found.summary.culprits.empty());
    EXPECT_TRUE(found.summary.rejectedViews.empty());
    EXPECT_EQ(0, cv::countNonZero(found.summary.rejectedObservations));
}

TEST(ActiveHandEye_Refine, exact_data_give_the_truth)
{
    const RefineScene scene = RefineScene::exact();
    const Refinement found = scene.refined();
    expectTruth(scene, found);
    EXPECT_EQ(int(LENS_FIXED), found.summary.lensModel);
    EXPECT_EQ(0, cv::norm(found.D));
    EXPECT_TRUE(found.light.empty());
}

TEST(ActiveHandEye_Refine, exact_data_give_lens_and_light_plane)
{
    RefineScene scene(2);
    const double D[] = {-0.2, 0.1, 0.001, -0.002, 0.05};
    std::copy(D, D + 5, scene.D);
    scene.addViews();
    scene.addSurfaces();
    scene.measure(0, 0, 0);
    const Refinement found = scene.refined();
    expectTruth(scene, found);
    EXPECT_EQ(int(LENS_K3), found.summary.lensModel);
    EXPECT_LE(cv::norm(found.light.rowRange(0, 3) - scene.trueLight().rowRange(0, 3)), 1e-9);
    EXPECT_NEAR(scene.lightOffset, found.light.at<double>(3), 1e-7);
    EXPECT_TRUE(found.summary.rejectedSegments.empty());
    EXPECT_EQ(Size(2, int(scene.stripes.size())), found.summary.stripeResiduals.size());
    EXPECT_LE(cv::norm(found.summary.stripeResiduals, NORM_INF), 1e-8);
}

//! Levels within their 95 % intervals in most of 12 trials; an interval is not always hit.
TEST(ActiveHandEye_Refine, noise_levels_are_recovered_with_their_intervals)
{
    const int trials = 12;
    const double truth[] = {0.1, 0.06 * std::sqrt(2. / 12), 0.05, 0.01 * CV_PI / 180}; // a segment counts as two points
    int hits[4] = {0, 0, 0, 0};
    double mean[4] = {0, 0, 0, 0};
    for (int trial = 0; trial < trials; ++trial)
    {
        RefineScene scene(100 + trial, 60);
        scene.addViews();
        scene.addSurfaces();
        scene.measure(0.1, 0.05, 0.01, 0.06);
        const Refinement found = scene.refined();
        EXPECT_TRUE(found.summary.usable) << found.summary.message;
        const RefineSummary& s = found.summary;
        const double levels[] = {s.pointSigma, s.stripeSigma, s.robotTranslationSigma, s.robotRotationSigma};
        for (int k = 0; k < 4; ++k)
        {
            const double* row = s.noiseLevels.ptr<double>(k);
            EXPECT_EQ(levels[k], row[0]);
            EXPECT_EQ(1, row[3]);
            hits[k] += row[1] < truth[k] && truth[k] < row[2];
            mean[k] += row[0] / truth[k] / trials;
        }
    }
    for (int k = 0; k < 4; ++k)
    {
        EXPECT_GE(hits[k], 9) << "level " << k; // 95 % of 12: fewer than 9 once in 400
        EXPECT_NEAR(1, mean[k], 0.15) << "level " << k;
    }
}

TEST(ActiveHandEye_Refine, deviations_tell_the_errors)
{
    double sum = 0;
    int count = 0;
    for (int trial = 0; trial < 12; ++trial)
    {
        const RefineScene scene = RefineScene::noisy(200 + trial);
        const Refinement found = scene.refined();
        EXPECT_LE(scene.worstError(found), 4.5) << trial;
        const Vec3d error = found.translation() - scene.t_cam2gripper;
        const char* const names[] = {"tx", "ty", "tz"};
        for (int i = 0; i < 3; ++i, ++count)
            sum += std::pow(error[i] / found.deviation(names[i]), 2);
        EXPECT_NEAR(std::sqrt(cv::trace(found.summary.covariance.rowRange(13, 16).colRange(13, 16))[0]), 0.2, 0.15);
    }
    EXPECT_NEAR(1, std::sqrt(sum / count), 0.4); // 36 squares: 12 %, and those of one trial hang together
}

TEST(ActiveHandEye_Refine, intervals_are_those_of_students_t)
{
    const Refinement found = RefineScene::noisy().refined();
    const RefineSummary& s = found.summary;
    const double K00 = found.K.at<double>(0, 0);
    const int fx = found.row("fx"), rx = found.row("rx"), skew = found.row("skew");
    const double half = 0.5 * (s.intervals95.at<double>(fx, 1) - s.intervals95.at<double>(fx, 0));
    EXPECT_NEAR(K00, 0.5 * (s.intervals95.at<double>(fx, 0) + s.intervals95.at<double>(fx, 1)), 1e-9 * K00);
    EXPECT_GT(half, 1.95996 * found.deviation("fx"));
    EXPECT_LT(half, 12.8 * found.deviation("fx"));
    EXPECT_NEAR(0, s.intervals95.at<double>(rx, 0) + s.intervals95.at<double>(rx, 1), 1e-15);
    EXPECT_EQ(s.intervals95.at<double>(skew, 0), s.intervals95.at<double>(skew, 1));
    EXPECT_TRUE(std::isinf(s.degreesOfFreedom.at<double>(skew)));
    EXPECT_GE(s.degreesOfFreedom.at<double>(fx), 1);
    for (int i = 0; i < 20; ++i)
        EXPECT_NEAR(std::sqrt(s.covariance.at<double>(i, i)), s.standardDeviations.at<double>(i), 1e-12);
    EXPECT_EQ(0, cv::norm(s.covariance, s.covariance.t(), NORM_INF) > 1e-12 * cv::norm(s.covariance, NORM_INF));
}

TEST(ActiveHandEye_Refine, a_start_of_the_users_leads_to_the_same_result)
{
    const RefineScene scene = RefineScene::noisy();
    const Refinement reference = scene.refined();
    Refinement other = scene.call();
    other.K = (Mat_<double>(3, 3) << 1390, 0, 325, 0, 1400, 235, 0, 0, 1);
    other.D = Mat::zeros(4, 1, CV_64F);
    other.R_cam2gripper = Mat(Matx33d(rotation(Vec3d(0.02, -0.02, 0.03)) * scene.R_cam2gripper));
    other.t_cam2gripper = Mat(Vec3d(scene.t_cam2gripper + Vec3d(8, -6, 10)));
    other.run();
    EXPECT_LE(cv::norm(other.K, reference.K), 0.02 * reference.deviation("fx"));
    EXPECT_LE(cv::norm(other.translation() - reference.translation()), 0.02 * reference.deviation("tz"));
    EXPECT_LE(angleDeg(other.R_cam2gripper, reference.R_cam2gripper), 0.02 * reference.deviation("rx") * 180 / CV_PI);
    for (int i = 0; i < 20; ++i)
        EXPECT_NEAR(reference.summary.standardDeviations.at<double>(i), other.summary.standardDeviations.at<double>(i),
                    0.01 * reference.summary.standardDeviations.at<double>(i));
    EXPECT_EQ(Size(1, 5), other.D.size());
}

void expectSameBytes(const Refinement& a, const Refinement& b)
{
    EXPECT_TRUE(sameBits(a.K, b.K) && sameBits(a.D, b.D) && sameBits(a.light, b.light));
    EXPECT_TRUE(sameBits(a.R_cam2gripper, b.R_cam2gripper) && sameBits(a.t_cam2gripper, b.t_cam2gripper));
    EXPECT_TRUE(sameBits(a.summary.covariance, b.summary.covariance) &&
                sameBits(a.summary.noiseLevels, b.summary.noiseLevels));
    EXPECT_TRUE(sameBits(a.summary.residuals, b.summary.residuals) &&
                sameBits(a.summary.scenePoints, b.summary.scenePoints));
    EXPECT_TRUE(sameBits(a.summary.poseCorrections, b.summary.poseCorrections) &&
                sameBits(a.summary.lensTests, b.summary.lensTests));
    EXPECT_EQ(a.rms, b.rms);
    EXPECT_EQ(a.summary.message, b.summary.message);
    EXPECT_EQ(a.summary.iterations, b.summary.iterations);
}

TEST(ActiveHandEye_Refine, the_same_input_gives_the_same_bytes)
{
    RefineScene scene(1);
    scene.addViews();
    scene.addSurfaces();
    scene.measure(0.1, 0.02, 0.005, 0.05);
    expectSameBytes(scene.refined(), scene.refined());
}

//! So many points that the work is divided.
TEST(ActiveHandEye_Refine, the_number_of_threads_does_not_matter)
{
    const RefineScene scene = RefineScene::noisy(1, 0.1, 0.02, 0.005, 4200);
    Refinement parallel = scene.call();
    parallel.K = Mat(scene.K).clone();
    parallel.R_cam2gripper = Mat(scene.R_cam2gripper).clone();
    parallel.t_cam2gripper = Mat(scene.t_cam2gripper).clone();
    parallel.params.lensModel = LENS_FIXED;
    Refinement single = parallel;
    for (Mat* start : {&single.K, &single.R_cam2gripper, &single.t_cam2gripper})
        *start = start->clone();
    parallel.run();
    const int threads = cv::getNumThreads();
    cv::setNumThreads(1);
    single.run();
    cv::setNumThreads(threads);
    expectSameBytes(parallel, single);
}

//! Relative differences of the results for metres and for millimetres.
struct UnitDifference
{
    explicit UnitDifference(const RefineScene& scene)
    {
        const Refinement a = scene.refined();
        Refinement b = scene.call();
        for (Mat& t : b.t)
            t *= 0.001;
        b.run();
        Mat unit = Mat::ones(20, 1, CV_64F);
        unit.rowRange(13, 16).setTo(1000);
        unit.row(19).setTo(1000);
        const Mat scaled = b.summary.covariance.mul(unit * unit.t()),
                  deviations = cv::max(a.summary.standardDeviations, 1e-300);
        camera = cv::norm(a.K, b.K) / cv::norm(a.K);
        handEye = cv::norm(a.R_cam2gripper, b.R_cam2gripper) +
                  cv::norm(a.translation() - 1000 * b.translation()) / cv::norm(a.translation());
        covariance = cv::norm((scaled - a.summary.covariance) / (deviations * deviations.t()), NORM_INF);
        levels = std::abs(std::log(1000 * b.summary.robotTranslationSigma / a.summary.robotTranslationSigma)) +
                 std::abs(std::log(b.summary.robotRotationSigma / a.summary.robotRotationSigma));
        scenePoints = cv::norm(a.summary.scenePoints, 1000 * b.summary.scenePoints) / cv::norm(a.summary.scenePoints);
        light = a.light.empty() ? 0 : std::abs(1000 * b.light.at<double>(3) / a.light.at<double>(3) - 1);
    }

    double camera, handEye, covariance, levels, scenePoints, light;
};

TEST(ActiveHandEye_Refine, the_result_scales_with_the_unit)
{
    // Rounding, which compilers do differently (clang 14: 2.4e-9 and 1.3e-8), decides where the iteration stops.
    const UnitDifference points(RefineScene::noisy(3));
    EXPECT_LE(points.camera, 1e-9);
    EXPECT_LE(points.handEye, 1e-8);
    EXPECT_LE(points.scenePoints, 1e-9);
    EXPECT_LE(points.covariance, 1e-7);
    EXPECT_LE(points.levels, 1e-7);

    // A surface is four numbers (w, e) of length 1, so its steps hang on the unit, and where the iteration stops with them.
    RefineScene scene(5);
    scene.addViews();
    scene.addSurfaces();
    scene.measure(0.1, 0.02, 0.005, 0.05);
    const UnitDifference stripes(scene);
    EXPECT_LE(stripes.camera, 1e-7);
    EXPECT_LE(stripes.handEye, 1e-7);
    EXPECT_LE(stripes.light, 1e-7);
    EXPECT_LE(stripes.covariance, 1e-5);
    EXPECT_LE(stripes.levels, 1e-5);
}

}} // namespace opencv_test
