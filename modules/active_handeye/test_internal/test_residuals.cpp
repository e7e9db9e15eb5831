// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Analytic derivatives of the residuals against numerical ones, column by column.
#include "dense_model.hpp"

namespace opencv_test { namespace {

const char* const columnNames[] = {"fx", "fy", "cx", "cy", "skew", "k1", "k2", "p1", "p2", "k3",
                                   "rx", "ry", "rz", "tx", "ty",   "tz", "n1", "n2", "d"};

//! Every column within this share of its largest entry; columns that are all zero must be so in both.
void expectSameColumns(const MatrixXd& analytic, const MatrixXd& numeric, double tolerance, const char* const* names)
{
    ASSERT_EQ(numeric.rows(), analytic.rows());
    ASSERT_EQ(numeric.cols(), analytic.cols());
    for (int i = 0; i < numeric.cols(); ++i)
        EXPECT_LE((analytic.col(i) - numeric.col(i)).cwiseAbs().maxCoeff(),
                  tolerance * numeric.col(i).cwiseAbs().maxCoeff())
            << (names ? names[i] : "column ") << (names ? "" : std::to_string(i)) << "\nanalytic "
            << analytic.col(i).transpose() << "\nnumeric " << numeric.col(i).transpose();
}

struct PointCase
{
    PointCase() : rng(3)
    {
        calibration = someCalibration();
        gripper2base = somePose(rng, calibration.cam2gripper);
        X = Vector3d(0.3, 0, 0) + randomVector(rng, 0.06);
        pixel = Vector2d(300 + rng.uniform(-10., 10.), 200 + rng.uniform(-10., 10.));
    }

    VectorXd error(const CalibrationStep& step, const Vector6d& poseStep, const Vector3d& pointStep) const
    {
        const HandEyeCalibration c = calibration.moved(step);
        const CameraView view(moved(gripper2base, poseStep), c.cam2gripper);
        return c.camera.project(view.toCamera(X + pointStep)) - pixel;
    }

    PointResidual analytic() const
    {
        PointResidual residual;
        EXPECT_TRUE(residual.linearize(calibration.camera, CameraView(gripper2base, calibration.cam2gripper), X,
                                       pixel));
        return residual;
    }

    RNG rng;
    HandEyeCalibration calibration;
    Pose gripper2base;
    Vector3d X;
    Vector2d pixel;
};

TEST(ActiveHandEye_Residuals, point_by_calibration)
{
    const PointCase c;
    const MatrixXd numeric =
        differentiate([&](const VectorXd& step) { return c.error(step, Vector6d::Zero(), Vector3d::Zero()); },
                      calibrationSteps());
    const PointResidual residual = c.analytic();
    EXPECT_LE((residual.error - c.error(CalibrationStep::Zero(), Vector6d::Zero(), Vector3d::Zero())).norm(), 1e-10);
    EXPECT_EQ(0, numeric.rightCols(CALIBRATION_COLUMNS - POINT_COLUMNS).norm())
        << "the light plane does not move points";
    EXPECT_GT(numeric.leftCols<POINT_COLUMNS>().cwiseAbs().colwise().maxCoeff().minCoeff(), 0) << "all others do";
    expectSameColumns(residual.byCalibration, numeric.leftCols<POINT_COLUMNS>(), 1e-8, columnNames);
}

TEST(ActiveHandEye_Residuals, point_by_itself_and_by_the_pose)
{
    const PointCase c;
    const PointResidual residual = c.analytic();
    const MatrixXd byPoint =
        differentiate([&](const VectorXd& step) { return c.error(CalibrationStep::Zero(), Vector6d::Zero(), step); },
                      VectorXd::Constant(3, 1e-4));
    expectSameColumns(residual.byPoint, byPoint, 1e-8, 0);
    PointResidual pointOnly;
    ASSERT_TRUE(pointOnly.linearizePoint(c.calibration.camera, CameraView(c.gripper2base, c.calibration.cam2gripper),
                                         c.X, c.pixel));
    EXPECT_EQ(residual.byPoint, pointOnly.byPoint);
    EXPECT_EQ(residual.error, pointOnly.error);

    const MatrixXd byPose =
        differentiate([&](const VectorXd& step) { return c.error(CalibrationStep::Zero(), step, Vector3d::Zero()); },
                      VectorXd::Constant(6, 1e-4));
    Eigen::Matrix<double, 3, 6> motion; // of the point, as the header says
    motion << skew(c.X - c.gripper2base.t), -Matrix3d::Identity();
    expectSameColumns(residual.byPoint * motion, byPose, 1e-8, 0);
}

TEST(ActiveHandEye_Residuals, points_behind_the_camera_have_none)
{
    PointCase c;
    const CameraView view(c.gripper2base, c.calibration.cam2gripper);
    const Vector3d behind = view.centre - 0.2 * view.R_cam2base.col(2);
    PointResidual residual;
    Vector2d error;
    EXPECT_FALSE(residual.linearize(c.calibration.camera, view, behind, c.pixel));
    EXPECT_FALSE(residual.linearizePoint(c.calibration.camera, view, behind, c.pixel));
    EXPECT_FALSE(PointResidual::evaluate(c.calibration.camera, view, behind, c.pixel, error));
    EXPECT_FALSE(PointResidual::evaluate(c.calibration.camera, view, view.centre, c.pixel, error));
    EXPECT_TRUE(PointResidual::evaluate(c.calibration.camera, view, c.X, c.pixel, error));
}

struct StripeCase
{
    //! off: how far the pixel is from the stripe.
    explicit StripeCase(double off) : rng(8)
    {
        calibration = someCalibration();
        gripper2base = somePose(rng, calibration.cam2gripper);
        const Vector3d w = Vector3d(0.2, -0.1, 1).normalized();
        surface << w, w.dot(Vector3d(0.3, 0, 0)) + 0.01;
        surface.normalize();
        pixel = stripePixel(calibration, CameraView(gripper2base, calibration.cam2gripper), surface, 0.14) +
                Vector2d(0, off);
    }

    //! Distance from the line in which the planes of laser and surface meet, in pixels as large as `pixelSize` says.
    VectorXd error(const CalibrationStep& step, const Vector6d& poseStep, const Vector4d& surfaceStep,
                   const Matrix3d& pixelSize) const
    {
        const HandEyeCalibration c = calibration.moved(step);
        const CameraView view(moved(gripper2base, poseStep), c.cam2gripper);
        const Vector4d moved = surface + surfaceStep;
        const Vector3d w = view.R_base2cam * moved.head<3>();
        const Vector3d line = (moved(3) - moved.head<3>().dot(view.centre)) * c.light.n - c.light.d * w;
        const Vector2d perPixel = pixelSize.topLeftCorner<2, 2>().inverse().transpose() * line.head<2>();
        return VectorXd::Constant(1, line.dot(c.camera.ray(pixel)) / perPixel.norm());
    }

    MatrixXd byCalibration(bool changesPixelSize) const
    {
        return differentiate(
            [&](const VectorXd& step)
            {
                const Matrix3d K = changesPixelSize ? calibration.moved(step).camera.K : calibration.camera.K;
                return error(step, Vector6d::Zero(), Vector4d::Zero(), K);
            },
            calibrationSteps());
    }

    StripeResidual analytic() const
    {
        StripeResidual residual;
        EXPECT_TRUE(residual.linearize(calibration, CameraView(gripper2base, calibration.cam2gripper), surface, pixel));
        return residual;
    }

    void expectDerivatives() const
    {
        const StripeResidual residual = analytic();
        const CalibrationStep stays = CalibrationStep::Zero();
        const Matrix3d& K = calibration.camera.K;
        EXPECT_NEAR(error(stays, Vector6d::Zero(), Vector4d::Zero(), K)(0), residual.error, 1e-10);
        const MatrixXd numeric = byCalibration(false);
        EXPECT_GT(numeric.cwiseAbs().minCoeff(), 0) << "every parameter moves the stripe";
        expectSameColumns(residual.byCalibration, numeric, 1e-7, columnNames);
        const MatrixXd byPose =
            differentiate([&](const VectorXd& step) { return error(stays, step, Vector4d::Zero(), K); },
                          VectorXd::Constant(6, 1e-4));
        expectSameColumns(residual.byPose, byPose, 1e-7, 0);
        const MatrixXd bySurface =
            differentiate([&](const VectorXd& step) { return error(stays, Vector6d::Zero(), step, K); },
                          VectorXd::Constant(4, 1e-4));
        expectSameColumns(residual.bySurface, bySurface, 1e-7, 0);
    }

    RNG rng;
    HandEyeCalibration calibration;
    Pose gripper2base;
    Vector4d surface;
    Vector2d pixel;
};

TEST(ActiveHandEye_Residuals, stripe_by_everything)
{
    StripeCase(0).expectDerivatives();
    StripeCase(1.5).expectDerivatives();
}

//! K also says how large a pixel is. That part of the derivative is left out: a camera is not the better for larger pixels.
TEST(ActiveHandEye_Residuals, stripe_off_its_prediction_has_the_pixel_size_kept)
{
    const StripeCase c(1.5);
    const MatrixXd all = c.byCalibration(true), kept = c.byCalibration(false);
    EXPECT_LE((all - kept).rightCols<14>().norm(), 1e-12 * kept.norm());
    EXPECT_LE((all - kept).cwiseAbs().maxCoeff(), 1.01 * std::abs(c.analytic().error) / c.calibration.camera.K(0, 0));
    EXPECT_GT((all - kept).norm(), 0);
}

TEST(ActiveHandEye_Residuals, a_stripe_that_is_nowhere_in_the_image_has_none)
{
    StripeCase c(0);
    const CameraView view(c.gripper2base, c.calibration.cam2gripper);
    const double e = 0.6; // a surface that meets the light plane in a plane through the camera, parallel to the image
    const Vector3d w = (e * c.calibration.light.n - 0.3 * Vector3d::UnitZ()) / c.calibration.light.d;
    c.surface.head<3>() = view.R_cam2base * w;
    c.surface(3) = e + c.surface.head<3>().dot(view.centre);
    StripeResidual residual;
    EXPECT_FALSE(residual.linearize(c.calibration, view, c.surface, c.pixel));
}

TEST(ActiveHandEye_Residuals, the_tangent_space_of_a_surface_is_across_it)
{
    RNG rng(4);
    for (int k = 0; k < 20; ++k)
    {
        Vector4d surface;
        surface << randomVector(rng, 1), rng.uniform(-1., 1.);
        if (k < 2)
            surface << (k ? -1 : 1), 0, 0, 0;
        surface.normalize();
        Eigen::Matrix4d basis;
        basis << surface, surfaceTangent(surface);
        EXPECT_LE((basis.transpose() * basis - Eigen::Matrix4d::Identity()).norm(), 1e-14);
    }
}

TEST(ActiveHandEye_Residuals, the_calibration_moves_as_its_columns_say)
{
    const HandEyeCalibration start = someCalibration();
    CalibrationStep step;
    for (int i = 0; i < CALIBRATION_COLUMNS; ++i)
        step(i) = 0.01 * (i + 1);
    const HandEyeCalibration c = start.moved(step);
    const double dK[] = {c.camera.K(0, 0) - 1413, c.camera.K(1, 1) - 1420, c.camera.K(0, 2) - 316,
                         c.camera.K(1, 2) - 243, c.camera.K(0, 1) - 0.8};
    for (int i = 0; i < 5; ++i)
    {
        EXPECT_NEAR(step(i), dK[i], 1e-12) << columnNames[i];
        EXPECT_NEAR(step(5 + i), c.camera.D[i] - start.camera.D[i], 1e-15) << columnNames[5 + i];
    }
    const Matrix3d turn = expRotation(step.segment<3>(COLUMN_ROTATION));
    EXPECT_LE((c.cam2gripper.R - turn * start.cam2gripper.R).norm(), 1e-14) << "the error is in the gripper frame";
    EXPECT_LE((c.cam2gripper.t - start.cam2gripper.t - step.segment<3>(COLUMN_TRANSLATION)).norm(), 1e-15);
    EXPECT_NEAR(1, c.light.n.norm(), 1e-15);
    EXPECT_NEAR(std::atan(step.segment<2>(COLUMN_NORMAL).norm()), std::acos(c.light.n.dot(start.light.n)), 1e-9);
    EXPECT_NEAR(step(COLUMN_OFFSET), c.light.d - start.light.d, 1e-15);
}

}} // namespace opencv_test
