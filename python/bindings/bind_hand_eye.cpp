// SPDX-FileCopyrightText: 2026 active_handeye contributors
// SPDX-License-Identifier: Apache-2.0

#include "bind.hpp"
#include "convert.hpp"

#include <pybind11/stl.h>

namespace active_handeye_python {

using namespace cv::active_handeye;

namespace {

const char* const handEyeDoc =
    R"doc(Hand-eye transform from poses of the robot and poses of a target, as cv2.calibrateHandEye, but checked.

Names, order and default are those of OpenCV. On exact data all methods give the same; on noisy data the first five give
what OpenCV's methods of the same name do. Motions that do not determine the result, and poses that contradict each other,
are refused by every method. For a camera that is fixed beside the robot (eye-to-hand) pass the inverted robot poses;
the result is camera to base.

Args:
    R_gripper2base: V >= 3 rotations of the gripper in the robot's base frame, (3, 3) or rotation vectors.
    t_gripper2base: V translations of 3 numbers, (3,), (3, 1) or (1, 3), any unit of length.
    R_target2cam: V rotations from the target to the camera, (3, 3) or rotation vectors.
    t_target2cam: V translations, in the unit of t_gripper2base.
    R_cam2gripper: output, as in OpenCV: None, or a (3, 3) array of float64 that is filled.
    t_cam2gripper: output, as in OpenCV: None, or a (3, 1) array of float64 that is filled.
    method: CALIB_HAND_EYE_TSAI, CALIB_HAND_EYE_PARK, CALIB_HAND_EYE_HORAUD, CALIB_HAND_EYE_ANDREFF,
        CALIB_HAND_EYE_DANIILIDIS (the numbers of OpenCV, 0 to 4), or CALIB_HAND_EYE_REFINED (5): maximum likelihood,
        views that contradict the others left out.

Returns:
    R_cam2gripper: (3, 3) rotation of the camera in the gripper frame.
    t_cam2gripper: (3, 1) position of the camera in the gripper frame.

Raises:
    error: wrong input (StsBadArg, StsBadSize, StsOutOfRange): numbers that are not finite, no rotation, lists of different
        lengths, an unknown method, two units of length; StsNoConv when the poses do not determine the result: no turn, all axes
        parallel (the axis is named), turns too small or too large for CALIB_HAND_EYE_TSAI, poses that contradict each other
        (it is said when they would agree inverted).

Source: doc/method/hand_eye.md.
)doc";

const char* const extendedDoc =
    R"doc(As calibrateHandEye with CALIB_HAND_EYE_REFINED, with covariance, noise levels and residuals.

Maximum likelihood of the hand-eye transform and the pose of the target in the base for Gaussian errors of the poses of
camera and robot, whose levels are estimated by restricted maximum likelihood. Views that contradict the others are left
out and named. The result does not depend on the unit of length.

Args:
    R_gripper2base: V >= 3 rotations of the gripper in the robot's base frame, (3, 3) or rotation vectors.
    t_gripper2base: V translations of 3 numbers, any unit of length.
    R_target2cam: V rotations from the target to the camera, (3, 3) or rotation vectors.
    t_target2cam: V translations, in the unit of t_gripper2base.
    params: noise levels.

Returns:
    retval: standard deviation of t_cam2gripper: root of the sum of the three variances.
    R_cam2gripper: (3, 3) rotation of the camera in the gripper frame.
    t_cam2gripper: (3, 1) position of the camera in the gripper frame.
    summary: covariance, intervals, noise levels, residuals, views left out.

Raises:
    error: as calibrateHandEye; StsNoConv also when the noise leaves the result open (the direction is named).

Source: doc/method/hand_eye.md.
)doc";

const char* const handEyeParamsDoc = R"doc(Noise levels of calibrateHandEyeExtended: 0 = exact, negative = estimated.

Attributes:
    targetRotationSigma: standard deviation of a component of the rotation vector of R_target2cam, rad; default estimated.
    targetTranslationSigma: of a component of t_target2cam; default estimated. The noise of t_gripper2base has the same
        effect: one of the two has to be given.
    robotRotationSigma: of a component of the rotation vector of R_gripper2base, rad; default estimated.
    robotTranslationSigma: of a component of t_gripper2base; default 0: targetTranslationSigma covers both.
)doc";

const char* const handEyeSummaryDoc = R"doc(What calibrateHandEyeExtended found out besides the transform.

Lengths in the unit of the translations, angles in rad.

Attributes:
    usable: whether the result may be used; message says why (not).
    message: the verdict in a sentence.
    iterations: of all least-squares solutions together.
    covariance: (6, 6) of rx, ry, rz, tx, ty, tz; the first three are the rotation error vector in the gripper frame, true
        R = exp(error) R_cam2gripper.
    standardDeviations: (6, 1).
    degreesOfFreedom: (6, 1) of Student's t for the intervals.
    intervals95: (6, 2) lower and upper end; the rotation error vector is around 0.
    noiseLevels: (4, 4), rows targetRotation, targetTranslation, robotRotation, robotTranslation: level, its 95 % interval
        (lower, upper), 1 when it was estimated.
    chiSquare, chiSquareDof, chiSquarePValue: test of the residuals; NaN unless all noise levels were given.
    R_target2base: (3, 3).
    t_target2base: (3, 1).
    residuals: (V, 6) rotation vector and translation of the target in the camera frame, predicted - given.
    viewPValues: (V, 2) p-values of the orientation and the position of each view against the others.
    rejectedViews: views that contradict the others and were left out.
    culprits: what was left out, and why, one sentence each.
)doc";

using HandEyeResult = py::typing::Tuple<py::array_t<double>, py::array_t<double>>;
using ExtendedResult = py::typing::Tuple<double, py::array_t<double>, py::array_t<double>, HandEyeSummary>;

//! The result itself, or the caller's array filled with it.
py::array_t<double> output(const OptionalArrayLike& given, const cv::Mat& result, const std::string& name)
{
    auto values = array<double>(result);
    if (given.is_none())
        return values;
    const bool fits = py::isinstance<py::array_t<double>>(given) && given.attr("shape").equal(values.attr("shape"));
    if (!fits || !py::reinterpret_borrow<py::array>(given).writeable())
        CV_Error(cv::Error::StsBadArg, name + ": is an output; needed None or a writable array of float64 of shape " +
                                           std::string(py::str(values.attr("shape"))) + ", given a value of type " +
                                           std::string(py::str(py::type::of(given).attr("__name__"))) +
                                           "; give method by keyword");
    given[py::ellipsis()] = values;
    return py::reinterpret_borrow<py::array_t<double>>(given);
}

HandEyeResult handEye(const ArrayLike& R_gripper2base, const ArrayLike& t_gripper2base, const ArrayLike& R_target2cam,
                      const ArrayLike& t_target2cam, const OptionalArrayLike& R_cam2gripper,
                      const OptionalArrayLike& t_cam2gripper, int method)
{
    const auto Rg = matrices(R_gripper2base, "R_gripper2base"), tg = matrices(t_gripper2base, "t_gripper2base");
    const auto Rc = matrices(R_target2cam, "R_target2cam"), tc = matrices(t_target2cam, "t_target2cam");
    cv::Mat R, t;
    unlocked([&] { calibrateHandEye(Rg, tg, Rc, tc, R, t, HandEyeMethod(method)); });
    return py::make_tuple(output(R_cam2gripper, R, "R_cam2gripper"), output(t_cam2gripper, t, "t_cam2gripper"));
}

ExtendedResult handEyeExtended(const ArrayLike& R_gripper2base, const ArrayLike& t_gripper2base,
                               const ArrayLike& R_target2cam, const ArrayLike& t_target2cam,
                               const HandEyeParams& params)
{
    const auto Rg = matrices(R_gripper2base, "R_gripper2base"), tg = matrices(t_gripper2base, "t_gripper2base");
    const auto Rc = matrices(R_target2cam, "R_target2cam"), tc = matrices(t_target2cam, "t_target2cam");
    cv::Mat R, t;
    HandEyeSummary summary;
    const double deviation = unlocked([&] { return calibrateHandEyeExtended(Rg, tg, Rc, tc, R, t, summary, params); });
    return py::make_tuple(deviation, array<double>(R), array<double>(t), summary);
}

template <cv::Mat HandEyeSummary::* member>
py::array_t<double> read(const HandEyeSummary& summary)
{
    return array<double>(summary.*member);
}

void bindHandEyeTypes(py::module_& m)
{
    py::class_<HandEyeParams>(m, "HandEyeParams", handEyeParamsDoc)
        .def(py::init<>())
        .def_readwrite("targetRotationSigma", &HandEyeParams::targetRotationSigma)
        .def_readwrite("targetTranslationSigma", &HandEyeParams::targetTranslationSigma)
        .def_readwrite("robotRotationSigma", &HandEyeParams::robotRotationSigma)
        .def_readwrite("robotTranslationSigma", &HandEyeParams::robotTranslationSigma);
    py::class_<HandEyeSummary>(m, "HandEyeSummary", handEyeSummaryDoc)
        .def_readonly("usable", &HandEyeSummary::usable)
        .def_readonly("message", &HandEyeSummary::message)
        .def_readonly("iterations", &HandEyeSummary::iterations)
        .def_property_readonly("covariance", read<&HandEyeSummary::covariance>)
        .def_property_readonly("standardDeviations", read<&HandEyeSummary::standardDeviations>)
        .def_property_readonly("degreesOfFreedom", read<&HandEyeSummary::degreesOfFreedom>)
        .def_property_readonly("intervals95", read<&HandEyeSummary::intervals95>)
        .def_property_readonly("noiseLevels", read<&HandEyeSummary::noiseLevels>)
        .def_readonly("chiSquare", &HandEyeSummary::chiSquare)
        .def_readonly("chiSquareDof", &HandEyeSummary::chiSquareDof)
        .def_readonly("chiSquarePValue", &HandEyeSummary::chiSquarePValue)
        .def_property_readonly("R_target2base", read<&HandEyeSummary::R_target2base>)
        .def_property_readonly("t_target2base", read<&HandEyeSummary::t_target2base>)
        .def_property_readonly("residuals", read<&HandEyeSummary::residuals>)
        .def_property_readonly("viewPValues", read<&HandEyeSummary::viewPValues>)
        .def_readonly("rejectedViews", &HandEyeSummary::rejectedViews)
        .def_readonly("culprits", &HandEyeSummary::culprits);
}

} // namespace

void bindHandEye(py::module_& m)
{
    m.attr("CALIB_HAND_EYE_TSAI") = int(CALIB_HAND_EYE_TSAI);
    m.attr("CALIB_HAND_EYE_PARK") = int(CALIB_HAND_EYE_PARK);
    m.attr("CALIB_HAND_EYE_HORAUD") = int(CALIB_HAND_EYE_HORAUD);
    m.attr("CALIB_HAND_EYE_ANDREFF") = int(CALIB_HAND_EYE_ANDREFF);
    m.attr("CALIB_HAND_EYE_DANIILIDIS") = int(CALIB_HAND_EYE_DANIILIDIS);
    m.attr("CALIB_HAND_EYE_REFINED") = int(CALIB_HAND_EYE_REFINED);
    bindHandEyeTypes(m);
    m.def("calibrateHandEye", handEye, py::arg("R_gripper2base"), py::arg("t_gripper2base"), py::arg("R_target2cam"),
          py::arg("t_target2cam"), py::arg("R_cam2gripper") = py::none(), py::arg("t_cam2gripper") = py::none(),
          py::arg("method") = int(CALIB_HAND_EYE_TSAI), handEyeDoc);
    m.def("calibrateHandEyeExtended", handEyeExtended, py::arg("R_gripper2base"), py::arg("t_gripper2base"),
          py::arg("R_target2cam"), py::arg("t_target2cam"), py::kw_only(),
          py::arg_v("params", HandEyeParams(), "HandEyeParams()"), extendedDoc);
}

} // namespace active_handeye_python
