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
    t_cam2gripper: position of the camera in the gripper frame, 3 numbers in the unit of d.
    R_gripper2base: rotation of the gripper in this view, (3, 3) or rotation vector; None with t_gripper2base.
    t_gripper2base: position of the gripper in this view, 3 numbers in the unit of d.
    calibrationCovariance: (20, 20), RefineSummary.covariance; infinite variances mark parameters that were not observed.
    pixelSigmas: standard deviation of each image coordinate, pixels: one number or M numbers.
    robotTranslationSigma: standard deviation of each coordinate of t_gripper2base.
    robotRotationSigma: standard deviation of each component of the rotation error vector w of the robot, rad: true R =
        exp(w) R_gripper2base.
    allowMissed: False: a pixel whose ray does not meet the light plane in front of the camera is an error. True: its
        point and covariance are NaN.

Returns:
    points3D: (M, 3), in the unit of d.
    covariances: (M, 3, 3); None when no source of error is given. A coordinate that hangs on a parameter of infinite
        variance has infinite variance, and covariance 0 with the others.

Raises:
    error: wrong input (StsBadArg, StsBadSize, StsOutOfRange); pixels that miss the light plane (they are named).

Source: doc/method/measure.md; the paper's equation (1).
)doc";

const char* const measureDoc =
    R"doc(Points of the base frame, each from what one or more views saw of it, with their covariances.

Every view places a point as reprojectStripe does; the views of one point are combined by generalised least squares.
Errors of pixels are independent, those of the robot's pose common to all pixels of a view, those of the calibration
common to everything: the covariance says by how much several views improve on one, which is not by their number.

Args:
    R_gripper2base: V rotations of the gripper in the robot's base frame, (3, 3) or rotation vectors.
    t_gripper2base: V translations of 3 numbers.
    stripePoints: (N, 2) pixels of the distorted images, as from locateOnStripe or findProfileCorners.
    stripeViews: N integers, the view (0 .. V-1) in which each pixel was seen.
    pointIds: N integers from 0 to P-1, each at least once: the point that each pixel shows.
    cameraMatrix: (3, 3).
    distCoeffs: k1, k2, p1, p2[, k3] as in OpenCV; None = no distortion.
    lightPlane: nx, ny, nz, d in the camera frame, n.X = d, |n| = 1, d > 0.
    R_cam2gripper: rotation of the camera in the gripper frame, (3, 3) or rotation vector.
    t_cam2gripper: position of the camera in the gripper frame, 3 numbers.
    calibrationCovariance: (20, 20), RefineSummary.covariance; None = the calibration counts as exact.
    pixelCovariances: (N, 2, 2) pixels^2, not zero, as from locateOnStripe or findProfileCorners.
    robotTranslationSigma: as in reprojectStripe.
    robotRotationSigma: as in reprojectStripe.

Returns:
    points3D: (P, 3) in the base frame, in the unit of the poses.
    covariances: (P, 3, 3). A coordinate that hangs on a parameter of infinite variance has infinite variance.
    disagreements: (N, 1) squared Mahalanobis distance of what a pixel alone says from the combined point: chi-square
        with 3 degrees of freedom or fewer, if the errors are as stated; 0 for a point seen once.

Raises:
    error: wrong input; pixels that miss the light plane (they are named).

Source: doc/method/measure.md.
)doc";

using MeasureResult = py::typing::Tuple<py::array_t<double>, py::typing::Optional<py::array_t<double>>>;

//! As optionalMatrix(), for one number too.
cv::Mat numberOrMatrix(const py::object& values, const std::string& name)
{
    const bool isNumber = PyNumber_Check(values.ptr()) && !PySequence_Check(values.ptr());
    return isNumber ? matrix(py::make_tuple(values), name) : optionalMatrix(values, name);
}

using PointsResult = py::typing::Tuple<py::array_t<double>, py::array_t<double>, py::array_t<double>>;

MeasureResult reproject(const ArrayLike& stripePoints, const ArrayLike& cameraMatrix,
                        const OptionalArrayLike& distCoeffs, const ArrayLike& lightPlane,
                        const OptionalArrayLike& R_cam2gripper, const OptionalArrayLike& t_cam2gripper,
                        const OptionalArrayLike& R_gripper2base, const OptionalArrayLike& t_gripper2base,
                        const OptionalArrayLike& calibrationCovariance, const OptionalArrayLike& pixelSigmas,
                        double robotTranslationSigma, double robotRotationSigma, bool allowMissed)
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
                            robotRotationSigma, allowMissed);
        });
    const py::object blocks = covariances.dims == 3 ? py::object(matrixArray(covariances)) : py::none();
    return py::make_tuple(array<double>(points), blocks);
}

PointsResult measurePoints(const ArrayLike& R_gripper2base, const ArrayLike& t_gripper2base,
                           const ArrayLike& stripePoints, const ArrayLike& stripeViews, const ArrayLike& pointIds,
                           const ArrayLike& cameraMatrix, const OptionalArrayLike& distCoeffs,
                           const ArrayLike& lightPlane, const ArrayLike& R_cam2gripper, const ArrayLike& t_cam2gripper,
                           const OptionalArrayLike& calibrationCovariance, const ArrayLike& pixelCovariances,
                           double robotTranslationSigma, double robotRotationSigma)
{
    const auto R = matrices(R_gripper2base, "R_gripper2base"), t = matrices(t_gripper2base, "t_gripper2base");
    const cv::Mat pixels = matrix(stripePoints, "stripePoints"), views = matrix(stripeViews, "stripeViews");
    const cv::Mat ids = matrix(pointIds, "pointIds"), K = matrix(cameraMatrix, "cameraMatrix");
    const cv::Mat D = optionalMatrix(distCoeffs, "distCoeffs"), light = matrix(lightPlane, "lightPlane");
    const cv::Mat Rx = matrix(R_cam2gripper, "R_cam2gripper"), tx = matrix(t_cam2gripper, "t_cam2gripper");
    const cv::Mat C = optionalMatrix(calibrationCovariance, "calibrationCovariance");
    const cv::Mat pixelBlocks = matrix(pixelCovariances, "pixelCovariances");
    cv::Mat points, covariances, disagreements;
    unlocked(
        [&]
        {
            measureStripePoints(R, t, pixels, views, ids, K, D, light, Rx, tx, points, covariances, disagreements, C,
                                pixelBlocks, robotTranslationSigma, robotRotationSigma);
        });
    return py::make_tuple(array<double>(points), matrixArray(covariances), array<double>(disagreements));
}

} // namespace

void bindMeasure(py::module_& m)
{
    m.def("reprojectStripe", reproject, py::arg("stripePoints"), py::arg("cameraMatrix"), py::arg("distCoeffs"),
          py::arg("lightPlane"), py::kw_only(), py::arg("R_cam2gripper") = py::none(),
          py::arg("t_cam2gripper") = py::none(), py::arg("R_gripper2base") = py::none(),
          py::arg("t_gripper2base") = py::none(), py::arg("calibrationCovariance") = py::none(),
          py::arg("pixelSigmas") = py::none(), py::arg("robotTranslationSigma") = 0.0,
          py::arg("robotRotationSigma") = 0.0, py::arg("allowMissed") = false, reprojectDoc);
    m.def("measureStripePoints", measurePoints, py::arg("R_gripper2base"), py::arg("t_gripper2base"),
          py::arg("stripePoints"), py::arg("stripeViews"), py::arg("pointIds"), py::arg("cameraMatrix"),
          py::arg("distCoeffs"), py::arg("lightPlane"), py::arg("R_cam2gripper"), py::arg("t_cam2gripper"),
          py::kw_only(), py::arg("calibrationCovariance"), py::arg("pixelCovariances"),
          py::arg("robotTranslationSigma") = 0.0, py::arg("robotRotationSigma") = 0.0, measureDoc);
}

} // namespace active_handeye_python
