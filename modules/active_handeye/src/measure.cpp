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

//! One for each point.
std::vector<double> readPixelSigmas(InputArray sigmas, size_t points)
{
    const size_t given = numbersOf(sigmas.getMat()).values.size();
    if (given == 1)
        return std::vector<double>(points, readSigmas(sigmas, "pixelSigmas", 1)[0]);
    if (given != points)
        CV_Error(Error::StsBadSize,
                 cv::format("pixelSigmas: needed one number, or one for each of the %d points, given %d", int(points),
                            int(given)));
    return readSigmas(sigmas, "pixelSigmas", points);
}

void requireBaseFrame(double sigma, const char* name, StripeGeometry::Frame frame)
{
    if (sigma > 0 && frame != StripeGeometry::BASE)
        CV_Error(Error::StsBadArg,
                 cv::format("%s: needed R_gripper2base and t_gripper2base, whose error it is, given none", name));
}

//! The viewing rays, scaled to end on the light plane and carried into the frame of the geometry; NaN where they miss it.
std::vector<size_t> writePoints(const Pixels& pixels, const StripeGeometry& geometry, OutputArray points3D)
{
    const LightPlane& light = geometry.light;
    const Pose cam2frame = geometry.cam2frame();
    points3D.create(int(pixels.size()), 3, CV_64F);
    Mat points = points3D.getMat();
    std::vector<size_t> missed;
    for (size_t i = 0; i < pixels.size(); ++i)
    {
        const Vector3d ray = geometry.camera.ray(pixels[i]);
        Eigen::Map<Vector3d> X(points.ptr<double>(int(i)));
        if (meets(light, ray))
            X = cam2frame.R * (ray * (light.d / light.n.dot(ray))) + cam2frame.t;
        else
        {
            X.setConstant(std::numeric_limits<double>::quiet_NaN());
            missed.push_back(i);
        }
    }
    return missed;
}

void writeCovariances(const Pixels& pixels, const StripeGeometry& geometry, const MeasurementErrors& errors,
                      const std::vector<double>& pixelSigmas, OutputArray covariances)
{
    const int sizes[] = {int(pixels.size()), 3, 3};
    covariances.create(3, sizes, CV_64F);
    Mat out = covariances.getMat();
    for (size_t i = 0; i < pixels.size(); ++i)
    {
        const Vector3d ray = geometry.camera.ray(pixels[i]);
        Eigen::Map<Matrix3d> covariance(out.ptr<double>(int(i)));
        if (meets(geometry.light, ray))
            covariance = errors.covariance(ReprojectedPoint(geometry, ray),
                                           pixelSigmas[i] * pixelSigmas[i] * Eigen::Matrix2d::Identity());
        else
            covariance.setConstant(std::numeric_limits<double>::quiet_NaN());
    }
}

} // namespace

void reprojectStripe(InputArray stripePoints, InputArray cameraMatrix, InputArray distCoeffs, InputArray lightPlane,
                     OutputArray points3D, OutputArray covariances, InputArray R_cam2gripper, InputArray t_cam2gripper,
                     InputArray R_gripper2base, InputArray t_gripper2base, InputArray calibrationCovariance,
                     InputArray pixelSigmas, double robotTranslationSigma, double robotRotationSigma, bool allowMissed)
{
    CV_TRACE_FUNCTION();
    const Pixels pixels = readPixels(stripePoints, "stripePoints");
    const StripeGeometry geometry = readGeometry(cameraMatrix, distCoeffs, lightPlane, R_cam2gripper, t_cam2gripper,
                                                 R_gripper2base, t_gripper2base);
    const MeasurementErrors errors =
        readMeasurementErrors(calibrationCovariance, robotTranslationSigma, robotRotationSigma);
    std::vector<double> sigmas(pixels.size(), 0.);
    if (!pixelSigmas.empty())
        sigmas = readPixelSigmas(pixelSigmas, pixels.size());
    requireBaseFrame(robotTranslationSigma, "robotTranslationSigma", geometry.frame);
    requireBaseFrame(robotRotationSigma, "robotRotationSigma", geometry.frame);

    const std::vector<size_t> missed = writePoints(pixels, geometry, points3D);
    if (!missed.empty() && !allowMissed)
        refuseMissed(missed, pixels);
    const bool known =
        !calibrationCovariance.empty() || !pixelSigmas.empty() || robotTranslationSigma > 0 || robotRotationSigma > 0;
    if (covariances.needed() && known)
        writeCovariances(pixels, geometry, errors, sigmas, covariances);
    else if (covariances.needed())
        covariances.release();
}

}} // namespace cv::active_handeye
