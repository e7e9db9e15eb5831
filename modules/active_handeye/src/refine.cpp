// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "refinement.hpp"

namespace cv { namespace active_handeye {

RefineParams::RefineParams()
    : flags(0), lensModel(LENS_AUTO), pointSigma(-1), stripeSigma(-1), robotTranslationSigma(-1), robotRotationSigma(-1),
      huberThreshold(2.5), rejectThreshold(4.5), maxIterations(50), orientationTolerance(0.05)
{}

RefineSummary::RefineSummary()
    : usable(false), iterations(0), rms(0), pointSigma(0), stripeSigma(0), robotTranslationSigma(0),
      robotRotationSigma(0), chiSquare(0), chiSquareDof(0), chiSquarePValue(0), lensModel(LENS_FIXED), workingDistance(0)
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

int translationsFlags(const RefineParams& params)
{
    int flags = params.flags & REFINE_FIX_K ? TRANSLATIONS_FIX_K : 0;
    if (!(params.flags & (REFINE_FIX_K | REFINE_SKEW)))
        flags |= params.flags & REFINE_FIX_ASPECT ? TRANSLATIONS_SQUARE_PIXELS : TRANSLATIONS_ZERO_SKEW;
    return flags;
}

//! K and R from the pure translations, t from the turns, as far as the caller gives no start.
HandEyeCalibration startOf(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base,
                           InputArrayOfArrays imagePoints, InputArray cameraMatrix, InputArray distCoeffs,
                           InputArray R_cam2gripper, InputArray t_cam2gripper, const RefineParams& params,
                           const TurnDirections& turns)
{
    if (cameraMatrix.empty() && params.flags & REFINE_FIX_K)
        CV_Error(Error::StsBadArg, "cameraMatrix: needed with REFINE_FIX_K, given none");
    Mat K = cameraMatrix.getMat().clone(), R = R_cam2gripper.getMat(), t = t_cam2gripper.getMat();
    if (K.empty() || R.empty())
    {
        Mat startK = K, startR;
        const int flags = K.empty() ? translationsFlags(params) : int(TRANSLATIONS_FIX_K);
        calibrateHandEyeTranslations(R_gripper2base, t_gripper2base, imagePoints, startK, distCoeffs, startR, noArray(),
                                     TRANSLATIONS_METRIC, flags, params.orientationTolerance);
        K = startK;
        R = R.empty() ? startR : R;
    }
    HandEyeCalibration start;
    start.camera = readCamera(K, distCoeffs);
    start.cam2gripper.R = readRotation(R, "R_cam2gripper");
    const bool allowPartial = (params.flags & REFINE_ALLOW_PARTIAL) != 0;
    if (t.empty() && allowPartial && turns.observed.cols() == 0)
        return start;
    if (t.empty())
        calibrateHandEyeRotation(R_gripper2base, t_gripper2base, imagePoints, K, distCoeffs, R, t, noArray(),
                                 allowPartial ? ROTATION_ALLOW_PARTIAL : 0);
    start.cam2gripper.t = readVector3(t, "t_cam2gripper");
    return start;
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
    const RefineMeasurements measurements = readMeasurements(R_gripper2base, t_gripper2base, imagePoints, stripePoints,
                                                             stripeViews, surfaceIds, objectPoints, pointSigmas, stripeSigmas);
    const HandEyeCalibration start =
        startOf(R_gripper2base, t_gripper2base, imagePoints, cameraMatrix, distCoeffs, R_cam2gripper, t_cam2gripper,
                params, TurnDirections(measurements.gripper2base));
    HandEyeRefinement refinement(measurements, params, start);
    refinement.findScene();
    refinement.fitPoints();
    if (!measurements.stripes.empty())
    {
        Mat plane = lightPlane.getMat();
        if (plane.empty())
        {
            Mat K, D, R;
            writeMatrix(refinement.calibration().camera.K, K);
            writeMatrix(distortionOf(refinement.calibration().camera), D);
            writeMatrix(refinement.calibration().cam2gripper.R, R);
            calibrateLightPlane(R_gripper2base, t_gripper2base, stripePoints, stripeViews, surfaceIds, K, D, R, plane,
                                noArray(), noArray(), params.orientationTolerance);
        }
        refinement.fitStripes(readLightPlane(plane));
    }
    refinement.requireAnswer();

    summary = RefineSummary();
    refinement.summarize(summary);
    const HandEyeCalibration& result = refinement.calibration();
    writeMatrix(result.camera.K, cameraMatrix);
    writeMatrix(distortionOf(result.camera), distCoeffs);
    writeMatrix(result.cam2gripper.R, R_cam2gripper);
    writeMatrix(result.cam2gripper.t, t_cam2gripper);
    if (measurements.stripes.empty())
        lightPlane.release();
    else
        writeMatrix((Eigen::Vector4d() << result.light.n, result.light.d).finished(), lightPlane);
    return summary.rms;
}

}} // namespace cv::active_handeye
