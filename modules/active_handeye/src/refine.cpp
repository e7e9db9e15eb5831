// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "closed_forms.hpp"
#include "refinement.hpp"

#include <exception>

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

//! What the caller gave, as arrays: the closed forms check it.
struct RefineArguments
{
    InputArrayOfArrays R_gripper2base, t_gripper2base, imagePoints;
    InputArray cameraMatrix, distCoeffs, R_cam2gripper, t_cam2gripper;
};

//! K and R from the pure translations, t from the turns, as far as the caller gives no start.
HandEyeCalibration startOf(const RefineArguments& given, const RefineParams& params, const TurnDirections& turns,
                           ViewDoubts& doubts)
{
    if (given.cameraMatrix.empty() && params.flags & REFINE_FIX_K)
        CV_Error(Error::StsBadArg, "cameraMatrix: needed with REFINE_FIX_K, given none");
    Mat K = given.cameraMatrix.getMat(), R = given.R_cam2gripper.getMat(), t = given.t_cam2gripper.getMat();
    if (K.empty() || R.empty())
    {
        Mat startK = K.clone(), startR;
        const int flags = K.empty() ? translationsFlags(params) : int(TRANSLATIONS_FIX_K);
        translationsClosedForm(given.R_gripper2base, given.t_gripper2base, given.imagePoints, startK, given.distCoeffs,
                               startR, noArray(), TRANSLATIONS_METRIC, flags, params.orientationTolerance, doubts);
        K = startK;
        R = R.empty() ? startR : R;
    }
    HandEyeCalibration start;
    start.camera = readCamera(K, given.distCoeffs);
    start.cam2gripper.R = readRotation(R, "R_cam2gripper");
    const bool allowPartial = (params.flags & REFINE_ALLOW_PARTIAL) != 0;
    if (t.empty() && allowPartial && turns.observed.cols() == 0)
        return start;
    if (t.empty())
    {
        const std::vector<int> doubtedBefore = doubts.rejectedViews;
        rotationClosedForm(given.R_gripper2base, given.t_gripper2base, given.imagePoints, K, given.distCoeffs, R, t,
                           noArray(), allowPartial ? ROTATION_ALLOW_PARTIAL : 0, doubts);
        doubts.rejectedViews.insert(doubts.rejectedViews.end(), doubtedBefore.begin(), doubtedBefore.end());
    }
    start.cam2gripper.t = readVector3(t, "t_cam2gripper");
    return start;
}

/** A refinement with its scene, from the better of two starts.

Closed forms that distrust views are right when a view is wrong, and those that do not are right when the robot is merely inaccurate.
*/
std::unique_ptr<HandEyeRefinement> beginRefinement(const RefineArguments& given, const RefineMeasurements& measurements,
                                                   const RefineParams& params)
{
    const double thresholds[] = {largeImageNoise, 1e9};
    const TurnDirections turns(measurements.gripper2base);
    std::unique_ptr<HandEyeRefinement> best;
    std::exception_ptr refusal;
    for (double threshold : thresholds)
    {
        ViewDoubts doubts = {threshold, {}};
        try
        {
            std::unique_ptr<HandEyeRefinement> candidate(
                new HandEyeRefinement(measurements, params, startOf(given, params, turns, doubts)));
            candidate->findScene();
            if (!best || candidate->typicalError() < best->typicalError())
                best = std::move(candidate);
        }
        catch (const cv::Exception& e)
        {
            if (e.code != Error::StsNoConv)
                throw;
            refusal = refusal ? refusal : std::current_exception();
            continue;
        }
        if (doubts.rejectedViews.empty())
            break;
    }
    if (!best)
        std::rethrow_exception(refusal);
    return best;
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
    const RefineArguments given = {R_gripper2base, t_gripper2base, imagePoints, cameraMatrix,
                                   distCoeffs,     R_cam2gripper,  t_cam2gripper};
    const std::unique_ptr<HandEyeRefinement> refinement = beginRefinement(given, measurements, params);
    refinement->fitPoints();
    if (!measurements.stripes.empty())
    {
        Mat plane = lightPlane.getMat();
        if (plane.empty())
        {
            Mat K, D, R;
            writeMatrix(refinement->calibration().camera.K, K);
            writeMatrix(distortionOf(refinement->calibration().camera), D);
            writeMatrix(refinement->calibration().cam2gripper.R, R);
            calibrateLightPlane(R_gripper2base, t_gripper2base, stripePoints, stripeViews, surfaceIds, K, D, R, plane,
                                noArray(), noArray(), params.orientationTolerance);
        }
        refinement->fitStripes(readLightPlane(plane));
    }
    refinement->requireAnswer();

    summary = RefineSummary();
    refinement->summarize(summary);
    const HandEyeCalibration& result = refinement->calibration();
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
