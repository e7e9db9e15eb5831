// SPDX-FileCopyrightText: 2026 active_handeye contributors
// SPDX-License-Identifier: Apache-2.0

#include "bind.hpp"
#include "convert.hpp"

#include <pybind11/stl.h>

namespace active_handeye_python {

using namespace cv::active_handeye;

namespace {

const char* const refineDoc =
    R"doc(Maximum-likelihood calibration of camera, hand-eye transform and light plane from everything that was seen.

Unknowns are the camera matrix, the lens distortion, R_cam2gripper and t_cam2gripper, the light plane, one plane for
every surface, all scene points, and a correction of every robot pose with a Gaussian prior. Noise levels are estimated
by restricted maximum likelihood, so the covariance covers image noise and robot noise as the data show them.

Args:
    R_gripper2base: V rotations of the gripper in the robot's base frame, (3, 3) or rotation vectors.
    t_gripper2base: V translations of 3 numbers, any unit of length; the result has the same one.
    imagePoints: V arrays (N, 2), pixels of the distorted image; row j is the same scene point in every view;
        NaN, NaN = not seen.
    cameraMatrix: (3, 3), start or, with REFINE_FIX_K, known; None = closed-form start.
    distCoeffs: k1, k2, p1, p2[, k3], start or known; None = zero.
    R_cam2gripper: start, (3, 3) or rotation vector; None = closed-form start.
    t_cam2gripper: start, 3 numbers; None = closed-form start.
    lightPlane: start, 4 numbers nx, ny, nz, d; None = closed-form start. Only used with stripes.
    stripePoints: S straight stripe segments, each (M, 2), pixels of the distorted image; None = no stripes.
    stripeViews: S integers, the view in which each segment was seen.
    surfaceIds: S integers, the plane, fixed in the base frame, on which each segment lies; -1 = unknown, not used.
    objectPoints: (N, 3) known coordinates of the image points in a frame of their own, NaN = unknown; the pose of
        that frame in the base is estimated. A board is the special case where all are known.
    pointSigmas: V arrays of N standard deviations of the image points, pixels; None = all alike.
    stripeSigmas: S standard deviations of the segments' lines, pixels; None = from the segments' straightness.
    params: settings.

Returns:
    retval: RMS distance between image points and their predictions, pixels.
    cameraMatrix: (3, 3).
    distCoeffs: (5, 1): k1, k2, p1, p2, k3.
    R_cam2gripper: (3, 3).
    t_cam2gripper: (3, 1).
    lightPlane: (4, 1): nx, ny, nz, d in the camera frame, n.X = d; None without stripes.
    summary: covariance, intervals, noise levels, residuals, what was left out and why, verdict.

Raises:
    error: wrong input (StsBadArg, StsBadSize, StsOutOfRange); StsNoConv when the data do not determine the result;
        the text names what is missing.

Source: doc/method/refine.md.
)doc";

const char* const refineParamsDoc = R"doc(Settings of refineHandEye.

Attributes:
    flags: combination of REFINE_FIX_K, REFINE_SKEW, REFINE_FIX_ASPECT, REFINE_FIX_ROTATION, REFINE_FIX_TRANSLATION,
        REFINE_FIX_LIGHT_PLANE, REFINE_ALLOW_PARTIAL; default 0.
    lensModel: LENS_AUTO (default: chosen by a test; LENS_FIXED with REFINE_FIX_K), LENS_FIXED, LENS_K1, LENS_K1_K2,
        LENS_TANGENTIAL or LENS_K3: the distortion coefficients that are estimated, the others stay as given.
    pointSigma: standard deviation of one image coordinate, pixels (with pointSigmas: their common factor); negative
        (default) = estimated.
    stripeSigma: standard deviation of a segment's line, pixels (with stripeSigmas: their common factor); negative
        (default) = estimated.
    robotTranslationSigma: standard deviation of each coordinate of the robot's position; 0 = exact, negative
        (default) = estimated.
    robotRotationSigma: standard deviation of each component of the robot's rotation vector, rad; 0 = exact, negative
        (default) = estimated.
    huberThreshold: error in sigmas from which the pull of an image point no longer grows; default 2.5.
    rejectThreshold: error in sigmas from which an image point is left out; default 4.5.
    maxIterations: of one least-squares solution; default 50.
    orientationTolerance: for the closed-form start, degrees; default 0.05.
)doc";

const char* const refineSummaryDoc = R"doc(What refineHandEye found out besides the calibration.

Lengths in the unit of t_gripper2base, angles in rad, image in pixels. V views, N points, S stripe segments.

Attributes:
    usable: whether the result may be used.
    message: the verdict in a sentence.
    stopReason: why the iterations ended.
    iterations: of all least-squares solutions together.
    rms: RMS distance of the image points used from their predictions.
    parameterNames: fx, fy, cx, cy, skew, k1, k2, p1, p2, k3, rx, ry, rz, tx, ty, tz, nx, ny, nz, d; rx, ry, rz is the
        rotation error vector in the gripper frame: true R = exp(error) R_cam2gripper.
    covariance: (20, 20); rows of fixed parameters are 0, variances of unobserved ones infinite.
    standardDeviations: (20, 1).
    degreesOfFreedom: (20, 1) of Student's t for the intervals (Satterthwaite).
    intervals95: (20, 2) lower and upper end; the rotation error vector's is around 0.
    pointSigma, stripeSigma, robotTranslationSigma, robotRotationSigma: noise levels used.
    noiseLevels: (4, 4), rows in this order: level, 95 % interval (lower, upper), 1 when it was estimated.
    chiSquare, chiSquareDof, chiSquarePValue: test of the noise levels that were given; NaN when none was.
    lensModel: the LENS_ constant used.
    lensTests: (5, 4), one row for LENS_FIXED to LENS_K3: Wald statistic of the coefficients the model lacks, their
        number, p-value, information criterion.
    poseCorrections: (V, 6) rotation vector and translation in the base frame: true R = exp(w) R_gripper2base.
    viewRms: (V, 1) RMS residual of the points used.
    residuals: (V, 2 N): dx, dy of every point, predicted - measured; NaN = not seen.
    rejectedObservations: (V, N) uint8, 1 where an image point was left out.
    rejectedViews: views whose reported pose was not believed.
    rejectedSegments: stripe segments left out.
    stripeResiduals: (S, 2) distances of the two ends of every segment from its prediction; NaN = not used.
    stripeGroups: (G, 6), a row for every group of equal orientation whose stripes were used: first view, number of
        views, of segments and of surfaces, and the standard deviations of the light plane's normal (rad) and offset
        without the stripes of this group (all else alike); infinite = the light plane would not be determined.
    culprits: what was left out or not believed, and why.
    scenePoints: (N, 3) in the base frame; NaN = not determined.
    weakDirections: what the data determine badly, and what motion would cure it.
    workingDistance: median depth of the scene points.
    toolCovariance: (3, 3), gripper frame, of a scene point on the central ray at the working distance.
)doc";

using Array = py::array_t<double>;
using RefineResult = py::typing::Tuple<double, Array, Array, Array, Array, py::typing::Optional<Array>, RefineSummary>;

std::vector<cv::Mat> optionalMatrices(const py::object& values, const std::string& name)
{
    return values.is_none() ? std::vector<cv::Mat>() : matrices(values, name);
}

RefineResult refine(const ArrayLike& R_gripper2base, const ArrayLike& t_gripper2base, const ArrayLike& imagePoints,
                    const OptionalArrayLike& cameraMatrix, const OptionalArrayLike& distCoeffs,
                    const OptionalArrayLike& R_cam2gripper, const OptionalArrayLike& t_cam2gripper,
                    const OptionalArrayLike& lightPlane, const OptionalArrayLike& stripePoints,
                    const OptionalArrayLike& stripeViews, const OptionalArrayLike& surfaceIds,
                    const OptionalArrayLike& objectPoints, const OptionalArrayLike& pointSigmas,
                    const OptionalArrayLike& stripeSigmas, const RefineParams& params)
{
    const auto R = matrices(R_gripper2base, "R_gripper2base"), t = matrices(t_gripper2base, "t_gripper2base");
    const auto points = matrices(imagePoints, "imagePoints"), stripes = optionalMatrices(stripePoints, "stripePoints");
    const auto sigmas = optionalMatrices(pointSigmas, "pointSigmas");
    const cv::Mat views = optionalMatrix(stripeViews, "stripeViews"), ids = optionalMatrix(surfaceIds, "surfaceIds");
    const cv::Mat objects = optionalMatrix(objectPoints, "objectPoints");
    const cv::Mat lineSigmas = optionalMatrix(stripeSigmas, "stripeSigmas");
    cv::Mat K = optionalMatrix(cameraMatrix, "cameraMatrix"), D = optionalMatrix(distCoeffs, "distCoeffs");
    cv::Mat Rx = optionalMatrix(R_cam2gripper, "R_cam2gripper"), tx = optionalMatrix(t_cam2gripper, "t_cam2gripper");
    cv::Mat plane = optionalMatrix(lightPlane, "lightPlane");
    RefineSummary summary;
    const double rms = unlocked(
        [&]
        {
            return refineHandEye(R, t, points, K, D, Rx, tx, plane, summary, stripes, views, ids, objects, sigmas,
                                 lineSigmas, params);
        });
    const py::object light = plane.empty() ? py::object(py::none()) : array<double>(plane);
    return py::make_tuple(rms, array<double>(K), array<double>(D), array<double>(Rx), array<double>(tx), light,
                          summary);
}

void bindRefineParams(py::module_& m)
{
    py::class_<RefineParams>(m, "RefineParams", refineParamsDoc)
        .def(py::init<>())
        .def_readwrite("flags", &RefineParams::flags)
        .def_readwrite("lensModel", &RefineParams::lensModel)
        .def_readwrite("pointSigma", &RefineParams::pointSigma)
        .def_readwrite("stripeSigma", &RefineParams::stripeSigma)
        .def_readwrite("robotTranslationSigma", &RefineParams::robotTranslationSigma)
        .def_readwrite("robotRotationSigma", &RefineParams::robotRotationSigma)
        .def_readwrite("huberThreshold", &RefineParams::huberThreshold)
        .def_readwrite("rejectThreshold", &RefineParams::rejectThreshold)
        .def_readwrite("maxIterations", &RefineParams::maxIterations)
        .def_readwrite("orientationTolerance", &RefineParams::orientationTolerance);
}

template <typename T, cv::Mat RefineSummary::* member>
py::array_t<T> read(const RefineSummary& summary)
{
    return array<T>(summary.*member);
}

void bindRefineSummary(py::module_& m)
{
    py::class_<RefineSummary>(m, "RefineSummary", refineSummaryDoc)
        .def_readonly("usable", &RefineSummary::usable)
        .def_readonly("message", &RefineSummary::message)
        .def_readonly("stopReason", &RefineSummary::stopReason)
        .def_readonly("iterations", &RefineSummary::iterations)
        .def_readonly("rms", &RefineSummary::rms)
        .def_readonly("parameterNames", &RefineSummary::parameterNames)
        .def_property_readonly("covariance", read<double, &RefineSummary::covariance>)
        .def_property_readonly("standardDeviations", read<double, &RefineSummary::standardDeviations>)
        .def_property_readonly("degreesOfFreedom", read<double, &RefineSummary::degreesOfFreedom>)
        .def_property_readonly("intervals95", read<double, &RefineSummary::intervals95>)
        .def_readonly("pointSigma", &RefineSummary::pointSigma)
        .def_readonly("stripeSigma", &RefineSummary::stripeSigma)
        .def_readonly("robotTranslationSigma", &RefineSummary::robotTranslationSigma)
        .def_readonly("robotRotationSigma", &RefineSummary::robotRotationSigma)
        .def_property_readonly("noiseLevels", read<double, &RefineSummary::noiseLevels>)
        .def_readonly("chiSquare", &RefineSummary::chiSquare)
        .def_readonly("chiSquareDof", &RefineSummary::chiSquareDof)
        .def_readonly("chiSquarePValue", &RefineSummary::chiSquarePValue)
        .def_readonly("lensModel", &RefineSummary::lensModel)
        .def_property_readonly("lensTests", read<double, &RefineSummary::lensTests>)
        .def_property_readonly("poseCorrections", read<double, &RefineSummary::poseCorrections>)
        .def_property_readonly("viewRms", read<double, &RefineSummary::viewRms>)
        .def_property_readonly("residuals", read<double, &RefineSummary::residuals>)
        .def_property_readonly("rejectedObservations", read<uchar, &RefineSummary::rejectedObservations>)
        .def_readonly("rejectedViews", &RefineSummary::rejectedViews)
        .def_readonly("rejectedSegments", &RefineSummary::rejectedSegments)
        .def_property_readonly("stripeResiduals", read<double, &RefineSummary::stripeResiduals>)
        .def_property_readonly("stripeGroups", read<double, &RefineSummary::stripeGroups>)
        .def_readonly("culprits", &RefineSummary::culprits)
        .def_property_readonly("scenePoints", read<double, &RefineSummary::scenePoints>)
        .def_readonly("weakDirections", &RefineSummary::weakDirections)
        .def_readonly("workingDistance", &RefineSummary::workingDistance)
        .def_property_readonly("toolCovariance", read<double, &RefineSummary::toolCovariance>);
}

} // namespace

void bindRefine(py::module_& m)
{
    m.attr("REFINE_FIX_K") = int(REFINE_FIX_K);
    m.attr("REFINE_SKEW") = int(REFINE_SKEW);
    m.attr("REFINE_FIX_ASPECT") = int(REFINE_FIX_ASPECT);
    m.attr("REFINE_FIX_ROTATION") = int(REFINE_FIX_ROTATION);
    m.attr("REFINE_FIX_TRANSLATION") = int(REFINE_FIX_TRANSLATION);
    m.attr("REFINE_FIX_LIGHT_PLANE") = int(REFINE_FIX_LIGHT_PLANE);
    m.attr("REFINE_ALLOW_PARTIAL") = int(REFINE_ALLOW_PARTIAL);
    m.attr("LENS_AUTO") = int(LENS_AUTO);
    m.attr("LENS_FIXED") = int(LENS_FIXED);
    m.attr("LENS_K1") = int(LENS_K1);
    m.attr("LENS_K1_K2") = int(LENS_K1_K2);
    m.attr("LENS_TANGENTIAL") = int(LENS_TANGENTIAL);
    m.attr("LENS_K3") = int(LENS_K3);
    bindRefineParams(m);
    bindRefineSummary(m);
    m.def("refineHandEye", refine, py::arg("R_gripper2base"), py::arg("t_gripper2base"), py::arg("imagePoints"),
          py::arg("cameraMatrix"), py::arg("distCoeffs"), py::arg("R_cam2gripper"), py::arg("t_cam2gripper"),
          py::arg("lightPlane"), py::kw_only(), py::arg("stripePoints") = py::none(),
          py::arg("stripeViews") = py::none(), py::arg("surfaceIds") = py::none(), py::arg("objectPoints") = py::none(),
          py::arg("pointSigmas") = py::none(), py::arg("stripeSigmas") = py::none(),
          py::arg_v("params", RefineParams(), "RefineParams()"), refineDoc);
}

} // namespace active_handeye_python
