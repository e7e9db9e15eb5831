// SPDX-FileCopyrightText: 2026 active_handeye contributors
// SPDX-License-Identifier: Apache-2.0

#include "bind.hpp"
#include "convert.hpp"

#include <pybind11/stl.h>

namespace active_handeye_python {

using namespace cv::active_handeye;

namespace {

const char* const verifyDoc = R"doc(Asks new views whether a calibration is still valid.

Scene points are triangulated from the new views with the calibration and the reported poses; few views suffice. A
score test compares the shift of the parameters that the views ask for with the covariance of views and calibration
together; every view is also predicted from the others.

Args:
    R_gripper2base: V rotations of the gripper in the robot's base frame, (3, 3) or rotation vectors.
    t_gripper2base: V translations of 3 numbers, in the unit of t_cam2gripper.
    imagePoints: V arrays (N, 2), pixels of the distorted image; row j is the same scene point in every view;
        NaN, NaN = not seen.
    cameraMatrix: (3, 3).
    distCoeffs: k1, k2, p1, p2[, k3]; None = no distortion.
    R_cam2gripper: (3, 3) or rotation vector.
    t_cam2gripper: 3 numbers.
    covariance: (20, 20) of the calibration, as RefineSummary.covariance.
    pointSigmas: V arrays of N standard deviations of the image points, pixels; None = all alike.
    params: noise levels, usually those that refineHandEye found.

Returns:
    retval: RMS error, pixels, of the views predicted from each other.
    summary: verdict, tests, shift of the parameters, errors of the views.

Raises:
    error: wrong input (StsBadArg, StsBadSize, StsOutOfRange); StsNoConv when no point is seen in two views.

Source: doc/method/verify.md.
)doc";

const char* const verifyParamsDoc = R"doc(Noise levels that verifyHandEye takes as known.

Attributes:
    pointSigma: of one image coordinate, pixels (with pointSigmas: their common factor); default 0.1.
    robotTranslationSigma: of each coordinate of the robot's position; default 0 = exact.
    robotRotationSigma: of each component of the robot's rotation vector, rad; default 0 = exact.
    significance: p-value below which the calibration is not valid any more; default 0.01.
)doc";

const char* const verifySummaryDoc = R"doc(What verifyHandEye found.

Attributes:
    valid: whether the new views agree with the calibration within its covariance.
    message: the verdict in a sentence.
    driftChiSquare, driftDof, driftPValue: test of the calibration's parameters against the new views.
    fitChiSquare, fitDof, fitPValue: test of the residuals that are left when the parameters may shift.
    shift: (20, 1) most likely shift of the parameters, in the order of RefineSummary.parameterNames.
    shiftDeviations: (20, 1) its standard deviations when nothing has changed; 0 = not tested.
    viewErrors: (V, 4) every view predicted from the others: RMS error and RMS expected error of its image points,
        pixels, and the same two on the scene, unit of t_gripper2base; NaN where no point is seen in another view.
    contradictingViews: views whose error is far more than expected.
    usedObservations, rejectedObservations: counts of image points.
)doc";

using VerifyResult = py::typing::Tuple<double, VerifySummary>;

VerifyResult verify(const ArrayLike& R_gripper2base, const ArrayLike& t_gripper2base, const ArrayLike& imagePoints,
                    const ArrayLike& cameraMatrix, const OptionalArrayLike& distCoeffs, const ArrayLike& R_cam2gripper,
                    const ArrayLike& t_cam2gripper, const ArrayLike& covariance, const OptionalArrayLike& pointSigmas,
                    const VerifyParams& params)
{
    const auto R = matrices(R_gripper2base, "R_gripper2base"), t = matrices(t_gripper2base, "t_gripper2base");
    const auto points = matrices(imagePoints, "imagePoints");
    const auto sigmas = pointSigmas.is_none() ? std::vector<cv::Mat>() : matrices(pointSigmas, "pointSigmas");
    const cv::Mat K = matrix(cameraMatrix, "cameraMatrix"), D = optionalMatrix(distCoeffs, "distCoeffs");
    const cv::Mat Rx = matrix(R_cam2gripper, "R_cam2gripper"), tx = matrix(t_cam2gripper, "t_cam2gripper");
    const cv::Mat C = matrix(covariance, "covariance");
    VerifySummary summary;
    const double rms = unlocked([&] { return verifyHandEye(R, t, points, K, D, Rx, tx, C, summary, sigmas, params); });
    return py::make_tuple(rms, summary);
}

template <cv::Mat VerifySummary::* member>
py::array_t<double> read(const VerifySummary& summary)
{
    return array<double>(summary.*member);
}

void bindVerifyTypes(py::module_& m)
{
    py::class_<VerifyParams>(m, "VerifyParams", verifyParamsDoc)
        .def(py::init<>())
        .def_readwrite("pointSigma", &VerifyParams::pointSigma)
        .def_readwrite("robotTranslationSigma", &VerifyParams::robotTranslationSigma)
        .def_readwrite("robotRotationSigma", &VerifyParams::robotRotationSigma)
        .def_readwrite("significance", &VerifyParams::significance);
    py::class_<VerifySummary>(m, "VerifySummary", verifySummaryDoc)
        .def_readonly("valid", &VerifySummary::valid)
        .def_readonly("message", &VerifySummary::message)
        .def_readonly("driftChiSquare", &VerifySummary::driftChiSquare)
        .def_readonly("driftDof", &VerifySummary::driftDof)
        .def_readonly("driftPValue", &VerifySummary::driftPValue)
        .def_readonly("fitChiSquare", &VerifySummary::fitChiSquare)
        .def_readonly("fitDof", &VerifySummary::fitDof)
        .def_readonly("fitPValue", &VerifySummary::fitPValue)
        .def_property_readonly("shift", read<&VerifySummary::shift>)
        .def_property_readonly("shiftDeviations", read<&VerifySummary::shiftDeviations>)
        .def_property_readonly("viewErrors", read<&VerifySummary::viewErrors>)
        .def_readonly("contradictingViews", &VerifySummary::contradictingViews)
        .def_readonly("usedObservations", &VerifySummary::usedObservations)
        .def_readonly("rejectedObservations", &VerifySummary::rejectedObservations);
}

} // namespace

void bindVerify(py::module_& m)
{
    bindVerifyTypes(m);
    m.def("verifyHandEye", verify, py::arg("R_gripper2base"), py::arg("t_gripper2base"), py::arg("imagePoints"),
          py::arg("cameraMatrix"), py::arg("distCoeffs"), py::arg("R_cam2gripper"), py::arg("t_cam2gripper"),
          py::arg("covariance"), py::kw_only(), py::arg("pointSigmas") = py::none(),
          py::arg_v("params", VerifyParams(), "VerifyParams()"), verifyDoc);
}

} // namespace active_handeye_python
