// SPDX-FileCopyrightText: 2026 active_handeye contributors
// SPDX-License-Identifier: Apache-2.0

#include "bind.hpp"
#include "convert.hpp"

#include <pybind11/stl.h>

namespace active_handeye_python {

using namespace cv::active_handeye;

namespace {

const char* const predictDoc =
    R"doc(Predicts the covariance that refineHandEye would reach with images that have not been taken yet.

The problem of the refinement is built at the assumed truth, linearised there, and inverted; nothing is simulated. A
scene point is seen where it projects into the image from in front of the camera; points that only one view sees do not
count.

Args:
    R_gripper2base: V planned rotations of the gripper in the robot's base frame, (3, 3) or rotation vectors.
    t_gripper2base: V planned translations of 3 numbers, any unit of length.
    scenePoints: (N, 3), assumed scene points, base frame.
    imageSize: width and height, pixels.
    cameraMatrix: (3, 3), assumed.
    distCoeffs: k1, k2, p1, p2[, k3], assumed; None = zero.
    R_cam2gripper: assumed, (3, 3) or rotation vector.
    t_cam2gripper: assumed, 3 numbers.
    lightPlane: nx, ny, nz, d, n.X = d in the camera frame, assumed; None = no stripes.
    surfaces: (S, 4), planes wx, wy, wz, e of the scene, w.X = e in the base frame; w points to the side from which it
        is seen. A scene point nearer to a plane than 1 % of its distance from the camera is not seen from behind it.
        With lightPlane every view sees the stripe on every plane, as far as the image reaches; those on planes that
        one view alone sees do not count.
    params: noise levels, all of which are needed (stripeSigma only with lightPlane); flags and lensModel as for
        refineHandEye. LENS_AUTO is the smallest model that has the coefficients of distCoeffs.

Returns:
    retval: standard deviation of t_cam2gripper: root of the sum of the three variances.
    covariance: (20, 20), order of RefineSummary.parameterNames; rows of fixed parameters are 0, variances of
        undetermined ones infinite.
    weakDirections: what the planned views would determine badly, by name, and what motion would cure it.
    seenPoints: (V, 1), the points that each view shares with another.

Raises:
    error: wrong input (StsBadArg, StsBadSize, StsOutOfRange); StsNoConv when no point is seen twice.

Source: doc/method/planning.md.
)doc";

const char* const planDoc =
    R"doc(Chooses, from possible views, those with which refineHandEye would know t_cam2gripper best.

Greedy choice, then exchange, by the sum of the variances of t_cam2gripper; doc/method/planning.md says what the search
approximates. The value returned is that of predictHandEyeCovariance.

Args:
    R_gripper2base: V rotations, (3, 3) or rotation vectors: views taken already and possible ones.
    t_gripper2base: V translations of 3 numbers, any unit of length.
    scenePoints: (N, 3), assumed scene points, base frame.
    imageSize: width and height, pixels.
    cameraMatrix: (3, 3), assumed.
    distCoeffs: k1, k2, p1, p2[, k3], assumed; None = zero.
    R_cam2gripper: assumed, (3, 3) or rotation vector.
    t_cam2gripper: assumed, 3 numbers.
    stops: how many views there are to be, those taken included.
    taken: numbers of the views that were taken already; None = none.
    params: noise levels, flags and lens model as for predictHandEyeCovariance.
    planParams: what the choice has to have.

Returns:
    retval: standard deviation of t_cam2gripper with all of them.
    chosen: the new views by their numbers, in groups of equal orientation: those with most views first, and in every
        group the one that tells most first.

Raises:
    error: wrong input (StsBadArg, StsBadSize, StsOutOfRange); StsNoConv when the possible views do not hold groups of
        translations, or turns about two axes.

Source: doc/method/planning.md.
)doc";

const char* const planParamsDoc = R"doc(Settings of planHandEyeViews.

Attributes:
    groups: orientations at which there have to be enough views for the closed forms; negative (default) = 2, with
        REFINE_FIX_K 1.
    viewsPerGroup: views that are enough; negative (default) = 4 whose translations span space, with REFINE_FIX_K 3
        that span a plane.
    exchanges: rounds in which every view may be exchanged for a better one; default 3.
    seenShare: share of the scene points, 0 to 1, that a view has to see to be chosen; default 0.25.
)doc";

using Array = py::array_t<double>;
using ImageSize = std::pair<int, int>;
using Prediction = py::typing::Tuple<double, Array, std::vector<std::string>, py::array_t<int>>;
using Choice = py::typing::Tuple<double, std::vector<int>>;

Prediction predict(const ArrayLike& R_gripper2base, const ArrayLike& t_gripper2base, const ArrayLike& scenePoints,
                   const ImageSize& imageSize, const ArrayLike& cameraMatrix, const OptionalArrayLike& distCoeffs,
                   const ArrayLike& R_cam2gripper, const ArrayLike& t_cam2gripper, const OptionalArrayLike& lightPlane,
                   const OptionalArrayLike& surfaces, const RefineParams& params)
{
    const auto R = matrices(R_gripper2base, "R_gripper2base"), t = matrices(t_gripper2base, "t_gripper2base");
    const cv::Mat points = matrix(scenePoints, "scenePoints"), K = matrix(cameraMatrix, "cameraMatrix");
    const cv::Mat D = optionalMatrix(distCoeffs, "distCoeffs"), Rx = matrix(R_cam2gripper, "R_cam2gripper");
    const cv::Mat tx = matrix(t_cam2gripper, "t_cam2gripper"), light = optionalMatrix(lightPlane, "lightPlane");
    const cv::Mat planes = optionalMatrix(surfaces, "surfaces");
    cv::Mat covariance, seen;
    std::vector<std::string> weak;
    const double sigma = unlocked(
        [&]
        {
            return predictHandEyeCovariance(R, t, points, cv::Size(imageSize.first, imageSize.second), K, D, Rx, tx,
                                            covariance, weak, seen, light, planes, params);
        });
    return py::make_tuple(sigma, array<double>(covariance), weak, array<int>(seen));
}

Choice plan(const ArrayLike& R_gripper2base, const ArrayLike& t_gripper2base, const ArrayLike& scenePoints,
            const ImageSize& imageSize, const ArrayLike& cameraMatrix, const OptionalArrayLike& distCoeffs,
            const ArrayLike& R_cam2gripper, const ArrayLike& t_cam2gripper, int stops, const OptionalArrayLike& taken,
            const RefineParams& params, const PlanParams& planParams)
{
    const auto R = matrices(R_gripper2base, "R_gripper2base"), t = matrices(t_gripper2base, "t_gripper2base");
    const cv::Mat points = matrix(scenePoints, "scenePoints"), K = matrix(cameraMatrix, "cameraMatrix");
    const cv::Mat D = optionalMatrix(distCoeffs, "distCoeffs"), Rx = matrix(R_cam2gripper, "R_cam2gripper");
    const cv::Mat tx = matrix(t_cam2gripper, "t_cam2gripper"), before = optionalMatrix(taken, "taken");
    std::vector<int> chosen;
    const double sigma = unlocked(
        [&]
        {
            return planHandEyeViews(R, t, points, cv::Size(imageSize.first, imageSize.second), K, D, Rx, tx, stops,
                                    chosen, before, params, planParams);
        });
    return py::make_tuple(sigma, chosen);
}

} // namespace

void bindPlanning(py::module_& m)
{
    py::class_<PlanParams>(m, "PlanParams", planParamsDoc)
        .def(py::init<>())
        .def_readwrite("groups", &PlanParams::groups)
        .def_readwrite("viewsPerGroup", &PlanParams::viewsPerGroup)
        .def_readwrite("exchanges", &PlanParams::exchanges)
        .def_readwrite("seenShare", &PlanParams::seenShare);
    m.def("predictHandEyeCovariance", predict, py::arg("R_gripper2base"), py::arg("t_gripper2base"),
          py::arg("scenePoints"), py::arg("imageSize"), py::arg("cameraMatrix"), py::arg("distCoeffs"),
          py::arg("R_cam2gripper"), py::arg("t_cam2gripper"), py::kw_only(), py::arg("lightPlane") = py::none(),
          py::arg("surfaces") = py::none(), py::arg_v("params", RefineParams(), "RefineParams()"), predictDoc);
    m.def("planHandEyeViews", plan, py::arg("R_gripper2base"), py::arg("t_gripper2base"), py::arg("scenePoints"),
          py::arg("imageSize"), py::arg("cameraMatrix"), py::arg("distCoeffs"), py::arg("R_cam2gripper"),
          py::arg("t_cam2gripper"), py::arg("stops"), py::kw_only(), py::arg("taken") = py::none(),
          py::arg_v("params", RefineParams(), "RefineParams()"), py::arg_v("planParams", PlanParams(), "PlanParams()"),
          planDoc);
}

} // namespace active_handeye_python
