// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Stripes of planned views against the refinement of the same stripes, and the search's sum over views.
#include "small_problem.hpp"

#include "../src/decompositions.hpp"
#include "../src/planned_views.hpp"
#include "../src/view_choice.hpp"

#include "opencv2/active_handeye.hpp"

namespace opencv_test { namespace {

using cv::Mat;

struct PlannedScene
{
    PlannedScene()
    {
        RNG rng(3);
        scene.calibration = someCalibration();
        std::fill(scene.calibration.camera.D, scene.calibration.camera.D + 5, 0.);
        scene.calibration.camera.K(0, 1) = 0;
        scene.imageSize = cv::Size(640, 480);
        for (int j = 0; j < 60; ++j)
            scene.points.push_back(Vector3d(0.3, 0, 0) + randomVector(rng, 0.08));
        scene.surfaces.push_back(Vector4d(0, 0, 1, -0.02).normalized());
        scene.surfaces.push_back(Vector4d(0.3, 0.1, 1, 0.06).normalized());
        for (int view = 0; view < 10; ++view)
            poses.push_back(somePose(rng, scene.calibration.cam2gripper));
        for (int i = 0; i < 8; ++i) // translations
            poses.push_back(Pose{poses[i / 4].R, poses[i / 4].t + randomVector(rng, 0.05)});
    }

    AssumedScene scene;
    AlignedVector<Pose> poses;
};

template <typename Derived>
Mat toMat(const Eigen::MatrixBase<Derived>& matrix)
{
    Mat result;
    writeMatrix(matrix, result);
    return result;
}

TEST(ActiveHandEye_PlannedViews, light_plane_is_predicted_as_the_refinement_of_these_stripes_states_it)
{
    const PlannedScene planned;
    const HandEyeCalibration& truth = planned.scene.calibration;
    std::vector<Mat> R, t, pixels, stripes;
    std::vector<int> views, surfaces;
    for (const Pose& pose : planned.poses)
    {
        R.push_back(toMat(pose.R));
        t.push_back(toMat(pose.t));
        Eigen::MatrixXd seen(planned.scene.points.size(), 2);
        const Pixels all = planned.scene.project(planned.scene.view(pose));
        for (size_t j = 0; j < all.size(); ++j)
            seen.row(j) = all[j];
        pixels.push_back(toMat(seen));
    }
    for (const StripeSegment& segment : planned.scene.stripes(planned.poses))
    {
        Eigen::Matrix2d ends;
        ends << segment.ends[0].transpose(), segment.ends[1].transpose();
        stripes.push_back(toMat(ends));
        views.push_back(segment.view);
        surfaces.push_back(segment.surface);
    }
    RefineParams params;
    params.lensModel = LENS_FIXED;
    params.pointSigma = 0.1;
    params.stripeSigma = 0.05;
    params.robotTranslationSigma = 2e-5;
    params.robotRotationSigma = 1e-4;
    Mat K = toMat(truth.camera.K), D, Rx = toMat(truth.cam2gripper.R), tx = toMat(truth.cam2gripper.t);
    Mat light = toMat((Vector4d() << truth.light.n, truth.light.d).finished());
    RefineSummary summary;
    const Mat unitSigmas = Mat::ones(int(stripes.size()), 1, CV_64F);
    const Mat givenK = K.clone(), givenR = Rx.clone(), givenT = tx.clone(), givenLight = light.clone();
    refineHandEye(R, t, pixels, K, D, Rx, tx, light, summary, stripes, views, surfaces, cv::noArray(), cv::noArray(),
                  unitSigmas, params);

    Eigen::MatrixXd points(planned.scene.points.size(), 3), planes(planned.scene.surfaces.size(), 4);
    for (size_t j = 0; j < planned.scene.points.size(); ++j)
        points.row(j) = planned.scene.points[j];
    for (size_t s = 0; s < planned.scene.surfaces.size(); ++s)
        planes.row(s) = planned.scene.surfaces[s];
    Mat covariance, seen;
    std::vector<std::string> weak;
    predictHandEyeCovariance(R, t, toMat(points), planned.scene.imageSize, givenK, cv::noArray(), givenR, givenT,
                             covariance, weak, seen, givenLight, toMat(planes), params);
    ASSERT_TRUE(summary.rejectedSegments.empty());
    for (int i = 0; i < 20; ++i)
    {
        const double stated = summary.standardDeviations.at<double>(i);
        EXPECT_NEAR(stated, std::sqrt(covariance.at<double>(i, i)), 1e-4 * stated) << summary.parameterNames[i];
    }
    EXPECT_GT(covariance.at<double>(19, 19), 0);
}

//! The search adds up over views what the refinement eliminates over points: the same covariance, but for its prior.
TEST(ActiveHandEye_PlannedViews, information_of_the_search_adds_up_to_the_refinement)
{
    PlannedScene planned;
    planned.scene.surfaces.clear();
    std::vector<Pixels> pixels;
    for (const Pose& pose : planned.poses)
        pixels.push_back(planned.scene.project(planned.scene.view(pose)));
    SceneTracks tracks(pixels, std::vector<std::vector<double>>(), AlignedVector<Vector3d>());
    StripeSegments segments;
    CalibrationState state;
    state.calibration = planned.scene.calibration;
    state.gripper2base = planned.poses;
    for (int column : tracks.column)
        state.points.push_back(planned.scene.points[column]);
    RefineProblem problem(tracks, segments, planned.poses, state, 2.5);
    problem.noise = NoiseLevels{0.1, 0.05, 2e-5, 1e-4};
    const int columns[] = {COLUMN_FX, COLUMN_FY, COLUMN_CX, COLUMN_CY};
    problem.unknowns.calibration = MatrixXd::Zero(CALIBRATION_COLUMNS, 10);
    for (int i = 0; i < 4; ++i)
        problem.unknowns.calibration(columns[i], i) = 1;
    problem.unknowns.calibration.block<6, 6>(COLUMN_ROTATION, 4).setIdentity();
    for (const PoseFreedom freedom : {POSE_PRIOR, POSE_EXACT})
    {
        problem.unknowns.poses.assign(planned.poses.size(), freedom);
        MatrixXd JtJ;
        VectorXd Jtr;
        problem.linearize(JtJ, Jtr);
        const MatrixXd covariance = inverseOfSymmetric(JtJ);
        const ViewInformation information(problem, planned.scene, int(planned.scene.points.size()));
        MatrixXd sum = 1e-9 * information.prior(0.5, 0.3);
        for (int view = 0; view < int(planned.poses.size()); ++view)
            sum += information.of(view);
        const double expected = covariance.block<3, 3>(7, 7).trace();
        EXPECT_NEAR(expected, information.variance(sum), 1e-4 * expected) << freedom;
    }
}

}} // namespace opencv_test
