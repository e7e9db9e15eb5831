# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""How far a calibration is from the truth of a simulated cell."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import cv2
import numpy as np

from ..calibration import Calibration
from ..files import FloatArray


class TrueValues(Protocol):
    """What is compared; `simulation.Truth` has it."""

    # The names say it all; their shapes stand in simulation.Truth.
    @property
    def camera_matrix(self) -> FloatArray: ...  # noqa: D102
    @property
    def R_cam2gripper(self) -> FloatArray: ...  # noqa: D102
    @property
    def t_cam2gripper(self) -> FloatArray: ...  # noqa: D102
    @property
    def light_plane(self) -> FloatArray | None: ...  # noqa: D102


@dataclass(frozen=True)
class CalibrationErrors:
    """Sizes of estimate minus truth: per cent of the focal length, px, degrees, mm. None = no light plane."""

    fx_percent: float
    fy_percent: float
    cx_px: float
    cy_px: float
    rotation_deg: float
    translation_mm: float
    plane_normal_deg: float | None
    plane_offset_mm: float | None


def calibration_errors(estimate: Calibration, truth: TrueValues) -> CalibrationErrors:
    """Compares in the units people measure in; angles are those of the rotation between estimate and truth."""
    K, K0 = estimate.camera_matrix, truth.camera_matrix
    normal, offset = None, None
    if estimate.light_plane is not None and truth.light_plane is not None:
        normal = angle_between_deg(estimate.light_plane[:3], truth.light_plane[:3])
        offset = 1000 * abs(float(estimate.light_plane[3] - truth.light_plane[3]))
    return CalibrationErrors(
        fx_percent=100 * abs(float(K[0, 0] / K0[0, 0] - 1)),
        fy_percent=100 * abs(float(K[1, 1] / K0[1, 1] - 1)),
        cx_px=abs(float(K[0, 2] - K0[0, 2])),
        cy_px=abs(float(K[1, 2] - K0[1, 2])),
        rotation_deg=rotation_angle_deg(truth.R_cam2gripper.T @ estimate.R_cam2gripper),
        translation_mm=1000 * float(np.linalg.norm(estimate.t_cam2gripper - truth.t_cam2gripper)),
        plane_normal_deg=normal,
        plane_offset_mm=offset,
    )


def rotation_vector_deg(R: FloatArray) -> FloatArray:
    """Rotation vector (3,) of `R` in degrees."""
    return np.degrees(cv2.Rodrigues(np.asarray(R, np.float64))[0]).reshape(3).astype(np.float64)


def rotation_angle_deg(R: FloatArray) -> float:
    """Angle of the rotation `R` in degrees."""
    return float(np.linalg.norm(rotation_vector_deg(R)))


def angle_between_deg(a: FloatArray, b: FloatArray) -> float:
    """Angle between two vectors in degrees, exact also when it is tiny."""
    return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b)), np.dot(a, b))))
