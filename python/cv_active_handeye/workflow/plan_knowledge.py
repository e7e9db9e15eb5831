# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What a plan takes for true, and what it predicts from it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

import cv_active_handeye as cah

from ..calibration import Calibration
from ..files import FloatArray
from ..plan_file import Prediction
from .plan_settings import PlanSettings
from .plan_views import Start, scene_of, surface_of
from .reporter import NO_CONVERGENCE

_ROTATION, _OFFSET = slice(10, 13), 19  # in the order of RefineSummary.parameterNames


@dataclass(frozen=True)
class Knowledge:
    """What is taken for true. camera_matrix (3, 3) px; distortion (5,) or None; T_cam2gripper (4, 4), m; points (N, 3),
    base frame, m; params: noise levels; light_plane (4,) and surfaces (S, 4), w.X = e, for stripes, or None."""

    image_size: tuple[int, int]
    camera_matrix: FloatArray
    distortion: FloatArray | None
    T_cam2gripper: FloatArray
    points: FloatArray
    params: cah.RefineParams
    light_plane: FloatArray | None = None
    surfaces: FloatArray | None = None

    @classmethod
    def assumed(cls, start: Start, settings: PlanSettings) -> Knowledge:
        """Before there is a calibration: the settings, and a scene within what the start sees."""
        light = settings.light_plane
        return cls(
            image_size=(settings.image_width, settings.image_height),
            camera_matrix=settings.camera_matrix,
            distortion=None,
            T_cam2gripper=settings.T_cam2gripper,
            points=scene_of(start, settings),
            params=settings.refine_params(),
            light_plane=light,
            surfaces=None if light is None else surface_of(start, settings),
        )

    @classmethod
    def learned(
        cls, calibration: Calibration, summary: cah.RefineSummary, start: Start, settings: PlanSettings
    ) -> Knowledge:
        """From a calibration so far, with the scene points that it found and its noise levels."""
        points = np.asarray(summary.scenePoints)
        params, light = settings.refine_params(), calibration.light_plane
        params.lensModel, params.pointSigma = summary.lensModel, summary.pointSigma
        params.robotTranslationSigma = summary.robotTranslationSigma
        params.robotRotationSigma = summary.robotRotationSigma
        if light is not None:
            params.stripeSigma = summary.stripeSigma
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = calibration.R_cam2gripper, calibration.t_cam2gripper
        return cls(
            image_size=(calibration.image_width, calibration.image_height),
            camera_matrix=calibration.camera_matrix,
            distortion=calibration.distortion_coefficients,
            T_cam2gripper=T,
            points=points[np.isfinite(points).all(axis=1)],
            params=params,
            light_plane=light,
            surfaces=None if light is None else surface_of(start, settings),
        )

    def arguments(self) -> tuple[FloatArray, tuple[int, int], FloatArray, FloatArray | None, FloatArray, FloatArray]:
        """Scene and camera in the order of `cah.predictHandEyeCovariance` and `cah.planHandEyeViews`."""
        T = self.T_cam2gripper
        return self.points, self.image_size, self.camera_matrix, self.distortion, T[:3, :3], T[:3, 3]


def predict(poses: Sequence[FloatArray], knowledge: Knowledge) -> Prediction:
    """Predicted standard deviations with stops at flange poses (4, 4), two or more."""
    known, stops = knowledge, np.asarray(poses)
    try:
        sigma, covariance, _, _ = cah.predictHandEyeCovariance(
            stops[:, :3, :3],
            stops[:, :3, 3],
            *known.arguments(),
            lightPlane=known.light_plane,
            surfaces=known.surfaces,
            params=known.params,
        )
    except cah.error as error:
        if error.code != NO_CONVERGENCE:
            raise
        return Prediction(stops=len(poses), t_cam2gripper_mm=None, R_cam2gripper_deg=None, fx_percent=None)
    variances = np.diag(covariance)
    return Prediction(
        stops=len(poses),
        t_cam2gripper_mm=_finite(1000 * sigma),
        R_cam2gripper_deg=_finite(np.degrees(np.sqrt(variances[_ROTATION].sum()))),
        fx_percent=_finite(100 * np.sqrt(variances[0]) / known.camera_matrix[0, 0]),
        light_plane_mm=None if known.light_plane is None else _finite(1000 * np.sqrt(variances[_OFFSET])),
    )


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
