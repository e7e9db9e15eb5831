// SPDX-FileCopyrightText: 2026 active_handeye contributors
// SPDX-License-Identifier: Apache-2.0

#include "bind.hpp"
#include "convert.hpp"

namespace active_handeye_python {

using namespace cv::active_handeye;

namespace {

const char* const rotationDoc = R"doc(Hand-eye translation from changes of orientation, with K and R_cam2gripper known.

Every image point gives two equations that are linear in its scene point and in t_cam2gripper; the scene points are
eliminated and a 3 x 3 system remains. Needed: two changes of orientation about axes that are not parallel, and some
translation of the gripper, which gives the scale.

Args:
    R_gripper2base: V rotations of the gripper in the robot's base frame, (3, 3) or rotation vectors.
    t_gripper2base: V translations of 3 numbers, any unit of length; the result has the same one.
    imagePoints: V arrays (N, 2), pixels of the distorted image; row j is the same scene point in every view;
        NaN, NaN = not seen. Wrong matches are left out.
    cameraMatrix: (3, 3).
    distCoeffs: k1, k2, p1, p2[, k3] as in OpenCV; None = no distortion.
    R_cam2gripper: rotation of the camera in the gripper frame, (3, 3) or rotation vector.
    flags: ROTATION_ALLOW_PARTIAL: with one axis only, answer with the component along it 0 and its variance infinite.

Returns:
    retval: RMS distance between image points and their predictions, pixels.
    t_cam2gripper: (3, 1) position of the camera in the gripper frame.
    covariance: (3, 3) for given K and R_cam2gripper. Covers image noise and, where the residuals show it, jitter of the
        reported orientations, both estimated; not other errors of the robot. A component that is not observed has infinite variance.

Raises:
    error: wrong input (StsBadArg, StsBadSize, StsOutOfRange); StsNoConv when the data cannot answer: no change of
        orientation, all axes parallel (the axis is named), no translation, no points in common, no parallax, scene
        points behind the camera (inverted poses), a view that contradicts the others (named).

Source: doc/method/rotation.md; the paper's equations (35) to (43), corrected.
)doc";

using RotationResult = py::typing::Tuple<double, py::array_t<double>, py::array_t<double>>;

RotationResult rotation(const ArrayLike& R_gripper2base, const ArrayLike& t_gripper2base, const ArrayLike& imagePoints,
                        const ArrayLike& cameraMatrix, const OptionalArrayLike& distCoeffs,
                        const ArrayLike& R_cam2gripper, int flags)
{
    const auto R = matrices(R_gripper2base, "R_gripper2base"), t = matrices(t_gripper2base, "t_gripper2base");
    const auto points = matrices(imagePoints, "imagePoints");
    const cv::Mat K = matrix(cameraMatrix, "cameraMatrix"), D = optionalMatrix(distCoeffs, "distCoeffs");
    const cv::Mat X = matrix(R_cam2gripper, "R_cam2gripper");
    cv::Mat tx, cov;
    const double rms = unlocked([&] { return calibrateHandEyeRotation(R, t, points, K, D, X, tx, cov, flags); });
    return py::make_tuple(rms, array<double>(tx), array<double>(cov));
}

} // namespace

void bindRotation(py::module_& m)
{
    m.attr("ROTATION_ALLOW_PARTIAL") = int(ROTATION_ALLOW_PARTIAL);
    m.def("calibrateHandEyeRotation", rotation, py::arg("R_gripper2base"), py::arg("t_gripper2base"),
          py::arg("imagePoints"), py::arg("cameraMatrix"), py::arg("distCoeffs"), py::arg("R_cam2gripper"),
          py::kw_only(), py::arg("flags") = 0, rotationDoc);
}

} // namespace active_handeye_python
