# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Puts a refinement into the form of the result file."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import cv_active_handeye as cah

from ..calibration import Calibration
from ..calibration_format import (
    LENS_NAMES,
    ChiSquare,
    Lens,
    NoiseLevel,
    NoiseLevels,
    Rms,
    Tool,
    Verdict,
)
from ..config import CalibrationOptions
from ..dataset import Dataset
from ..report.verdict import tool_accuracy
from .evidence import ImagePoints, StripeSegment
from .refinement import Refined


def calibration_of(
    refined: Refined,
    dataset: Dataset,
    points: ImagePoints,
    segments: list[StripeSegment],
    options: CalibrationOptions,
) -> Calibration:
    """The calibration as it is saved."""
    summary = refined.summary
    seen = np.isfinite(points.points).all(axis=2)
    used = seen & (np.asarray(summary.rejectedObservations) == 0)
    return Calibration(
        software_version=cah.__version__,
        dataset_sha256=dataset.sha256(),
        constraints=options.constraints(),
        image_width=dataset.camera.width,
        image_height=dataset.camera.height,
        camera_matrix=refined.camera_matrix,
        distortion_coefficients=refined.distortion,
        R_cam2gripper=refined.R_cam2gripper,
        t_cam2gripper=refined.t_cam2gripper,
        light_plane=refined.light_plane,
        verdict=_verdict(summary, int((seen & ~used).sum())),
        tool=_tool(summary),
        noise_levels=_noise_levels(summary, points.stated_sigma),
        lens=_lens(summary, options),
        chi_square=_chi_square(summary, options),
        rms=Rms(points_px=summary.rms, stripes_px=_root_mean_square(summary.stripeResiduals)),
        views=len(dataset),
        points=int((seen.sum(axis=0) > 0).sum()),
        observations=int(used.sum()),
        stripe_segments=int(np.isfinite(summary.stripeResiduals).all(axis=1).sum()) if segments else 0,
        parameter_names=tuple(summary.parameterNames),
        covariance=summary.covariance,
        degrees_of_freedom=summary.degreesOfFreedom,
        intervals_95=summary.intervals95,
    )


def _verdict(summary: cah.RefineSummary, rejected: int) -> Verdict:
    return Verdict(
        usable=summary.usable,
        message=summary.message,
        stop_reason=summary.stopReason,
        rejected_views=tuple(summary.rejectedViews),
        rejected_observations=rejected,
        rejected_segments=tuple(summary.rejectedSegments),
        culprits=tuple(summary.culprits),
        weak_directions=tuple(summary.weakDirections),
    )


def _tool(summary: cah.RefineSummary) -> Tool:
    found = tool_accuracy(summary)
    return Tool(
        working_distance=summary.workingDistance,
        accuracy=found.worst / 1000 if found else math.inf,
        covariance=summary.toolCovariance,
    )


def _noise_levels(summary: cah.RefineSummary, stated: float | None) -> NoiseLevels:
    image_points, stripes, translation, rotation = (_noise_level(row) for row in summary.noiseLevels)
    assert image_points is not None
    exact = NoiseLevel(level=0, lower=0, upper=0, estimated=False)
    return NoiseLevels(
        image_points=image_points,
        stripes=stripes,
        robot_translation=translation or exact,
        robot_rotation=rotation or exact,
        stated_points_px=stated,
    )


def _noise_level(row: Any) -> NoiseLevel | None:
    """None for what was not in the data."""
    level, lower, upper, estimated = (float(x) for x in row)
    if not math.isfinite(level):
        return None
    if not estimated:
        lower = upper = level
    return NoiseLevel(level=level, lower=lower, upper=upper, estimated=bool(estimated))


def _lens(summary: cah.RefineSummary, options: CalibrationOptions) -> Lens:
    open_question = options.lens_model == "auto" and options.distortion_coefficients is None
    return Lens(
        model=LENS_NAMES[summary.lensModel],
        chosen=open_question and options.camera_matrix is None,
        tests=summary.lensTests,
    )


def _chi_square(summary: cah.RefineSummary, options: CalibrationOptions) -> ChiSquare | None:
    """Only of noise levels that the user gave: the tracker's standard deviations are relative ones."""
    if not options.robot_translation_mm and not options.robot_rotation_deg:
        return None
    return ChiSquare(value=summary.chiSquare, degrees_of_freedom=summary.chiSquareDof, p_value=summary.chiSquarePValue)


def _root_mean_square(residuals: Any) -> float | None:
    finite = np.asarray(residuals, np.float64)
    finite = finite[np.isfinite(finite)]
    return float(np.sqrt(np.mean(finite**2))) if finite.size else None
