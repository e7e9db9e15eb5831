# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Calls `cah.refineHandEye` with what a data set shows and what the options say."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import cv_active_handeye as cah

from ..calibration_format import LENS_NAMES
from ..config import CalibrationOptions
from ..dataset import Dataset
from ..files import FloatArray
from .evidence import ImagePoints, StripeSegment


class Start(NamedTuple):
    """Where a refinement begins; the closed forms give what is None. Distortion has no start other than 0: the lens
    tests ask whether it differs from its start."""

    camera_matrix: FloatArray | None = None
    R_cam2gripper: FloatArray | None = None
    t_cam2gripper: FloatArray | None = None


class Refined(NamedTuple):
    """What `cah.refineHandEye` returns; light_plane is None without stripes."""

    camera_matrix: FloatArray
    distortion: FloatArray
    R_cam2gripper: FloatArray
    t_cam2gripper: FloatArray
    light_plane: FloatArray | None
    summary: cah.RefineSummary


def refine(
    dataset: Dataset,
    points: ImagePoints,
    options: CalibrationOptions,
    start: Start,
    segments: Sequence[StripeSegment] = (),
) -> Refined:
    """The joint refinement of image points and, where there are `segments`, of stripes."""
    _, matrix, distortion, R_cam2gripper, t_cam2gripper, plane, summary = cah.refineHandEye(
        dataset.R_gripper2base,
        dataset.t_gripper2base,
        points.points,
        start.camera_matrix if options.camera_matrix is None else options.camera_matrix,
        options.distortion_coefficients,
        start.R_cam2gripper,
        start.t_cam2gripper,
        None,
        stripePoints=[segment.points for segment in segments] or None,
        stripeViews=[segment.view for segment in segments] or None,
        surfaceIds=[segment.surface for segment in segments] or None,
        objectPoints=points.object_points,
        pointSigmas=points.relative_sigmas,
        params=_params(options),
    )
    return Refined(matrix, distortion, R_cam2gripper, t_cam2gripper, plane, summary)


def _params(options: CalibrationOptions) -> cah.RefineParams:
    params = cah.RefineParams()
    known = options.camera_matrix is not None
    params.flags = int(cah.REFINE_FIX_K) * known
    params.flags |= int(cah.REFINE_SKEW) * (not known and not options.zero_skew)
    params.flags |= int(cah.REFINE_FIX_ASPECT) * (not known and options.square_pixels)
    params.flags |= int(cah.REFINE_ALLOW_PARTIAL) * options.allow_partial
    params.lensModel = _lens_model(options)
    if options.robot_translation_mm is not None:
        params.robotTranslationSigma = options.robot_translation_mm / 1000
    if options.robot_rotation_deg is not None:
        params.robotRotationSigma = math.radians(options.robot_rotation_deg)
    params.orientationTolerance = options.orientation_tolerance_deg
    return params


def _lens_model(options: CalibrationOptions) -> int:
    if options.distortion_coefficients is not None:
        return int(cah.LENS_FIXED)
    return int(cah.LENS_AUTO) if options.lens_model == "auto" else LENS_NAMES.index(options.lens_model)
