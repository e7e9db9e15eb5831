// SPDX-FileCopyrightText: 2026 active_handeye contributors
// SPDX-License-Identifier: Apache-2.0

#include "bind.hpp"
#include "convert.hpp"

namespace active_handeye_python {

using namespace cv::active_handeye;

namespace {

const char* const reprojectDoc = R"doc(Points in space from the pixels of a laser stripe, with their covariances.

The viewing ray of a pixel meets the light plane in one point. Without the transforms the points are in the camera frame, with
R_cam2gripper and t_cam2gripper in the gripper frame, with the robot's pose as well in the base frame. All pixels of one
call were seen in one view. Covariances are first order in the errors of calibration, pixel and robot pose, as far as
these are given; the points of one call share the errors of calibration and pose.

Args:
    stripePoints: (M, 2) pixels of the distorted image, as from detectStripe; M may be 0.
    cameraMatrix: (3, 3).
    distCoeffs: k1, k2, p1, p2[, k3] as in OpenCV; None = no distortion.
    lightPlane: nx, ny, nz, d in the camera frame, n.X = d, |n| = 1, d > 0.
    R_cam2gripper: rotation of the camera in the gripper frame, (3, 3) or rotation vector; None with t_cam2gripper.
    t_cam2gripper: position of the camera in the gripper frame, in the unit of d.
    R_gripper2base: rotation of the gripper in this view, (3, 3) or rotation vector; None with t_gripper2base.
    t_gripper2base: position of the gripper in this view, in the unit of d.
    calibrationCovariance: (20, 20), RefineSummary.covariance; infinite variances mark parameters that were not observed.
    pixelSigmas: standard deviation of each image coordinate, pixels: one number or M numbers.
    robotTranslationSigma: standard deviation of each coordinate of t_gripper2base.
    robotRotationSigma: standard deviation of each component of the rotation error vector w of the robot, rad: true R =
        exp(w) R_gripper2base.

Returns:
    points3D: (M, 3), in the unit of d.
    covariances: (M, 3, 3); None when no source of error is given. A coordinate that hangs on a parameter of infinite
        variance has infinite variance, and covariance 0 with the others.

Raises:
    error: wrong input (StsBadArg, StsBadSize, StsOutOfRange); pixels whose ray does not meet the light plane in front of
        the camera (they are named).

Source: doc/method/measure.md; the paper's equation (1).
)doc";

using MeasureResult = py::typing::Tuple<py::array_t<double>, py::typing::Optional<py::array_t<double>>>;

//! As optionalMatrix(), for one number too.
cv::Mat numberOrMatrix(const py::object& values, const std::string& name)
{
    const bool isNumber = PyNumber_Check(values.ptr()) && !PySequence_Check(values.ptr());
    return isNumber ? matrix(py::make_tuple(values), name) : optionalMatrix(values, name);
}

py::object covarianceArray(const cv::Mat& covariances)
{
    if (covariances.dims != 3)
        return py::none();
    return py::array_t<double>({covariances.size[0], 3, 3}, reinterpret_cast<const double*>(covariances.data));
}

MeasureResult reproject(const ArrayLike& stripePoints, const ArrayLike& cameraMatrix,
                        const OptionalArrayLike& distCoeffs, const ArrayLike& lightPlane,
                        const OptionalArrayLike& R_cam2gripper, const OptionalArrayLike& t_cam2gripper,
                        const OptionalArrayLike& R_gripper2base, const OptionalArrayLike& t_gripper2base,
                        const OptionalArrayLike& calibrationCovariance, const OptionalArrayLike& pixelSigmas,
                        double robotTranslationSigma, double robotRotationSigma)
{
    const cv::Mat pixels = matrix(stripePoints, "stripePoints"), K = matrix(cameraMatrix, "cameraMatrix");
    const cv::Mat D = optionalMatrix(distCoeffs, "distCoeffs"), light = matrix(lightPlane, "lightPlane");
    const cv::Mat Rx = optionalMatrix(R_cam2gripper, "R_cam2gripper");
    const cv::Mat tx = optionalMatrix(t_cam2gripper, "t_cam2gripper");
    const cv::Mat R = optionalMatrix(R_gripper2base, "R_gripper2base");
    const cv::Mat t = optionalMatrix(t_gripper2base, "t_gripper2base");
    const cv::Mat C = optionalMatrix(calibrationCovariance, "calibrationCovariance");
    const cv::Mat sigmas = numberOrMatrix(pixelSigmas, "pixelSigmas");
    cv::Mat points, covariances;
    unlocked(
        [&]
        {
            reprojectStripe(pixels, K, D, light, points, covariances, Rx, tx, R, t, C, sigmas, robotTranslationSigma,
                            robotRotationSigma);
        });
    return py::make_tuple(array<double>(points), covarianceArray(covariances));
}

} // namespace

void bindMeasure(py::module_& m)
{
    m.def("reprojectStripe", reproject, py::arg("stripePoints"), py::arg("cameraMatrix"), py::arg("distCoeffs"),
          py::arg("lightPlane"), py::kw_only(), py::arg("R_cam2gripper") = py::none(),
          py::arg("t_cam2gripper") = py::none(), py::arg("R_gripper2base") = py::none(),
          py::arg("t_gripper2base") = py::none(), py::arg("calibrationCovariance") = py::none(),
          py::arg("pixelSigmas") = py::none(), py::arg("robotTranslationSigma") = 0.0,
          py::arg("robotRotationSigma") = 0.0, reprojectDoc);
}

} // namespace active_handeye_python
