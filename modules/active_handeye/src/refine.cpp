// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "light_plane_calibration.hpp"
#include "start_search.hpp"

namespace cv { namespace active_handeye {

RefineParams::RefineParams()
    : flags(0), lensModel(LENS_AUTO), pointSigma(-1), stripeSigma(-1), robotTranslationSigma(-1),
      robotRotationSigma(-1), huberThreshold(2.5), rejectThreshold(4.5), maxIterations(50), orientationTolerance(0.05)
{}

RefineSummary::RefineSummary()
    : usable(false), iterations(0), rms(0), pointSigma(0), stripeSigma(0), robotTranslationSigma(0),
      robotRotationSigma(0), chiSquare(0), chiSquareDof(0), chiSquarePValue(0), lensModel(LENS_FIXED),
      workingDistance(0)
{}

namespace {

RefineMeasurements readMeasurements(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base,
                                    InputArrayOfArrays imagePoints, InputArrayOfArrays stripePoints,
                                    InputArray stripeViews, InputArray surfaceIds, InputArray objectPoints,
                                    InputArrayOfArrays pointSigmas, InputArray stripeSigmas)
{
    RefineMeasurements m;
    m.gripper2base = readRobotPoses(R_gripper2base, t_gripper2base);
    m.imagePoints = readImagePoints(imagePoints, m.gripper2base.size());
    m.pointSigmas = readPointSigmas(pointSigmas, m.imagePoints);
    m.objectPoints = readObjectPoints(objectPoints, m.imagePoints[0].size());
    if (!stripePoints.empty())
    {
        m.stripes = readPixelLists(stripePoints, "stripePoints");
        m.stripeViews = readStripeViews(stripeViews, m.stripes.size(), m.gripper2base.size());
        m.surfaceIds = readSurfaceIds(surfaceIds, m.stripes.size());
        m.stripeSigmas = readStripeSigmas(stripeSigmas, m.stripes.size());
    }
    return m;
}

LightPlane lightPlaneOf(const RefineMeasurements& measurements, const HandEyeCalibration& start,
                        double orientationTolerance)
{
    LightPlaneCalibration closedForm;
    closedForm.camera = start.camera;
    closedForm.calibrate(measurements.gripper2base, start.cam2gripper.R, measurements.stripes, measurements.stripeViews,
                         measurements.surfaceIds, orientationTolerance);
    return closedForm.light();
}

Eigen::Matrix<double, 5, 1> distortionOf(const Camera& camera)
{
    return Eigen::Map<const Eigen::Matrix<double, 5, 1>>(camera.D);
}

} // namespace

double refineHandEye(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base,
                     InputArrayOfArrays imagePoints, InputOutputArray cameraMatrix, InputOutputArray distCoeffs,
                     InputOutputArray R_cam2gripper, InputOutputArray t_cam2gripper, InputOutputArray lightPlane,
                     RefineSummary& summary, InputArrayOfArrays stripePoints, InputArray stripeViews,
                     InputArray surfaceIds, InputArray objectPoints, InputArrayOfArrays pointSigmas,
                     InputArray stripeSigmas, const RefineParams& params)
{
    CV_TRACE_FUNCTION();
    checkRefineParams(params);
    const RefineMeasurements measurements =
        readMeasurements(R_gripper2base, t_gripper2base, imagePoints, stripePoints, stripeViews, surfaceIds,
                         objectPoints, pointSigmas, stripeSigmas);
    if (!measurements.stripes.empty() && params.flags & REFINE_FIX_LIGHT_PLANE && lightPlane.empty())
        CV_Error(Error::StsBadArg, "lightPlane: needed with REFINE_FIX_LIGHT_PLANE, given none");
    StartArguments given;
    given.cameraMatrix = cameraMatrix.getMat();
    given.distCoeffs = distCoeffs.getMat();
    given.R_cam2gripper = R_cam2gripper.getMat();
    given.t_cam2gripper = t_cam2gripper.getMat();
    const std::unique_ptr<HandEyeRefinement> refinement = StartSearch(given, measurements, params).refinePoints();
    if (!measurements.stripes.empty())
    {
        const HandEyeCalibration& start = refinement->calibration();
        refinement->fitStripes(lightPlane.empty() ? lightPlaneOf(measurements, start, params.orientationTolerance)
                                                  : readLightPlane(lightPlane));
    }
    refinement->requireAnswer();

    summary = RefineSummary();
    refinement->summarize(summary);
    const HandEyeCalibration& result = refinement->calibration();
    writeNewMatrix(result.camera.K, cameraMatrix);
    writeNewMatrix(distortionOf(result.camera), distCoeffs);
    const bool keepsRotation = (params.flags & REFINE_FIX_ROTATION) && R_cam2gripper.total() == 9; // to the last bit
    if (!keepsRotation)
        writeNewMatrix(result.cam2gripper.R, R_cam2gripper);
    writeNewMatrix(result.cam2gripper.t, t_cam2gripper);
    if (measurements.stripes.empty())
        lightPlane.release();
    else
        writeNewMatrix((Eigen::Vector4d() << result.light.n, result.light.d).finished(), lightPlane);
    return summary.rms;
}

}} // namespace cv::active_handeye
