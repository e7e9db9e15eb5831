// SPDX-FileCopyrightText: 2026 active_handeye contributors
// SPDX-License-Identifier: Apache-2.0

#include "bind.hpp"
#include "convert.hpp"

namespace active_handeye_python {

using namespace cv::active_handeye;

namespace {

const char* const lightPlaneDoc = R"doc(Plane of a line laser fixed to the camera, from its stripes on unknown planes.

Stripes on one fixed surface, seen from views that differ by translations only, meet in a vanishing direction of the
light plane; two such directions give its normal, and the way the stripes move with the camera gives its offset. A
maximum likelihood refinement in pixels follows. Segments that contradict the others are left out.

Args:
    R_gripper2base: V rotations of the gripper in the robot's base frame, (3, 3) or rotation vectors.
    t_gripper2base: V translations of 3 numbers, any unit of length; the result has the same one.
    stripePoints: S straight stripe segments, each (M, 2), pixels of the distorted image; see splitStripe.
    stripeViews: S integers, the view (0 .. V-1) in which each segment was seen.
    surfaceIds: S integers, the fixed plane of the scene on which each segment lies; -1 = unknown, not used. An id
        is compared inside a group of equal orientation only. See associateStripes.
    cameraMatrix: (3, 3).
    distCoeffs: k1, k2, p1, p2[, k3] as in OpenCV; None = no distortion.
    R_cam2gripper: rotation of the camera in the gripper frame, (3, 3) or rotation vector.
    knownPoints: (M, 3) points of the light plane in the camera frame, or None.
    orientationTolerance: views whose orientations differ by less (degrees) form one group.

Returns:
    retval: RMS distance, pixels, of the stripe points used to the predicted lines.
    lightPlane: (4, 1): nx, ny, nz, d in the camera frame, n.X = d, |n| = 1, d > 0.
    covariance: (4, 4) covariance of lightPlane, of rank 3.

Raises:
    error: wrong input (StsBadArg, StsBadSize, StsOutOfRange); StsNoConv when the stripes do not determine the
        plane; the text says what is missing, directions in base coordinates.

Source: doc/method/light_plane.md; the paper's equations (22), (25), (30), (31).
)doc";

using LightPlaneResult = py::typing::Tuple<double, py::array_t<double>, py::array_t<double>>;

LightPlaneResult lightPlane(const ArrayLike& R_gripper2base, const ArrayLike& t_gripper2base,
                            const ArrayLike& stripePoints, const ArrayLike& stripeViews, const ArrayLike& surfaceIds,
                            const ArrayLike& cameraMatrix, const OptionalArrayLike& distCoeffs,
                            const ArrayLike& R_cam2gripper, const OptionalArrayLike& knownPoints,
                            double orientationTolerance)
{
    const auto R = matrices(R_gripper2base, "R_gripper2base"), t = matrices(t_gripper2base, "t_gripper2base");
    const auto stripes = matrices(stripePoints, "stripePoints");
    const cv::Mat views = matrix(stripeViews, "stripeViews"), surfaces = matrix(surfaceIds, "surfaceIds");
    const cv::Mat K = matrix(cameraMatrix, "cameraMatrix"), D = optionalMatrix(distCoeffs, "distCoeffs");
    const cv::Mat X = matrix(R_cam2gripper, "R_cam2gripper"), known = optionalMatrix(knownPoints, "knownPoints");
    cv::Mat plane, cov;
    const double rms = unlocked(
        [&]
        {
            return calibrateLightPlane(R, t, stripes, views, surfaces, K, D, X, plane, cov, known,
                                       orientationTolerance);
        });
    return py::make_tuple(rms, array<double>(plane), array<double>(cov));
}

} // namespace

void bindLightPlane(py::module_& m)
{
    m.def("calibrateLightPlane", lightPlane, py::arg("R_gripper2base"), py::arg("t_gripper2base"),
          py::arg("stripePoints"), py::arg("stripeViews"), py::arg("surfaceIds"), py::arg("cameraMatrix"),
          py::arg("distCoeffs"), py::arg("R_cam2gripper"), py::kw_only(), py::arg("knownPoints") = py::none(),
          py::arg("orientationTolerance") = 0.05, lightPlaneDoc);
}

} // namespace active_handeye_python
