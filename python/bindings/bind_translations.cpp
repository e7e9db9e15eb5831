// SPDX-FileCopyrightText: 2026 active_handeye contributors
// SPDX-License-Identifier: Apache-2.0

#include "bind.hpp"
#include "convert.hpp"

namespace active_handeye_python {

using namespace cv::active_handeye;

namespace {

const char* const translationsDoc = R"doc(Camera matrix and hand-eye rotation from pure translations of the gripper.

Between views of equal orientation, whose gripper moved by b_i, a fixed scene point is seen at x_ij ~ Z_j - P b_i
with P = K R_cam2gripper^T and one unknown vector Z_j for each point. TRANSLATIONS_METRIC solves this for P from all
groups at once; TRANSLATIONS_FOE uses the directions of the translations only (e_i ~ P b_i). P is split into K and R.
Needed: three translations that are not coplanar (FOE: four, no three coplanar; TRANSLATIONS_FIX_K: two that are not
parallel), spread over any groups.

Args:
    R_gripper2base: V rotations of the gripper in the robot's base frame, (3, 3) or rotation vectors.
    t_gripper2base: V translations of 3 numbers, any unit of length.
    imagePoints: V arrays (N, 2), pixels of the distorted image; row j is the same scene point in every view;
        NaN, NaN = not seen. Wrong matches are found by their residuals and left out.
    cameraMatrix: (3, 3): K for TRANSLATIONS_FIX_K; otherwise None, or a first guess for removing the distortion.
    distCoeffs: k1, k2, p1, p2[, k3] as in OpenCV, known beforehand; None = no distortion.
    method: TRANSLATIONS_METRIC or TRANSLATIONS_FOE.
    flags: sum of TRANSLATIONS_FIX_K, TRANSLATIONS_ZERO_SKEW, TRANSLATIONS_SQUARE_PIXELS.
    orientationTolerance: views whose orientations differ by less (degrees) form one group.

Returns:
    retval: RMS distance between image points and their predictions, pixels.
    cameraMatrix: (3, 3).
    R_cam2gripper: (3, 3) rotation from the camera frame to the gripper frame.
    covariance: (8, 8) of fx, fy, cx, cy, skew (pixels) and the rotation error vector in the gripper frame (rad); rows
        of fixed parameters are zero. Covers image noise and, where the residuals show it, jitter of the reported
        orientations, both estimated; not other errors of the robot.

Raises:
    error: wrong input (StsBadArg, StsBadSize, StsOutOfRange); StsNoConv when the data cannot answer; the text says
        what is missing, directions in base coordinates.

Source: doc/method/translations.md; the paper's equations (14) to (18).
)doc";

const char* const groupsDoc = R"doc(Groups of views between which the gripper only translated.

Args:
    R_gripper2base: V rotations, (3, 3) or rotation vectors.
    orientationTolerance: a view joins the first group whose first view's orientation differs by less, degrees.

Returns:
    groupIds: (V, 1) int32; groups are numbered from 0 in the order of their first views.

Raises:
    error: wrong input.

Source: doc/method/translations.md.
)doc";

using TranslationsResult = py::typing::Tuple<double, py::array_t<double>, py::array_t<double>, py::array_t<double>>;

TranslationsResult translations(const ArrayLike& R_gripper2base, const ArrayLike& t_gripper2base,
                                const ArrayLike& imagePoints, const OptionalArrayLike& cameraMatrix,
                                const OptionalArrayLike& distCoeffs, int method, int flags, double orientationTolerance)
{
    const auto R = matrices(R_gripper2base, "R_gripper2base"), t = matrices(t_gripper2base, "t_gripper2base");
    const auto points = matrices(imagePoints, "imagePoints");
    const cv::Mat D = optionalMatrix(distCoeffs, "distCoeffs");
    cv::Mat K = optionalMatrix(cameraMatrix, "cameraMatrix"), X, cov;
    const double rms = unlocked(
        [&]
        {
            return calibrateHandEyeTranslations(R, t, points, K, D, X, cov, TranslationsMethod(method), flags,
                                                orientationTolerance);
        });
    return py::make_tuple(rms, array<double>(K), array<double>(X), array<double>(cov));
}

py::array_t<int> groups(const ArrayLike& R_gripper2base, double orientationTolerance)
{
    const auto R = matrices(R_gripper2base, "R_gripper2base");
    cv::Mat ids;
    unlocked([&] { groupViews(R, ids, orientationTolerance); });
    return array<int>(ids);
}

} // namespace

void bindTranslations(py::module_& m)
{
    m.attr("TRANSLATIONS_METRIC") = int(TRANSLATIONS_METRIC);
    m.attr("TRANSLATIONS_FOE") = int(TRANSLATIONS_FOE);
    m.attr("TRANSLATIONS_FIX_K") = int(TRANSLATIONS_FIX_K);
    m.attr("TRANSLATIONS_ZERO_SKEW") = int(TRANSLATIONS_ZERO_SKEW);
    m.attr("TRANSLATIONS_SQUARE_PIXELS") = int(TRANSLATIONS_SQUARE_PIXELS);
    m.def("calibrateHandEyeTranslations", translations, py::arg("R_gripper2base"), py::arg("t_gripper2base"),
          py::arg("imagePoints"), py::arg("cameraMatrix"), py::arg("distCoeffs"), py::kw_only(),
          py::arg("method") = int(TRANSLATIONS_METRIC), py::arg("flags") = 0, py::arg("orientationTolerance") = 0.05,
          translationsDoc);
    m.def("groupViews", groups, py::arg("R_gripper2base"), py::kw_only(), py::arg("orientationTolerance") = 0.05,
          groupsDoc);
}

} // namespace active_handeye_python
