// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Steps of the joint refinement, its cost, and Huber's loss.
#include "dense_model.hpp"

#include "../src/decompositions.hpp"

namespace opencv_test { namespace {

VectorXd randomStep(int size, double half, uint64 seed)
{
    RNG rng(seed);
    VectorXd step(size);
    for (int i = 0; i < size; ++i)
        step(i) = rng.uniform(-half, half);
    return step;
}

//! Points to where their images pull them.
void settlePoints(RefineProblem& problem)
{
    for (int round = 0; round < 60; ++round)
    {
        problem.costAfter(VectorXd::Zero(problem.unknowns.count()));
        problem.apply(VectorXd::Zero(problem.unknowns.count()));
    }
}

Contents withClipping()
{
    Contents contents;
    contents.knownPoints = 4;
    contents.sameSigmas = false;
    contents.huberThreshold = 1.2; // clips a third of Gaussian errors
    return contents;
}

TEST(ActiveHandEye_RefineProblem, poses_that_undo_a_hand_eye_step_leave_every_camera_where_it_is)
{
    SmallProblem small;
    RefineProblem& problem = small.problem;
    const CameraViews before = problem.state.views();
    VectorXd step = VectorXd::Zero(problem.unknowns.count());
    const Vector3d turn(0.2, -0.3, 0.1), shift(0.05, 0.02, -0.04);
    step.segment<3>(COLUMN_ROTATION) = turn;
    step.segment<3>(COLUMN_TRANSLATION) = shift;
    for (int view = 0; view < int(before.size()); ++view)
    {
        const Pose& pose = problem.state.gripper2base[view];
        const Vector3d arm = pose.R * problem.state.calibration.cam2gripper.t, back = -pose.R * turn;
        step.segment<3>(problem.unknowns.poseColumn(view)) = back;
        step.segment<3>(problem.unknowns.poseColumn(view) + 3) = -back.cross(arm) - pose.R * shift;
    }
    const double cost = problem.costAfter(VectorXd::Zero(step.size()));
    problem.costAfter(step);
    problem.apply(step);
    const CameraViews after = problem.state.views();
    for (size_t view = 0; view < before.size(); ++view)
    {
        EXPECT_LE((after[view].R_cam2base - before[view].R_cam2base).norm(), 1e-13);
        EXPECT_LE((after[view].centre - before[view].centre).norm(), 1e-13);
        EXPECT_GT((problem.state.gripper2base[view].R - problem.reported[view].R).norm(), 0.1) << "the robot did move";
    }
    EXPECT_GT(problem.costAfter(VectorXd::Zero(step.size())), 1e3 * cost) << "which its prior sees";
}

TEST(ActiveHandEye_RefineProblem, small_steps_go_where_the_columns_say)
{
    Contents contents;
    contents.knownPoints = 4;
    contents.surfaces = 2;
    SmallProblem small(contents);
    RefineProblem& problem = small.problem;
    problem.unknowns.poses[3] = POSE_EXACT;
    const CalibrationState before = problem.state;
    const double size = 1e-4;
    const VectorXd step = randomStep(problem.unknowns.count(), size, 3);
    problem.costAfter(step);
    problem.apply(step);
    const CalibrationState& after = problem.state;
    const double second = 20 * size * size;
    for (int view : {0, 1, 2, 4, 5})
    {
        const Pose expected = moved(before.gripper2base[view], step.segment<6>(problem.unknowns.poseColumn(view)));
        EXPECT_LE((after.gripper2base[view].R - expected.R).norm(), second);
        EXPECT_LE((after.gripper2base[view].t - expected.t).norm(), second);
        EXPECT_LE((after.gripper2base[view].R.transpose() * after.gripper2base[view].R - Matrix3d::Identity()).norm(),
                  1e-14);
    }
    EXPECT_EQ(before.gripper2base[3].R, after.gripper2base[3].R);
    EXPECT_EQ(before.gripper2base[3].t, after.gripper2base[3].t);
    const Pose object = moved(before.object2base, step.segment<6>(problem.unknowns.objectColumn()));
    EXPECT_LE((after.object2base.R - object.R).norm() + (after.object2base.t - object.t).norm(), 1e-15);
    for (int track = 0; track < small.tracks().count(); ++track)
    {
        const Vector3d& known = small.tracks().known[track];
        EXPECT_LE(known.allFinite() ? (after.points[track] - object.R * known - object.t).norm() : 0, 1e-15);
    }
    for (int s = 0; s < 2; ++s)
    {
        const Vector3d moves = step.segment<3>(problem.unknowns.surfaceColumn(s));
        EXPECT_LE((after.surfaces[s] - before.surfaces[s] - surfaceTangent(before.surfaces[s]) * moves).norm(), second);
        EXPECT_NEAR(1, after.surfaces[s].norm(), 1e-15);
    }
}

//! Steps with the weights of Huber's loss would still be on their way.
TEST(ActiveHandEye_RefineProblem, clipped_points_are_at_their_optimum_after_one_step)
{
    Contents contents = withClipping();
    contents.knownPoints = 0;
    contents.views = 4;
    contents.freePoints = 60;
    SmallProblem small(contents);
    RefineProblem& problem = small.problem;
    const VectorXd none = VectorXd::Zero(problem.unknowns.count());
    const double cost = problem.costAfter(none);
    problem.apply(none);
    settlePoints(problem);
    EXPECT_NEAR(problem.costAfter(none), cost, 1e-8);
}

//! The derivative of the cost, with the points following, is 2 J^T r.
TEST(ActiveHandEye_RefineProblem, the_gradient_is_that_of_the_cost)
{
    Contents contents = withClipping();
    contents.huberThreshold = 1e9;
    SmallProblem small(contents);
    RefineProblem& problem = small.problem;
    problem.unknowns.poses[1] = POSE_FREE;
    settlePoints(problem);
    MatrixXd JtJ;
    VectorXd Jtr;
    const double cost = problem.linearize(JtJ, Jtr);
    EXPECT_NEAR(problem.costAfter(VectorXd::Zero(Jtr.size())), cost, 1e-10 * cost);
    const VectorXd deviations = JtJ.diagonal().cwiseSqrt().cwiseInverse();
    const MatrixXd slope = differentiate([&](const VectorXd& step)
                                         { return VectorXd::Constant(1, problem.costAfter(step)); }, 1e-3 * deviations);
    const VectorXd difference = (slope.transpose() - 2 * Jtr).cwiseProduct(deviations);
    EXPECT_LE(difference.cwiseAbs().maxCoeff(), 1e-4 * std::sqrt(cost)) << difference.transpose();
    EXPECT_GT(Jtr.cwiseProduct(deviations).norm(), 0.1) << "not at the optimum";
}

//! The lengths of the derivatives that Huber's loss leaves, averaged over the two directions of the image.
double slopeOfHuber(const Vector2d& error, double limit)
{
    const auto clipped = [&](const VectorXd& step)
    {
        const Vector2d e = error + step;
        return VectorXd(e * std::min(1., limit / e.norm()));
    };
    return 0.5 * differentiate(clipped, VectorXd::Constant(2, 1e-6)).trace();
}

//! Clipped residuals divided by the mean of their slopes (Huber's modified residuals).
VectorXd modified(VectorXd errors, double limit, int& clipped)
{
    double slopes = 0;
    clipped = 0;
    for (int i = 0; i < errors.size(); i += 2)
    {
        const Vector2d error = errors.segment<2>(i);
        slopes += slopeOfHuber(error, limit);
        clipped += error.norm() > limit;
        errors.segment<2>(i) = error * std::min(1., limit / error.norm());
    }
    return errors * (0.5 * double(errors.size()) / slopes);
}

TEST(ActiveHandEye_RefineProblem, clipped_residuals_are_divided_by_their_mean_slope)
{
    SmallProblem small(withClipping());
    RefineProblem& problem = small.problem;
    problem.updateClipping();
    problem.linearizeData();
    const DenseModel model(problem);
    int clipped;
    const VectorXd errors = modified(model.pointErrors, 1.2 * problem.noise.point, clipped);
    EXPECT_GT(clipped, 10);
    expectSameTerm(eliminated(model, model.byPoints, errors), problem.points(), 1e-6);
}

//! Newton's step to the minimum of Huber's cost over all unknowns, in standard deviations.
VectorXd wayToTheMinimum(const RefineProblem& problem, double limit)
{
    const DenseModel model(problem);
    int clipped;
    const double information = 1 / (problem.noise.point * problem.noise.point);
    MatrixXd H = information * model.byPoints.transpose() * model.byPoints;
    VectorXd gradient = information * model.byPoints.transpose() * modified(model.pointErrors, limit, clipped),
             corrections;
    EXPECT_GT(clipped, 5);
    std::vector<int> columns;
    std::vector<bool> isRotation;
    model.priors(corrections, columns, isRotation);
    for (size_t i = 0; i < columns.size(); ++i)
    {
        const double sigma = isRotation[i] ? problem.noise.rotation : problem.noise.translation;
        H(columns[i], columns[i]) += 1 / (sigma * sigma);
        gradient(columns[i]) += corrections(i) / (sigma * sigma);
    }
    const VectorXd scale = H.diagonal().cwiseSqrt().cwiseInverse();
    const MatrixXd inverse = inverseOfSymmetric(scale.asDiagonal() * H * scale.asDiagonal());
    return (inverse * scale.cwiseProduct(gradient)).cwiseQuotient(inverse.diagonal().cwiseSqrt());
}

TEST(ActiveHandEye_RefineProblem, the_solution_is_where_hubers_loss_is_least)
{
    Contents contents;
    contents.views = 10;
    contents.freePoints = 60;
    contents.huberThreshold = 2.5;
    SmallProblem small(contents);
    RefineProblem& problem = small.problem;
    const int reduced = problem.unknowns.count();
    EXPECT_GT(wayToTheMinimum(problem, 2.5 * contents.pixelNoise).head(reduced).cwiseAbs().maxCoeff(), 0.5)
        << "not there yet";
    for (int round = 0; round < 4; ++round)
    {
        problem.updateClipping();
        EXPECT_TRUE(solveLeastSquares(problem, 50, 1e-14).converged);
    }
    problem.updateClipping();
    const VectorXd left = wayToTheMinimum(problem, 2.5 * contents.pixelNoise);
    EXPECT_LE(left.head(reduced).cwiseAbs().maxCoeff(), 1e-3);
    EXPECT_LE(left.tail(left.size() - reduced).cwiseAbs().maxCoeff(), 0.05)
        << "points make one robust step in each round";
}

TEST(ActiveHandEye_RefineProblem, without_clipping_nothing_is_divided)
{
    SmallProblem small;
    small.problem.linearizeData();
    const double squares = small.problem.points().squares;
    small.problem.updateClipping();
    small.problem.linearizeData();
    EXPECT_EQ(squares, small.problem.points().squares);
}

TEST(ActiveHandEye_RefineProblem, steps_out_of_the_domain_cost_infinitely)
{
    Contents contents;
    contents.surfaces = 2;
    SmallProblem small(contents);
    VectorXd step = VectorXd::Zero(small.problem.unknowns.count());
    EXPECT_TRUE(std::isfinite(small.problem.costAfter(step)));
    step(COLUMN_FX) = -2000;
    EXPECT_TRUE(std::isinf(small.problem.costAfter(step)));
    step(COLUMN_FX) = 0;
    step(COLUMN_OFFSET) = -2 * small.problem.state.calibration.light.d;
    EXPECT_TRUE(std::isinf(small.problem.costAfter(step))) << "a light plane behind the camera";
}

}} // namespace opencv_test
