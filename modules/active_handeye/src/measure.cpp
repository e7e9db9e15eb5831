// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "measure.hpp"
#include "numbers.hpp"
#include "refine_input.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

//! False when neither of the two was given.
bool readPose(InputArray R, InputArray t, const char* nameOfR, const char* nameOfT, Pose& pose)
{
    if (R.empty() && t.empty())
        return false;
    if (R.empty() || t.empty())
        CV_Error(Error::StsBadArg, cv::format("%s: needed together with %s, given none", R.empty() ? nameOfR : nameOfT,
                                              R.empty() ? nameOfT : nameOfR));
    pose = Pose{readRotation(R, nameOfR), readVector3(t, nameOfT)};
    return true;
}

StripeGeometry readGeometry(InputArray cameraMatrix, InputArray distCoeffs, InputArray lightPlane,
                            InputArray R_cam2gripper, InputArray t_cam2gripper, InputArray R_gripper2base,
                            InputArray t_gripper2base)
{
    const Pose identity = {Matrix3d::Identity(), Vector3d::Zero()};
    StripeGeometry geometry = {readCamera(cameraMatrix, distCoeffs), readLightPlane(lightPlane), StripeGeometry::CAMERA,
                               identity, identity};
    if (readPose(R_cam2gripper, t_cam2gripper, "R_cam2gripper", "t_cam2gripper", geometry.cam2gripper))
        geometry.frame = StripeGeometry::GRIPPER;
    if (readPose(R_gripper2base, t_gripper2base, "R_gripper2base", "t_gripper2base", geometry.gripper2base))
    {
        if (geometry.frame == StripeGeometry::CAMERA)
            CV_Error(Error::StsBadArg,
                     "R_cam2gripper: needed together with R_gripper2base, for points in the base frame, given none");
        geometry.frame = StripeGeometry::BASE;
    }
    return geometry;
}

//! Symmetric, and no covariance larger than the variances allow; what belongs to parameters of infinite variance is set to 0.
void readCalibrationCovariance(InputArray covariance, MeasurementErrors& errors)
{
    const Numbers numbers = numbersOf(covariance.getMat());
    const int n = CALIBRATION_PARAMETERS;
    if (numbers.values.size() != size_t(n) * n || numbers.rowLength != n)
        CV_Error(Error::StsBadSize,
                 "calibrationCovariance: needed 20 x 20 numbers as in RefineSummary::covariance, given " +
                     numbers.shape);
    errors.calibration = Eigen::Map<const Eigen::Matrix<double, n, n, Eigen::RowMajor>>(numbers.values.data());
    CalibrationMatrix& C = errors.calibration;
    for (int i = 0; i < n; ++i)
        if (C(i, i) == std::numeric_limits<double>::infinity())
        {
            errors.unobserved.push_back(i);
            C.row(i).setZero();
            C.col(i).setZero();
        }
    for (int i = 0; i < n; ++i)
        for (int j = 0; j <= i; ++j)
        {
            const double largest = std::sqrt(C(i, i) * C(j, j)), tolerance = 1e-6 * largest;
            if (!(std::abs(C(i, j)) <= largest + tolerance && std::abs(C(i, j) - C(j, i)) <= tolerance))
                CV_Error(
                    Error::StsBadArg,
                    cv::format("calibrationCovariance: needed a symmetric matrix with |c_ij| <= sqrt(c_ii c_jj), given "
                               "c_%d,%d = %g, c_%d,%d = %g with variances %g and %g",
                               i, j, C(i, j), j, i, C(j, i), C(i, i), C(j, j)));
        }
}

//! One for each point.
std::vector<double> readPixelSigmas(InputArray sigmas, size_t points)
{
    const std::vector<double> values = numbersOf(sigmas.getMat()).values;
    if (values.size() != 1 && values.size() != points)
        CV_Error(Error::StsBadSize,
                 cv::format("pixelSigmas: needed one number, or one for each of the %d points, given %d", int(points),
                            int(values.size())));
    for (double sigma : values)
        readPositive(sigma, "pixelSigmas");
    return values.size() == points ? values : std::vector<double>(points, values[0]);
}

double readSigmaOfRobot(double sigma, const char* name, StripeGeometry::Frame frame)
{
    if (!(sigma >= 0) || !std::isfinite(sigma))
        CV_Error(Error::StsOutOfRange, cv::format("%s: needed 0 or a positive number, given %g", name, sigma));
    if (sigma > 0 && frame != StripeGeometry::BASE)
        CV_Error(Error::StsBadArg,
                 cv::format("%s: needed R_gripper2base and t_gripper2base, whose error it is, given none", name));
    return sigma;
}

//! Names the points whose rays do not meet the light plane in front of the camera.
[[noreturn]] void refuseMissed(const std::vector<size_t>& missed, const Pixels& pixels)
{
    const size_t named = std::min<size_t>(missed.size(), 8);
    std::string list;
    for (size_t i = 0; i < named; ++i)
        list += (i ? ", " : "") + std::to_string(missed[i]);
    CV_Error(
        Error::StsOutOfRange,
        cv::format("stripePoints: needed pixels whose rays meet the light plane in front of the camera, given %d of %d "
                   "points whose rays do not: %s%s; point %d is (%g, %g)",
                   int(missed.size()), int(pixels.size()), list.c_str(), named < missed.size() ? ", ..." : "",
                   int(missed[0]), pixels[missed[0]].x(), pixels[missed[0]].y()));
}

//! The viewing rays, scaled to end on the light plane and carried into the frame of the geometry.
void writePoints(const Pixels& pixels, const StripeGeometry& geometry, OutputArray points3D)
{
    const double smallestSlope = 1e-9; // of the angle between ray and plane, rad
    const LightPlane& light = geometry.light;
    const Pose cam2frame = geometry.cam2frame();
    points3D.create(int(pixels.size()), 3, CV_64F);
    Mat points = points3D.getMat();
    std::vector<size_t> missed;
    for (size_t i = 0; i < pixels.size(); ++i)
    {
        const Vector3d ray = geometry.camera.ray(pixels[i]);
        const double slope = light.n.dot(ray);
        if (!(slope > smallestSlope * ray.norm()))
            missed.push_back(i);
        Eigen::Map<Vector3d>(points.ptr<double>(int(i))) = cam2frame.R * (ray * (light.d / slope)) + cam2frame.t;
    }
    if (!missed.empty())
        refuseMissed(missed, pixels);
}

void writeCovariances(const Pixels& pixels, const StripeGeometry& geometry, const MeasurementErrors& errors,
                      const std::vector<double>& pixelSigmas, OutputArray covariances)
{
    const int sizes[] = {int(pixels.size()), 3, 3};
    covariances.create(3, sizes, CV_64F);
    Mat out = covariances.getMat();
    for (size_t i = 0; i < pixels.size(); ++i)
        Eigen::Map<Matrix3d>(out.ptr<double>(int(i))) =
            errors.covariance(geometry, geometry.camera.ray(pixels[i]), pixelSigmas[i]);
}

} // namespace

void reprojectStripe(InputArray stripePoints, InputArray cameraMatrix, InputArray distCoeffs, InputArray lightPlane,
                     OutputArray points3D, OutputArray covariances, InputArray R_cam2gripper, InputArray t_cam2gripper,
                     InputArray R_gripper2base, InputArray t_gripper2base, InputArray calibrationCovariance,
                     InputArray pixelSigmas, double robotTranslationSigma, double robotRotationSigma)
{
    CV_TRACE_FUNCTION();
    const Pixels pixels = readPixels(stripePoints, "stripePoints");
    const StripeGeometry geometry = readGeometry(cameraMatrix, distCoeffs, lightPlane, R_cam2gripper, t_cam2gripper,
                                                 R_gripper2base, t_gripper2base);
    MeasurementErrors errors;
    if (!calibrationCovariance.empty())
        readCalibrationCovariance(calibrationCovariance, errors);
    std::vector<double> sigmas(pixels.size(), 0.);
    if (!pixelSigmas.empty())
        sigmas = readPixelSigmas(pixelSigmas, pixels.size());
    errors.robotTranslationSigma = readSigmaOfRobot(robotTranslationSigma, "robotTranslationSigma", geometry.frame);
    errors.robotRotationSigma = readSigmaOfRobot(robotRotationSigma, "robotRotationSigma", geometry.frame);

    writePoints(pixels, geometry, points3D);
    const bool known =
        !calibrationCovariance.empty() || !pixelSigmas.empty() || robotTranslationSigma > 0 || robotRotationSigma > 0;
    if (covariances.needed() && known)
        writeCovariances(pixels, geometry, errors, sigmas, covariances);
    else if (covariances.needed())
        covariances.release();
}

}} // namespace cv::active_handeye
