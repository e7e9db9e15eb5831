// SPDX-FileCopyrightText: 2026 active_handeye contributors
// SPDX-License-Identifier: Apache-2.0

#include "bind.hpp"
#include "convert.hpp"

#include <tuple>

namespace active_handeye_python {

using namespace cv::active_handeye;

namespace {

const char* const detectDoc = R"doc(Centre line of a laser stripe, one sub-pixel point per column (or row).

Args:
    image: (rows, columns) or (rows, columns, 3), uint8 or uint16; colours are averaged.
    background: the same view with the laser off, same shape and type; None = not given. It removes the error that
        edges of the texture under the stripe cause.
    params: what the stripe looks like.

Returns:
    stripePoints: (N, 2) pixels of the distorted image, ordered by column (STRIPE_VERTICAL: row); the centre of a
        pixel has integer coordinates. N = 0 when there is no stripe, which is not an error.
    sigmas: (N, 1) standard deviations across the stripe, pixels.

Raises:
    error: an empty image, an unsupported type, a background of another shape or type, parameters out of range, a roi
        that is not inside the image.

Source: doc/method/stripe.md.
)doc";

const char* const splitDoc = R"doc(Straight segments of a stripe, one per plane it crosses.

Args:
    stripePoints: (N, 2) pixels of the distorted image, in order along the stripe, as from detectStripe.
    sigmas: N standard deviations, pixels; None = all alike.
    cameraMatrix: (3, 3).
    distCoeffs: k1, k2, p1, p2[, k3] as in OpenCV; None = no distortion.
    breakDistance: a step of this size across the stripe, or a bend that departs as far, starts a new segment, pixels.
    maxGap: neighbouring points farther apart along the stripe belong to different segments, pixels.
    minPoints: shorter segments are left out.

Returns:
    segmentIds: (N, 1) int32: 0, 1, ... in order along the stripe; -1 = on no straight segment.

Raises:
    error: wrong input.

Source: doc/method/stripe.md.
)doc";

const char* const associateDoc =
    R"doc(Which stripe segments of different views lie on the same fixed plane of the scene.

The tracked points are triangulated; where a stripe passes near them they give a rough light plane, and with it the
segments become lines in the base frame, which are gathered on planes that the tracked points beside them do not
contradict: inside a group of equal orientation first, then across groups. Where two views alone share a plane, the
points have to confirm it. The tolerance shrinks to what the planes found show to be needed.

Args:
    R_gripper2base: V rotations of the gripper in the robot's base frame, (3, 3) or rotation vectors.
    t_gripper2base: V translations of 3 numbers, any unit of length.
    stripePoints: S straight stripe segments, each (M, 2), pixels of the distorted image; see splitStripe.
    stripeViews: S integers, the view (0 .. V-1) in which each segment was seen.
    imagePoints: V arrays (N, 2), pixels of the distorted image; row j is the same scene point in every view;
        NaN, NaN = not seen.
    cameraMatrix: (3, 3).
    distCoeffs: k1, k2, p1, p2[, k3] as in OpenCV; None = no distortion.
    R_cam2gripper: rotation of the camera in the gripper frame, (3, 3) or rotation vector.
    t_cam2gripper: position of the camera in the gripper frame, 3 numbers.
    tolerance: a segment lies on a surface when its points are at most this far from the predicted stripe, pixels.
    searchRadius: tracked points this near to a stripe give its depth, pixels.

Returns:
    surfaceIds: (S, 1) int32: 0, 1, ... (the surface of most stripes first); -1 = not sure.
    lightPlane: (4, 1) the rough light plane that was used: nx, ny, nz, d in the camera frame, n.X = d.

Raises:
    error: wrong input; StsNoConv when fewer than 30 stripe points have a tracked point near them, or no plane
        agrees with a third of these.

Source: doc/method/light_plane.md.
)doc";

const char* const stripeParamsDoc = R"doc(What a stripe looks like, for detectStripe.

Attributes:
    orientation: STRIPE_HORIZONTAL (one point per column, the default) or STRIPE_VERTICAL (one per row).
    sigma: expected standard deviation of the cross profile, 0.5 to 20 px; half to twice this is found; default 1.5.
    minSnr: least height of a peak of the smoothed profile, in units of its noise; default 4.5.
    minContrast: least height as a fraction of the saturation level; default 0.02.
    maxSecondPeak: a column is left out when its second peak is higher than this fraction of the first; default 0.6.
    saturation: grey level from which a pixel is saturated; 0 (default) = the largest value of the image's type.
    minRun: shorter runs of neighbouring points are left out; default 5.
    roi: (x, y, width, height), the part of the image to search; (0, 0, 0, 0) (the default) = the whole image. Points
        are pixels of the whole image all the same.
)doc";

using DetectResult = py::typing::Tuple<py::array_t<double>, py::array_t<double>>;
using AssociateResult = py::typing::Tuple<py::array_t<int>, py::array_t<double>>;

DetectResult detect(const ArrayLike& frame, const OptionalArrayLike& background, const StripeParams& params)
{
    const Image on = image(frame, "image"), off = image(background, "background");
    cv::Mat points, sigmas;
    unlocked([&] { detectStripe(on.pixels, points, sigmas, off.pixels, params); });
    return py::make_tuple(array<double>(points), array<double>(sigmas));
}

py::array_t<int> split(const ArrayLike& stripePoints, const OptionalArrayLike& sigmas, const ArrayLike& cameraMatrix,
                       const OptionalArrayLike& distCoeffs, double breakDistance, double maxGap, int minPoints)
{
    const cv::Mat points = matrix(stripePoints, "stripePoints"), sd = optionalMatrix(sigmas, "sigmas");
    const cv::Mat K = matrix(cameraMatrix, "cameraMatrix"), D = optionalMatrix(distCoeffs, "distCoeffs");
    cv::Mat ids;
    unlocked([&] { splitStripe(points, sd, K, D, ids, breakDistance, maxGap, minPoints); });
    return array<int>(ids);
}

AssociateResult associate(const ArrayLike& R_gripper2base, const ArrayLike& t_gripper2base,
                          const ArrayLike& stripePoints, const ArrayLike& stripeViews, const ArrayLike& imagePoints,
                          const ArrayLike& cameraMatrix, const OptionalArrayLike& distCoeffs,
                          const ArrayLike& R_cam2gripper, const ArrayLike& t_cam2gripper, double tolerance,
                          double searchRadius)
{
    const auto R = matrices(R_gripper2base, "R_gripper2base"), t = matrices(t_gripper2base, "t_gripper2base");
    const auto stripes = matrices(stripePoints, "stripePoints"), points = matrices(imagePoints, "imagePoints");
    const cv::Mat views = matrix(stripeViews, "stripeViews"), K = matrix(cameraMatrix, "cameraMatrix");
    const cv::Mat D = optionalMatrix(distCoeffs, "distCoeffs"), Rx = matrix(R_cam2gripper, "R_cam2gripper");
    const cv::Mat tx = matrix(t_cam2gripper, "t_cam2gripper");
    cv::Mat ids, plane;
    unlocked([&]
             { associateStripes(R, t, stripes, views, points, K, D, Rx, tx, ids, plane, tolerance, searchRadius); });
    return py::make_tuple(array<int>(ids), array<double>(plane));
}

using Roi = std::tuple<int, int, int, int>;

Roi roiOf(const StripeParams& params)
{
    return Roi(params.roi.x, params.roi.y, params.roi.width, params.roi.height);
}

void setRoi(StripeParams& params, const Roi& roi)
{
    params.roi = cv::Rect(std::get<0>(roi), std::get<1>(roi), std::get<2>(roi), std::get<3>(roi));
}

void bindStripeParams(py::module_& m)
{
    m.attr("STRIPE_HORIZONTAL") = int(STRIPE_HORIZONTAL);
    m.attr("STRIPE_VERTICAL") = int(STRIPE_VERTICAL);
    py::class_<StripeParams>(m, "StripeParams", stripeParamsDoc)
        .def(py::init<>())
        .def_readwrite("orientation", &StripeParams::orientation)
        .def_readwrite("sigma", &StripeParams::sigma)
        .def_readwrite("minSnr", &StripeParams::minSnr)
        .def_readwrite("minContrast", &StripeParams::minContrast)
        .def_readwrite("maxSecondPeak", &StripeParams::maxSecondPeak)
        .def_readwrite("saturation", &StripeParams::saturation)
        .def_readwrite("minRun", &StripeParams::minRun)
        .def_property("roi", roiOf, setRoi);
}

} // namespace

void bindStripe(py::module_& m)
{
    bindStripeParams(m);
    m.def("detectStripe", detect, py::arg("image"), py::kw_only(), py::arg("background") = py::none(),
          py::arg_v("params", StripeParams(), "StripeParams()"), detectDoc);
    m.def("splitStripe", split, py::arg("stripePoints"), py::arg("sigmas"), py::arg("cameraMatrix"),
          py::arg("distCoeffs"), py::kw_only(), py::arg("breakDistance") = 0.6, py::arg("maxGap") = 6.0,
          py::arg("minPoints") = 20, splitDoc);
    m.def("associateStripes", associate, py::arg("R_gripper2base"), py::arg("t_gripper2base"), py::arg("stripePoints"),
          py::arg("stripeViews"), py::arg("imagePoints"), py::arg("cameraMatrix"), py::arg("distCoeffs"),
          py::arg("R_cam2gripper"), py::arg("t_cam2gripper"), py::kw_only(), py::arg("tolerance") = 1.5,
          py::arg("searchRadius") = 12.0, associateDoc);
}

} // namespace active_handeye_python
