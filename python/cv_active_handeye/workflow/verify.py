# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Asks a few new views whether a calibration is still valid: open, points, prediction and test."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

import cv_active_handeye as cah

from ..calibration import Calibration
from ..calibration_format import NoiseLevels
from ..config import CalibrationOptions
from ..dataset import Dataset
from .calibrated import noise_levels_for
from .evidence import ImagePoints, find_points, open_recording
from .reporter import InsufficientDataError, Reporter, Silent

MIN_VIEWS = 3


@dataclass(frozen=True)
class ViewError:
    """How far a view is from where the other views and the calibration put it, and how far it may be (RMS)."""

    view: int
    error_px: float
    expected_px: float
    error_mm: float
    expected_mm: float
    contradicts: bool


@dataclass(frozen=True)
class Verification:
    """The answer, one row a view, and the RMS error of all predicted points in pixels."""

    summary: cah.VerifySummary
    views: tuple[ViewError, ...]
    rms_px: float

    @property
    def valid(self) -> bool:
        """Whether the new views agree with the calibration."""
        return self.summary.valid


def verify(
    dataset: Dataset | str | Path,
    calibration: Calibration,
    options: CalibrationOptions | None = None,
    reporter: Reporter | None = None,
) -> Verification:
    """Predicts every view from the others and `calibration`, and compares with what image and robot noise allow.

    Of `options` only how points are found is used. Raises `InsufficientDataError` or `cah.error` when the views cannot
    answer, `FileFormatError` when data set and calibration do not belong together.
    """
    options, reporter = options or CalibrationOptions(), reporter or Silent()
    dataset = open_recording(dataset, reporter)
    levels = noise_levels_for(dataset, calibration, reporter)
    if len(dataset) < MIN_VIEWS:
        raise InsufficientDataError(f"{dataset.folder}: needs {MIN_VIEWS} views, has {len(dataset)}")
    points = find_points(dataset, options, reporter)
    progress = reporter.step(f"predicting {len(dataset)} views from each other")
    rms, summary = cah.verifyHandEye(
        dataset.R_gripper2base,
        dataset.t_gripper2base,
        points.points,
        calibration.camera_matrix,
        calibration.distortion_coefficients,
        calibration.R_cam2gripper,
        calibration.t_cam2gripper,
        calibration.covariance,
        pointSigmas=points.relative_sigmas,
        params=_params(levels, points),
    )
    progress(1, 1)
    return Verification(summary, _view_errors(summary), rms)


def _params(levels: NoiseLevels, points: ImagePoints) -> cah.VerifyParams:
    """A new recording may be brighter or darker: the tracker's statements about the two recordings say by how much."""
    params = cah.VerifyParams()
    params.pointSigma = levels.image_points.level
    if levels.stated_points_px is not None and points.stated_sigma is not None:
        params.pointSigma *= points.stated_sigma / levels.stated_points_px
    params.robotTranslationSigma = levels.robot_translation.level
    params.robotRotationSigma = levels.robot_rotation.level
    return params


def _view_errors(summary: cah.VerifySummary) -> tuple[ViewError, ...]:
    contradicting = set(summary.contradictingViews)
    rows = np.asarray(summary.viewErrors, np.float64) * [1, 1, 1000, 1000]
    return tuple(
        ViewError(view, error_px, expected_px, error_mm, expected_mm, view in contradicting)
        for view, (error_px, expected_px, error_mm, expected_mm) in enumerate(rows.tolist())
    )
