// SPDX-FileCopyrightText: 2026 active_handeye contributors
// SPDX-License-Identifier: Apache-2.0

#include "bind.hpp"
#include "convert.hpp"

namespace active_handeye_python {

using namespace cv::active_handeye;

namespace {

const char* const locateDoc = R"doc(Characteristic points on a stripe: where its straight pieces pass the given pixels.

A line through the columns of one piece around the point is several times better than a single column. Its variance is
that of the weighted fit, raised by the scatter of these columns about the line and by the correlation of neighbours
along the whole stripe, and never below (0.02 px)^2.

Args:
    stripePoints: (N, 2) pixels of the distorted image, in order along the stripe, as from detectStripe.
    sigmas: N standard deviations across the stripe, pixels, as from detectStripe.
    segmentIds: N numbers of the straight pieces, -1 = on none, as from splitStripe.
    pixels: (M, 2) pixels near the stripe. The coordinate along the stripe (u for STRIPE_HORIZONTAL, v for
        STRIPE_VERTICAL) says where the point is, the other one only which piece is meant: the nearest.
    cameraMatrix: (3, 3).
    distCoeffs: k1, k2, p1, p2[, k3] as in OpenCV; None = no distortion.
    sigmaAlong: standard deviation of the coordinate along the stripe in pixels, px; 0 = exact.
    orientation: STRIPE_HORIZONTAL or STRIPE_VERTICAL.
    halfWindow: columns of the piece on either side of the point that count; at least 8 must be there.
    maxDistance: between pixel and stripe, across it, px. A point may lie 3 px beyond the end of its piece.

Returns:
    points: (M, 2) pixels on the stripe; NaN where no piece comes within maxDistance.
    covariances: (M, 2, 2) px^2; NaN as well.

Raises:
    error: wrong input.

Source: doc/method/profile.md.
)doc";

const char* const cornersDoc =
    R"doc(Corners of a profile: where two neighbouring straight pieces of a stripe meet in the light plane.

Roots of grooves, edges of plates. Both pieces are continued as lines, so that a rounded or open root does not matter.

Args:
    stripePoints: (N, 2) pixels of the distorted image, in order along the stripe, as from detectStripe.
    sigmas: N standard deviations across the stripe, pixels, as from detectStripe.
    segmentIds: N numbers of the straight pieces, as from splitStripe; short faces need a small minPoints there.
    cameraMatrix: (3, 3).
    distCoeffs: k1, k2, p1, p2[, k3] as in OpenCV; None = no distortion.
    lightPlane: nx, ny, nz, d in the camera frame, n.X = d, |n| = 1, d > 0.
    orientation: STRIPE_HORIZONTAL or STRIPE_VERTICAL.
    halfWindow: the 2 halfWindow + 1 columns of a piece nearest to the corner count.
    maxGap: the corner is this near to the ends of both pieces at most, px.

Returns:
    corners: (K, 2) pixels of the distorted image, in order along the stripe.
    covariances: (K, 2, 2) px^2.
    openingAngles: (K, 1) degrees, measured in the light plane on the camera's side: < 180 a groove, > 180 a ridge.
    segments: (K, 2) int32, the pieces that meet.

Raises:
    error: wrong input.

Source: doc/method/profile.md.
)doc";

using LocateResult = py::typing::Tuple<py::array_t<double>, py::array_t<double>>;
using CornersResult =
    py::typing::Tuple<py::array_t<double>, py::array_t<double>, py::array_t<double>, py::array_t<int>>;

LocateResult locate(const ArrayLike& stripePoints, const ArrayLike& sigmas, const ArrayLike& segmentIds,
                    const ArrayLike& pixels, const ArrayLike& cameraMatrix, const OptionalArrayLike& distCoeffs,
                    double sigmaAlong, int orientation, double halfWindow, double maxDistance)
{
    const cv::Mat stripe = matrix(stripePoints, "stripePoints"), sd = matrix(sigmas, "sigmas");
    const cv::Mat ids = matrix(segmentIds, "segmentIds"), wanted = matrix(pixels, "pixels");
    const cv::Mat K = matrix(cameraMatrix, "cameraMatrix"), D = optionalMatrix(distCoeffs, "distCoeffs");
    cv::Mat points, covariances;
    unlocked(
        [&]
        {
            locateOnStripe(stripe, sd, ids, wanted, K, D, points, covariances, sigmaAlong, orientation, halfWindow,
                           maxDistance);
        });
    return py::make_tuple(array<double>(points), matrixArray(covariances));
}

CornersResult findCorners(const ArrayLike& stripePoints, const ArrayLike& sigmas, const ArrayLike& segmentIds,
                          const ArrayLike& cameraMatrix, const OptionalArrayLike& distCoeffs,
                          const ArrayLike& lightPlane, int orientation, double halfWindow, double maxGap)
{
    const cv::Mat stripe = matrix(stripePoints, "stripePoints"), sd = matrix(sigmas, "sigmas");
    const cv::Mat ids = matrix(segmentIds, "segmentIds"), K = matrix(cameraMatrix, "cameraMatrix");
    const cv::Mat D = optionalMatrix(distCoeffs, "distCoeffs"), light = matrix(lightPlane, "lightPlane");
    cv::Mat corners, covariances, angles, segments;
    unlocked(
        [&]
        {
            findProfileCorners(stripe, sd, ids, K, D, light, corners, covariances, angles, segments, orientation,
                               halfWindow, maxGap);
        });
    return py::make_tuple(array<double>(corners), matrixArray(covariances), array<double>(angles),
                          array<int>(segments));
}

} // namespace

void bindProfile(py::module_& m)
{
    m.def("locateOnStripe", locate, py::arg("stripePoints"), py::arg("sigmas"), py::arg("segmentIds"),
          py::arg("pixels"), py::arg("cameraMatrix"), py::arg("distCoeffs"), py::kw_only(), py::arg("sigmaAlong") = 0.0,
          py::arg("orientation") = int(STRIPE_HORIZONTAL), py::arg("halfWindow") = 15.0, py::arg("maxDistance") = 10.0,
          locateDoc);
    m.def("findProfileCorners", findCorners, py::arg("stripePoints"), py::arg("sigmas"), py::arg("segmentIds"),
          py::arg("cameraMatrix"), py::arg("distCoeffs"), py::arg("lightPlane"), py::kw_only(),
          py::arg("orientation") = int(STRIPE_HORIZONTAL), py::arg("halfWindow") = 15.0, py::arg("maxGap") = 12.0,
          cornersDoc);
}

} // namespace active_handeye_python
