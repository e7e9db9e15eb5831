// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "numbers.hpp"
#include "refinement.hpp"
#include "view_choice.hpp"

namespace cv { namespace active_handeye {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector4d;

PlanParams::PlanParams() : groups(-1), viewsPerGroup(-1), exchanges(3), seenShare(0.25) {}

namespace {

AlignedVector<Vector4d> readSurfaces(InputArray surfaces)
{
    const Numbers numbers = numbersOf(surfaces.getMat());
    if (numbers.values.size() % 4 || (!numbers.values.empty() && numbers.rowLength != 4))
        CV_Error(Error::StsBadSize, "surfaces: needed S x 4 numbers (wx, wy, wz, e), given " + numbers.shape);
    AlignedVector<Vector4d> result;
    for (size_t i = 0; i < numbers.values.size(); i += 4)
    {
        const Vector4d plane(&numbers.values[i]);
        if (!plane.allFinite() || !(plane.head<3>().norm() > 0))
            CV_Error(Error::StsBadArg,
                     cv::format("surfaces: needed finite planes with a normal, given (%g, %g, %g, %g) as plane %d",
                                plane(0), plane(1), plane(2), plane(3), int(i / 4)));
        result.push_back(plane.normalized());
    }
    return result;
}

AssumedScene readScene(InputArray scenePoints, Size imageSize, InputArray cameraMatrix, InputArray distCoeffs,
                       InputArray R_cam2gripper, InputArray t_cam2gripper)
{
    AssumedScene scene;
    scene.calibration.camera = readCamera(cameraMatrix, distCoeffs);
    scene.calibration.cam2gripper =
        Pose{readRotation(R_cam2gripper, "R_cam2gripper"), readVector3(t_cam2gripper, "t_cam2gripper")};
    scene.imageSize = imageSize;
    if (imageSize.width < 1 || imageSize.height < 1)
        CV_Error(Error::StsOutOfRange, cv::format("imageSize: needed positive numbers of pixels, given %d x %d",
                                                  imageSize.width, imageSize.height));
    scene.points = readPoints3D(scenePoints, "scenePoints");
    if (scene.points.empty())
        CV_Error(Error::StsBadSize, "scenePoints: needed N x 3 coordinates, given none");
    return scene;
}

void requireLevel(double value, const char* name, bool zeroIsExact)
{
    if (!(value > 0 || (zeroIsExact && value == 0)))
        CV_Error(Error::StsOutOfRange, cv::format("params.%s: a prediction needed a noise level, %s, given %g", name,
                                                  zeroIsExact ? "positive or 0 = exact" : "positive", value));
}

//! LENS_AUTO stands for the model that has just these coefficients.
RefineParams readParams(const RefineParams& given, const Camera& camera, bool hasStripes)
{
    checkRefineParams(given);
    requireLevel(given.pointSigma, "pointSigma", false);
    requireLevel(given.robotTranslationSigma, "robotTranslationSigma", true);
    requireLevel(given.robotRotationSigma, "robotRotationSigma", true);
    if (hasStripes)
        requireLevel(given.stripeSigma, "stripeSigma", false);
    RefineParams params = given;
    if (params.lensModel == LENS_AUTO)
    {
        params.lensModel = LENS_FIXED;
        for (int model = LENS_K1; model <= LENS_K3 && !(given.flags & REFINE_FIX_K); ++model)
            for (int i = lensCoefficients(model - 1); i < lensCoefficients(model); ++i)
                params.lensModel = camera.D[i] != 0 ? model : params.lensModel;
    }
    return params;
}

//! A refinement at the assumed truth. What it refers to has to live as long.
struct Assumption
{
    Assumption(const AlignedVector<Pose>& gripper2base, const AssumedScene& scene, const RefineParams& params_)
        : params(params_)
    {
        measurements.gripper2base = gripper2base;
        for (const Pose& pose : gripper2base)
            measurements.imagePoints.push_back(scene.project(scene.view(pose)));
        refinement.reset(new HandEyeRefinement(measurements, params, scene.calibration, std::vector<int>()));
        if (refinement->problem().tracks.count() == 0)
            CV_Error(
                Error::StsNoConv,
                cv::format("scenePoints: needed points that two of the views see, given %d points of which none is",
                           int(scene.points.size())));
        refinement->assume(scene.points, scene.surfaces,
                           scene.calibration.light.d > 0 ? scene.stripes(gripper2base) : StripeSegments());
    }

    double predict(RefineSummary& summary) const
    {
        refinement->predict(summary);
        double variance = 0;
        for (int i = COLUMN_TRANSLATION; i < COLUMN_TRANSLATION + 3; ++i)
            variance += summary.covariance.at<double>(i, i);
        return std::sqrt(variance);
    }

    const RefineParams params;
    RefineMeasurements measurements;
    std::unique_ptr<HandEyeRefinement> refinement;
};

Mat sharedPoints(const SceneTracks& tracks, size_t views)
{
    Mat counts = Mat::zeros(int(views), 1, CV_32S);
    for (const PointObservation& o : tracks.observations)
        ++counts.at<int>(o.view);
    return counts;
}

std::vector<int> readTaken(InputArray taken, size_t views)
{
    std::vector<int> result = readIntegers(taken, "taken");
    for (size_t i = 0; i < result.size(); ++i)
        if (result[i] < 0 || result[i] >= int(views) || std::count(result.begin(), result.end(), result[i]) > 1)
            CV_Error(Error::StsOutOfRange,
                     cv::format("taken: needed different numbers from 0 to %d, given %d", int(views) - 1, result[i]));
    return result;
}

void requireStops(int stops, size_t taken, size_t possible)
{
    if (stops <= int(taken) || stops > int(possible))
        CV_Error(Error::StsOutOfRange,
                 cv::format("stops: needed more than the %d views taken and at most all %d, given %d", int(taken),
                            int(possible), stops));
}

GroupDemand demandOf(const PlanParams& planParams, int flags)
{
    const bool isCameraKnown = (flags & REFINE_FIX_K) != 0;
    GroupDemand demand;
    demand.groups = planParams.groups >= 0 ? planParams.groups : isCameraKnown ? 1 : 2;
    demand.viewsPerGroup = planParams.viewsPerGroup >= 0 ? planParams.viewsPerGroup : isCameraKnown ? 3 : 4;
    demand.dimensions = isCameraKnown ? 2 : 3;
    if (demand.groups > 0 && demand.viewsPerGroup <= demand.dimensions)
        CV_Error(
            Error::StsOutOfRange,
            cv::format("planParams.viewsPerGroup: needed %d or more, so that translations span %d dimensions, given %d",
                       demand.dimensions + 1, demand.dimensions, demand.viewsPerGroup));
    if (planParams.exchanges < 0)
        CV_Error(Error::StsOutOfRange,
                 cv::format("planParams.exchanges: needed 0 or more, given %d", planParams.exchanges));
    if (!(planParams.seenShare >= 0 && planParams.seenShare <= 1))
        CV_Error(Error::StsOutOfRange,
                 cv::format("planParams.seenShare: needed a share from 0 to 1, given %g", planParams.seenShare));
    return demand;
}

//! Which views see their share of the points.
std::vector<bool> viewsInSight(const std::vector<Pixels>& imagePoints, double seenShare)
{
    std::vector<bool> result;
    int most = 0;
    const int needed = int(std::ceil(seenShare * double(imagePoints[0].size())));
    for (const Pixels& pixels : imagePoints)
    {
        int seen = 0;
        for (const Eigen::Vector2d& pixel : pixels)
            seen += !std::isnan(pixel.x());
        most = std::max(most, seen);
        result.push_back(seen >= needed);
    }
    if (most < needed)
        CV_Error(Error::StsNoConv, cv::format("scenePoints: needed views that see %d of the %d points "
                                              "(planParams.seenShare), the best of them sees %d",
                                              needed, int(imagePoints[0].size()), most));
    return result;
}

double medianDepth(const AlignedVector<Pose>& gripper2base, const AssumedScene& scene)
{
    std::vector<double> depths;
    for (const Pose& pose : gripper2base)
        for (const Vector3d& X : scene.points)
            depths.push_back(std::abs(scene.view(pose).toCamera(X).z()));
    std::nth_element(depths.begin(), depths.begin() + depths.size() / 2, depths.end());
    return depths[depths.size() / 2];
}

//! Standard deviation of t_cam2gripper with views taken and chosen.
double sigmaOf(const AlignedVector<Pose>& poses, const std::vector<int>& taken, const std::vector<int>& chosen,
               const AssumedScene& scene, const RefineParams& params)
{
    AlignedVector<Pose> used;
    for (const std::vector<int>* views : {&taken, &chosen})
        for (int view : *views)
            used.push_back(poses[view]);
    RefineSummary summary;
    const double sigma = Assumption(used, scene, params).predict(summary);
    if (std::isinf(sigma))
        CV_Error(Error::StsNoConv,
                 "R_gripper2base: the possible views do not determine t_cam2gripper: " + summary.weakDirections.back());
    return sigma;
}

} // namespace

double predictHandEyeCovariance(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base,
                                InputArray scenePoints, Size imageSize, InputArray cameraMatrix, InputArray distCoeffs,
                                InputArray R_cam2gripper, InputArray t_cam2gripper, OutputArray covariance,
                                std::vector<std::string>& weakDirections, OutputArray seenPoints, InputArray lightPlane,
                                InputArray surfaces, const RefineParams& params)
{
    CV_TRACE_FUNCTION();
    const AlignedVector<Pose> poses = readRobotPoses(R_gripper2base, t_gripper2base);
    AssumedScene scene = readScene(scenePoints, imageSize, cameraMatrix, distCoeffs, R_cam2gripper, t_cam2gripper);
    scene.surfaces = readSurfaces(surfaces);
    if (!lightPlane.empty())
        scene.calibration.light = readLightPlane(lightPlane);
    if (!lightPlane.empty() && scene.surfaces.empty())
        CV_Error(Error::StsBadArg, "surfaces: needed with lightPlane, given none");
    const Assumption assumption(poses, scene, readParams(params, scene.calibration.camera, !lightPlane.empty()));
    RefineSummary summary;
    const double sigma = assumption.predict(summary);
    summary.covariance.copyTo(covariance);
    weakDirections = summary.weakDirections;
    sharedPoints(assumption.refinement->problem().tracks, poses.size()).copyTo(seenPoints);
    return sigma;
}

double planHandEyeViews(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base, InputArray scenePoints,
                        Size imageSize, InputArray cameraMatrix, InputArray distCoeffs, InputArray R_cam2gripper,
                        InputArray t_cam2gripper, int stops, std::vector<int>& chosen, InputArray taken,
                        const RefineParams& params, const PlanParams& planParams)
{
    CV_TRACE_FUNCTION();
    const int pointsOfSearch = 24;
    const AlignedVector<Pose> poses = readRobotPoses(R_gripper2base, t_gripper2base);
    const AssumedScene scene =
        readScene(scenePoints, imageSize, cameraMatrix, distCoeffs, R_cam2gripper, t_cam2gripper);
    const RefineParams read = readParams(params, scene.calibration.camera, false);
    const std::vector<int> before = readTaken(taken, poses.size());
    requireStops(stops, before.size(), poses.size());
    if (read.flags & REFINE_FIX_TRANSLATION)
        CV_Error(Error::StsBadArg, "params.flags: needed t_cam2gripper to be estimated, given REFINE_FIX_TRANSLATION");
    const Assumption all(poses, scene, read);
    const ViewInformation information(all.refinement->problem(), scene, pointsOfSearch);
    const double distance = medianDepth(poses, scene);
    const double radius = 0.5 * Vector2d(imageSize.width, imageSize.height).norm() / scene.calibration.camera.K(0, 0);
    const GroupDemand demand = demandOf(planParams, read.flags);
    ViewChoice choice(poses, information, demand, information.prior(distance, radius), before,
                      viewsInSight(all.measurements.imagePoints, planParams.seenShare), read.orientationTolerance);
    choice.choose(stops, planParams.exchanges);
    chosen = choice.inGroups();

    return sigmaOf(poses, before, chosen, scene, read);
}

}} // namespace cv::active_handeye
