// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "small_problem.hpp"

namespace opencv_test {

Vector3d randomVector(RNG& rng, double half)
{
    const double x = rng.uniform(-half, half), y = rng.uniform(-half, half), z = rng.uniform(-half, half);
    return Vector3d(x, y, z);
}

Vector3d gaussianVector(RNG& rng, double sigma)
{
    const double x = rng.gaussian(sigma), y = rng.gaussian(sigma), z = rng.gaussian(sigma);
    return Vector3d(x, y, z);
}

HandEyeCalibration someCalibration()
{
    HandEyeCalibration calibration;
    calibration.camera.K << 1413, 0.8, 316, 0, 1420, 243, 0, 0, 1;
    const double D[] = {-0.2, 0.1, 0.001, -0.002, 0.05};
    std::copy(D, D + 5, calibration.camera.D);
    calibration.cam2gripper = Pose{expRotation(Vector3d(0.05, -0.03, 1.5)), Vector3d(-0.005, 0.103, 0.104)};
    const Vector3d n = Vector3d(0.05, -0.5, 0.23).normalized();
    calibration.light = LightPlane{n, n.z() * 0.55};
    return calibration;
}

Pose somePose(RNG& rng, const Pose& cam2gripper)
{
    const Matrix3d R_cam2base = expRotation(randomVector(rng, 0.35)) * expRotation(Vector3d(CV_PI, 0, 0));
    const Vector3d centre = Vector3d(0.3, 0, 0) - 0.55 * R_cam2base.col(2) + randomVector(rng, 0.05);
    const Matrix3d R = R_cam2base * cam2gripper.R.transpose();
    return Pose{R, centre - R * cam2gripper.t};
}

Vector2d stripePixel(const HandEyeCalibration& calibration, const CameraView& view, const Vector4d& surface, double x)
{
    const Vector3d w = view.R_cam2base.transpose() * surface.head<3>();
    const double e = surface(3) - surface.head<3>().dot(view.centre);
    const Vector3d line = e * calibration.light.n - calibration.light.d * w;
    return calibration.camera.project(Vector3d(x, -(line.x() * x + line.z()) / line.y(), 1));
}

SmallProblem::SmallProblem(const Contents& contents, uint64 seed)
    : contents_(contents), rng_(seed), truth_(makeTruth()), reported_(makeReports()), imagePoints_(makeImages()),
      tracks_(imagePoints_, makeSigmas(), objectPoints()), segments_(makeSegments()),
      problem(tracks_, segments_, reported_, truth_, contents.huberThreshold)
{
    problem.noise =
        NoiseLevels{contents.pixelNoise, contents.stripeNoise, contents.translationNoise, contents.rotationNoise};
    problem.unknowns.calibration =
        MatrixXd::Identity(CALIBRATION_COLUMNS, contents.surfaces ? int(CALIBRATION_COLUMNS) : int(POINT_COLUMNS));
    problem.unknowns.object = contents.knownPoints > 0;
    problem.unknowns.surfaces = contents.surfaces;
    problem.unknowns.poses.assign(contents.views, POSE_PRIOR);
}

CalibrationState SmallProblem::makeTruth()
{
    CalibrationState state;
    state.calibration = someCalibration();
    state.object2base = Pose{expRotation(Vector3d(0.2, -0.4, 0.9)), Vector3d(0.3, 0.01, -0.02)};
    for (int view = 0; view < contents_.views; ++view)
        state.gripper2base.push_back(somePose(rng_, state.calibration.cam2gripper));
    for (int j = 0; j < points(); ++j)
        state.points.push_back(Vector3d(0.3, 0, 0) + randomVector(rng_, 0.05));
    for (int s = 0; s < contents_.surfaces; ++s)
    {
        const Vector3d w = (Vector3d::UnitZ() + randomVector(rng_, 0.4)).normalized();
        Vector4d surface;
        surface << w, w.dot(Vector3d(0.3, 0, 0)) + rng_.uniform(-0.02, 0.02);
        state.surfaces.push_back(surface.normalized());
    }
    return state;
}

AlignedVector<Pose> SmallProblem::makeReports()
{
    AlignedVector<Pose> reported;
    for (const Pose& pose : truth_.gripper2base)
        reported.push_back(Pose{expRotation(gaussianVector(rng_, contents_.rotationNoise)) * pose.R,
                                pose.t + gaussianVector(rng_, contents_.translationNoise)});
    return reported;
}

std::vector<Pixels> SmallProblem::makeImages()
{
    const double NaN = std::numeric_limits<double>::quiet_NaN();
    std::vector<Pixels> images;
    const CameraViews views = truth_.views();
    for (int view = 0; view < contents_.views; ++view)
    {
        images.push_back(Pixels());
        for (int j = 0; j < points(); ++j)
        {
            const double dx = rng_.gaussian(contents_.pixelNoise), dy = rng_.gaussian(contents_.pixelNoise);
            const Vector2d pixel = truth_.calibration.camera.project(views[view].toCamera(truth_.points[j]));
            const bool isMissing = j < contents_.freePoints && (j / 3 + view) % 5 == 0;
            images.back().push_back(isMissing ? Vector2d(NaN, NaN) : Vector2d(pixel + Vector2d(dx, dy)));
        }
    }
    return images;
}

std::vector<std::vector<double>> SmallProblem::makeSigmas()
{
    std::vector<std::vector<double>> sigmas;
    for (int view = 0; view < contents_.views && !contents_.sameSigmas; ++view)
    {
        sigmas.push_back(std::vector<double>());
        for (int j = 0; j < points(); ++j)
            sigmas.back().push_back(rng_.uniform(0.5, 2.));
    }
    return sigmas;
}

AlignedVector<Vector3d> SmallProblem::objectPoints() const
{
    AlignedVector<Vector3d> known;
    const Pose& object = truth_.object2base;
    for (int j = 0; j < points() && contents_.knownPoints > 0; ++j)
        known.push_back(j < contents_.freePoints
                            ? Vector3d(Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()))
                            : Vector3d(object.R.transpose() * (truth_.points[j] - object.t)));
    return known;
}

StripeSegments SmallProblem::makeSegments()
{
    StripeSegments segments;
    const CameraViews views = truth_.views();
    for (int view = 0; view < contents_.views; ++view)
        for (int s = 0; s < contents_.surfaces; ++s)
        {
            StripeSegment segment = {
                int(segments.size()), view, s, {}, contents_.sameSigmas ? 1 : rng_.uniform(0.5, 2.), true};
            for (int end = 0; end < 2; ++end)
            {
                segment.ends[end] =
                    stripePixel(truth_.calibration, views[view], truth_.surfaces[s], end ? 0.15 : -0.12);
                segment.ends[end].y() += rng_.gaussian(contents_.stripeNoise);
            }
            segments.push_back(segment);
        }
    return segments;
}

} // namespace opencv_test
