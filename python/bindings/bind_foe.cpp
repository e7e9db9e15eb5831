// SPDX-FileCopyrightText: 2026 active_handeye contributors
// SPDX-License-Identifier: Apache-2.0

#include "bind.hpp"
#include "convert.hpp"

namespace active_handeye_python {

using namespace cv::active_handeye;

namespace {

const char* const foeDoc = R"doc(Focus of expansion (FOE) of one pure translation of the camera.

When the camera moves by c without turning, every fixed point's image moves along a line through e ~ K c.
Two matches are the minimum; the sum of squared orthogonal distances of both points of each match to their
common line through e is minimised.

Args:
    points1: (N, 2) or (N, 1, 2) pixels of the first view, without lens distortion.
    points2: pixels of the same scene points in the second view, row by row.
    method: FOE_LEAST_SQUARES (all matches are right) or FOE_RANSAC (some are wrong).
    threshold: FOE_RANSAC: largest orthogonal distance of an inlier, pixels; with ten inliers or more five times their
        noise counts, when that is less.
    confidence: FOE_RANSAC: probability that a sample without wrong matches was drawn.

Returns:
    retval: number of inliers.
    foe: (3, 1) homogeneous pixel of norm 1; K^-1 foe is the direction in which the camera moved (at infinity,
        third number 0, for a motion parallel to the image plane).
    inlierMask: (N, 1) uint8, 1 where the match agrees with foe (FOE_LEAST_SQUARES: all 1).
    covariance: (3, 3) covariance of foe on the unit sphere, of rank 2. The noise is estimated from the
        residuals; two matches leave none, and 1 px per axis is assumed.

Raises:
    error: wrong input (StsBadArg, StsBadSize, StsOutOfRange); StsNoConv when the matches cannot answer: fewer
        than two, no parallax, or all displacements on one line.

Source: doc/method/foe.md; the paper's equation (3).
)doc";

using FoeResult = py::typing::Tuple<int, py::array_t<double>, py::array_t<uchar>, py::array_t<double>>;

FoeResult foe(const ArrayLike& points1, const ArrayLike& points2, int method, double threshold, double confidence)
{
    const cv::Mat x1 = matrix(points1, "points1"), x2 = matrix(points2, "points2");
    cv::Mat e, mask, cov;
    const int inliers =
        unlocked([&] { return estimateFOE(x1, x2, e, mask, cov, FOEMethod(method), threshold, confidence); });
    return py::make_tuple(inliers, array<double>(e), array<uchar>(mask), array<double>(cov));
}

} // namespace

void bindFoe(py::module_& m)
{
    m.attr("FOE_LEAST_SQUARES") = int(FOE_LEAST_SQUARES);
    m.attr("FOE_RANSAC") = int(FOE_RANSAC);
    m.def("estimateFOE", foe, py::arg("points1"), py::arg("points2"), py::kw_only(),
          py::arg("method") = int(FOE_RANSAC), py::arg("threshold") = 1.0, py::arg("confidence") = 0.999, foeDoc);
}

} // namespace active_handeye_python
