# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Target-free calibration of a robot's camera and line laser from active motion.

The functions here are those of the C++ module ``cv::active_handeye``, under the same names, and need numpy only:

    >>> import cv_active_handeye as cah
    >>> retval, foe, inlierMask, covariance = cah.estimateFOE(points1, points2)

Everything after the inputs is given by keyword. Results are new arrays; vectors have shape (n, 1), as in cv2. Frames
are named as in ``cv2.calibrateHandEye``: ``R_a2b``, ``t_a2b`` map a point of frame a into frame b. Lengths may have any
unit; the results have the same one.

Data sets, tracking, the simulated cell and the workflow live in the subpackages and need the extras ``workflow`` and
``sim``.
"""

from ._core import (
    FOE_LEAST_SQUARES,
    FOE_RANSAC,
    LENS_AUTO,
    LENS_FIXED,
    LENS_K1,
    LENS_K1_K2,
    LENS_K3,
    LENS_TANGENTIAL,
    REFINE_ALLOW_PARTIAL,
    REFINE_FIX_ASPECT,
    REFINE_FIX_K,
    REFINE_FIX_LIGHT_PLANE,
    REFINE_FIX_ROTATION,
    REFINE_FIX_TRANSLATION,
    REFINE_SKEW,
    ROTATION_ALLOW_PARTIAL,
    STRIPE_HORIZONTAL,
    STRIPE_VERTICAL,
    TRANSLATIONS_FIX_K,
    TRANSLATIONS_FOE,
    TRANSLATIONS_METRIC,
    TRANSLATIONS_SQUARE_PIXELS,
    TRANSLATIONS_ZERO_SKEW,
    PlanParams,
    RefineParams,
    RefineSummary,
    StripeParams,
    VerifyParams,
    VerifySummary,
    associateStripes,
    calibrateHandEyeRotation,
    calibrateHandEyeTranslations,
    calibrateLightPlane,
    detectStripe,
    error,
    estimateFOE,
    findProfileCorners,
    groupViews,
    locateOnStripe,
    measureStripePoints,
    planHandEyeViews,
    predictHandEyeCovariance,
    refineHandEye,
    reprojectStripe,
    splitStripe,
    verifyHandEye,
)
from ._core import version as __version__

__all__ = [
    "FOE_LEAST_SQUARES",
    "FOE_RANSAC",
    "LENS_AUTO",
    "LENS_FIXED",
    "LENS_K1",
    "LENS_K1_K2",
    "LENS_K3",
    "LENS_TANGENTIAL",
    "REFINE_ALLOW_PARTIAL",
    "REFINE_FIX_ASPECT",
    "REFINE_FIX_K",
    "REFINE_FIX_LIGHT_PLANE",
    "REFINE_FIX_ROTATION",
    "REFINE_FIX_TRANSLATION",
    "REFINE_SKEW",
    "ROTATION_ALLOW_PARTIAL",
    "STRIPE_HORIZONTAL",
    "STRIPE_VERTICAL",
    "TRANSLATIONS_FIX_K",
    "TRANSLATIONS_FOE",
    "TRANSLATIONS_METRIC",
    "TRANSLATIONS_SQUARE_PIXELS",
    "TRANSLATIONS_ZERO_SKEW",
    "PlanParams",
    "RefineParams",
    "RefineSummary",
    "StripeParams",
    "VerifyParams",
    "VerifySummary",
    "__version__",
    "associateStripes",
    "calibrateHandEyeRotation",
    "calibrateHandEyeTranslations",
    "calibrateLightPlane",
    "detectStripe",
    "error",
    "estimateFOE",
    "findProfileCorners",
    "groupViews",
    "locateOnStripe",
    "measureStripePoints",
    "planHandEyeViews",
    "predictHandEyeCovariance",
    "refineHandEye",
    "reprojectStripe",
    "splitStripe",
    "verifyHandEye",
]
