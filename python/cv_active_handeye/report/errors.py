# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""How far a calibration is from the truth of a simulated cell, and whether its intervals hold it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import cv2
import numpy as np

from ..calibration import PARAMETERS, Calibration
from ..files import FloatArray


class TrueValues(Protocol):
    """What is compared; `simulation.Truth` has it."""

    @property
    def camera_matrix(self) -> FloatArray:
        """3 x 3, px."""

    @property
    def distortion_coefficients(self) -> FloatArray:
        """k1, k2, p1, p2, k3."""

    @property
    def R_cam2gripper(self) -> FloatArray:
        """3 x 3."""

    @property
    def t_cam2gripper(self) -> FloatArray:
        """3, metres."""

    @property
    def light_plane(self) -> FloatArray | None:
        """Normal and distance in the camera's frame: 4, metres. None = no laser."""


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


def true_parameters(estimate: Calibration, truth: TrueValues) -> dict[str, float]:
    """The truth in the terms of `Calibration.intervals_95`: rx, ry, rz is what turns the estimate into the truth.

    Pixels, rad, metres; the light plane only where both have one.
    """
    K, D = truth.camera_matrix, np.append(truth.distortion_coefficients, np.zeros(5))[:5]
    turn = np.radians(rotation_vector_deg(truth.R_cam2gripper @ estimate.R_cam2gripper.T))
    values = [K[0, 0], K[1, 1], K[0, 2], K[1, 2], K[0, 1], *D, *turn, *truth.t_cam2gripper]
    if estimate.light_plane is not None and truth.light_plane is not None:
        values += truth.light_plane.tolist()
    return {name: float(value) for name, value in zip(PARAMETERS, values, strict=False)}


def inside_intervals(estimate: Calibration, truth: TrueValues) -> dict[str, bool]:
    """Which 95 % intervals hold the truth, of the parameters that were estimated."""
    inside = {}
    for name, value in true_parameters(estimate, truth).items():
        interval = estimate.interval(name)
        if interval is not None and estimate.standard_deviation(name) > 0:
            inside[name] = interval[0] <= value <= interval[1]
    return inside


def rotation_vector_deg(R: FloatArray) -> FloatArray:
    """Rotation vector (3,) of `R` in degrees, exact also when it is tiny (cv2.Rodrigues gives 0 below 0.0006 deg)."""
    sine = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    if np.linalg.norm(sine) < 1e-3 and np.trace(R) > 2:
        return np.asarray(np.degrees(sine * (1 + sine @ sine / 6)), np.float64)
    return np.degrees(cv2.Rodrigues(np.asarray(R, np.float64))[0]).reshape(3).astype(np.float64)


def rotation_angle_deg(R: FloatArray) -> float:
    """Angle of the rotation `R` in degrees."""
    return float(np.linalg.norm(rotation_vector_deg(R)))


def angle_between_deg(a: FloatArray, b: FloatArray) -> float:
    """Angle between two vectors in degrees, exact also when it is tiny."""
    return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b)), np.dot(a, b))))
