# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Where the robot really is: servo error, repeatability and a smooth absolute error."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from .config import CellConfig
from .parts import Array

_WAVES = 4
_SHORTEST_WAVE = 0.8  # metres


class RobotErrors:
    """Turns a commanded flange pose into the reported and the true one; every stop has its own noise."""

    def __init__(self, config: CellConfig, key: int) -> None:
        """Draws the smooth error field; `key` tells the random streams of the cell apart."""
        self._config = config
        self._key = key
        rng = np.random.default_rng([config.seed, key])
        direction = rng.standard_normal((_WAVES, 3))
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        self._wave = 2 * np.pi / (_SHORTEST_WAVE * rng.uniform(1, 2, (_WAVES, 1))) * direction
        self._phase = rng.uniform(0, 2 * np.pi, (_WAVES, 1))
        self._gain = rng.standard_normal((_WAVES, 6))
        self._gain /= np.sqrt((self._gain**2).sum(axis=0) / 2)  # RMS 1 per axis over space
        self._gain /= np.sqrt(3)  # RMS 1 of the vector

    def reported(self, commanded: Array, stop: int) -> Array:
        """Return the pose (4, 4) the controller reports: the commanded one within the servo error."""
        rng = np.random.default_rng([self._config.seed, self._key, 1, stop])
        return _moved(commanded, self._config.servo_mm, self._config.servo_deg, rng)

    def true(self, reported: Array, stop: int) -> Array:
        """Return the pose (4, 4) the flange really has when the controller reports `reported`."""
        rng = np.random.default_rng([self._config.seed, self._key, 2, stop])
        pose = _moved(reported, self._config.repeatability_mm, self._config.repeatability_deg, rng)
        shift, turn = self.absolute(reported[:3, 3])
        pose[:3, 3] += shift
        pose[:3, :3] = Rotation.from_rotvec(turn).as_matrix() @ pose[:3, :3]
        return pose

    def absolute(self, position: Array) -> tuple[Array, Array]:
        """Return the smooth error at a flange position: shift (m) and rotation vector (rad), both in the base frame."""
        field = (np.sin(self._wave @ position[:, None] + self._phase) * self._gain).sum(axis=0)
        return (
            self._config.absolute_error_mm / 1000 * field[:3],
            np.radians(self._config.absolute_error_deg) * field[3:],
        )


def _moved(pose: Array, sigma_mm: float, sigma_deg: float, rng: np.random.Generator) -> Array:
    out = np.eye(4)
    turn = Rotation.from_rotvec(np.radians(sigma_deg) * rng.standard_normal(3))
    out[:3, :3] = (turn * Rotation.from_matrix(pose[:3, :3])).as_matrix()
    out[:3, 3] = pose[:3, 3] + sigma_mm / 1000 * rng.standard_normal(3)
    return out
