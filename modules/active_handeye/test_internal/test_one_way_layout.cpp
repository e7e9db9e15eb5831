// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Variance components and their degrees of freedom where the answer is known: a one-way layout.
#include "small_problem.hpp"

#include "../src/noise_levels.hpp"

namespace opencv_test { namespace {

/** Views from one place of an object of known shape and unknown pose; the robot's position varies by chance.

G is the derivative of a view's pixels by a translation; G^T G = I / c for a ring of points seen 45 degrees off the axis. View i
measures G (object + a_i) + noise: the balanced one-way layout with 3 (views - 1) degrees of freedom between the views.
*/
struct OneWayLayout
{
    OneWayLayout(int views_, int points_, double pixelNoise, double positionNoise, uint64 seed)
        : views(views_), points(points_), reported(views_, Pose{Matrix3d::Identity(), Vector3d::Zero()}),
          state(makeState()), imagePoints(measure(pixelNoise, positionNoise, seed)),
          tracks(imagePoints, std::vector<std::vector<double>>(), ring()),
          problem(tracks, segments, reported, state, 1e9)
    {
        problem.noise = NoiseLevels{pixelNoise, 1, positionNoise, 1e-9};
        problem.unknowns.calibration.resize(CALIBRATION_COLUMNS, 0);
        problem.unknowns.object = true;
        problem.unknowns.poses.assign(views, POSE_PRIOR);
        problem.linearizeData();
    }

    //! Derivatives of one view's pixels by the object's pose: 3 columns for its rotation, 3 for its translation = G.
    MatrixXd byObject() const
    {
        const CameraView view(reported[0], state.calibration.cam2gripper);
        MatrixXd result(2 * points, 6);
        for (int j = 0; j < points; ++j)
        {
            PointResidual residual;
            residual.linearize(state.calibration.camera, view, state.points[j], imagePoints[0][j]);
            result.block<2, 3>(2 * j, 0) = residual.byPoint * skew(state.object2base.t - state.points[j]);
            result.block<2, 3>(2 * j, 3) = residual.byPoint;
        }
        return result;
    }

    //! Measured - predicted, one column per view.
    MatrixXd errors() const
    {
        MatrixXd result(2 * points, views);
        for (int view = 0; view < views; ++view)
            for (int j = 0; j < points; ++j)
                result.block<2, 1>(2 * j, view) =
                    imagePoints[view][j] - state.calibration.camera.project(state.points[j]);
        return result;
    }

    //! Derivative by the object's pose of what the mean image says about its position along x.
    VectorXd meanPosition() const
    {
        const MatrixXd byPose = byObject(), G = byPose.rightCols<3>();
        VectorXd result = VectorXd::Zero(problem.unknowns.count());
        result.head<6>() = byPose.transpose() * G.col(0) / G.col(0).squaredNorm();
        return result;
    }

    const int views, points;
    const AlignedVector<Pose> reported;
    const CalibrationState state;
    const std::vector<Pixels> imagePoints;
    SceneTracks tracks;
    StripeSegments segments;
    RefineProblem problem;

private:
    OneWayLayout(const OneWayLayout&);
    OneWayLayout& operator=(const OneWayLayout&);

    AlignedVector<Vector3d> ring() const
    {
        AlignedVector<Vector3d> result;
        for (int j = 0; j < points; ++j)
            result.push_back(Vector3d(std::cos(2 * CV_PI * j / points), std::sin(2 * CV_PI * j / points), 0));
        return result;
    }

    CalibrationState makeState() const
    {
        CalibrationState result;
        result.calibration.camera.K = Vector3d(300, 300, 1).asDiagonal();
        result.object2base.t = Vector3d::UnitZ();
        result.gripper2base = reported;
        for (const Vector3d& X : ring())
            result.points.push_back(X + Vector3d::UnitZ());
        return result;
    }

    std::vector<Pixels> measure(double pixelNoise, double positionNoise, uint64 seed) const
    {
        RNG rng(seed);
        std::vector<Pixels> result(views);
        for (Pixels& image : result)
        {
            const Vector3d position = gaussianVector(rng, positionNoise);
            for (const Vector3d& X : state.points)
            {
                const double dx = rng.gaussian(pixelNoise), dy = rng.gaussian(pixelNoise);
                image.push_back(state.calibration.camera.project(X - position) + Vector2d(dx, dy));
            }
        }
        return result;
    }
};

const bool rotationFixed[] = {false, true, false, true};
const double floors[] = {1e-12, 1e-12, 1e-12, 1e-12};

TEST(ActiveHandEye_OneWayLayout, satterthwaite_is_exact_between_the_views)
{
    for (int views : {3, 6, 11})
        for (double positionNoise : {1e-5, 1e-4, 1e-2})
        {
            const OneWayLayout layout(views, 8, 0.1, positionNoise, 1);
            const VarianceComponents components(layout.problem, rotationFixed, floors);
            const VectorXd J = layout.meanPosition();
            const double c = 1 / layout.byObject().col(3).squaredNorm();
            const double expected = (c * 0.1 * 0.1 + positionNoise * positionNoise) / views;
            EXPECT_NEAR(expected, J.dot(components.covariance() * J), 1e-6 * expected);
            EXPECT_NEAR(3 * (views - 1), components.degreesOfFreedom(J), 1e-3 * views)
                << views << " views, " << positionNoise;
        }
}

//! With one level given the variance is known as well as the other one is; with both it is known.
TEST(ActiveHandEye_OneWayLayout, degrees_of_freedom_grow_with_what_is_given)
{
    const OneWayLayout layout(6, 8, 0.1, 1e-2, 1);
    const bool allFixed[] = {true, true, true, true};
    const VarianceComponents known(layout.problem, allFixed, floors);
    EXPECT_TRUE(std::isinf(known.degreesOfFreedom(layout.meanPosition())));
    const bool robotFixed[] = {false, true, true, true};
    const VarianceComponents pixel(layout.problem, robotFixed, floors);
    EXPECT_GT(pixel.degreesOfFreedom(layout.meanPosition()), 1e6) << "image noise hardly matters here";
}

TEST(ActiveHandEye_OneWayLayout, reml_is_the_analysis_of_variance)
{
    for (uint64 seed = 1; seed <= 5; ++seed)
    {
        const OneWayLayout layout(6, 8, 0.1, 3e-4, seed);
        VarianceComponents components(layout.problem, rotationFixed, floors);
        components.estimate();
        const MatrixXd byPose = layout.byObject(), G = byPose.rightCols<3>(), y = layout.errors();
        const VectorXd mean = y.rowwise().mean();
        const double c = 1 / G.col(0).squaredNorm();
        ASSERT_LE((c * G.transpose() * G - Matrix3d::Identity()).norm(), 1e-9);
        const MatrixXd centred = y.colwise() - mean;
        const double between = c * (G.transpose() * centred).squaredNorm();
        const VectorXd restOfMean = mean - byPose * byPose.colPivHouseholderQr().solve(mean);
        const double within = centred.squaredNorm() - between + layout.views * restOfMean.squaredNorm();
        const double image = within / (layout.views * (2 * layout.points - 3) - 3); // 3: the rotation of the object
        const double robot = c * (between / (3 * (layout.views - 1)) - image);
        ASSERT_GT(robot, 0);
        EXPECT_NEAR(std::sqrt(image), components.levels().point, 1e-4 * std::sqrt(image));
        EXPECT_NEAR(std::sqrt(robot), components.levels().translation, 1e-3 * std::sqrt(robot));
    }
}

}} // namespace opencv_test
