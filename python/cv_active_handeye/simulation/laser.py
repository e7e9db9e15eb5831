# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The line laser: a sheet of light with a Gaussian profile, rigid to the camera, that casts shadows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .parts import Array
from .scene import Scene

_SHADOW_TOLERANCE = 3e-5  # metres a hit may lie before the lit point


@dataclass(frozen=True)
class Laser:
    """A light sheet n.X = d (camera frame, |n| = 1, d > 0) that leaves `origin`, a point of the plane.

    sigma: Gaussian half width of the sheet in metres; power: irradiance at the centre of the sheet at `reference`
    metres from the origin (it falls with 1 / distance), 1 = that of the lamp.
    """

    n: Array
    d: float
    origin: Array
    sigma: float
    power: float
    reference: float

    @property
    def plane(self) -> Array:
        """(nx, ny, nz, d) in the camera frame, metres."""
        return np.append(self.n, self.d)

    def irradiance(self, scene: Scene, T_cam2scene: Array, point: Array, triangle: NDArray[np.int64]) -> Array:
        """Return the irradiance at points (N, 3) of the scene frame on triangles (N,): profile, angle and shadows."""
        R, t = T_cam2scene[:3, :3], T_cam2scene[:3, 3]
        distance = (point - t) @ (R @ self.n) - self.d
        profile = np.exp(-0.5 * (distance / self.sigma) ** 2)
        source = t + R @ self.origin
        ray = point - source
        length = np.linalg.norm(ray, axis=1)
        cosine = -np.einsum("ij,ij->i", ray, scene.normal[triangle]) / length
        lit = (cosine > 0) & self._unobstructed(scene, source, ray, length)
        return np.where(lit, self.power * profile * cosine * self.reference / length, 0.0)

    def reach(self) -> float:
        """Distance from the plane (m) beyond which the laser's light is below 1 / 20000 of its centre."""
        return 4.5 * self.sigma

    def lit(self, scene: Scene, T_cam2scene: Array, point: Array, triangle: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Return which points (N, 3) of the scene frame on triangles (N,) the laser can see."""
        source = T_cam2scene[:3, 3] + T_cam2scene[:3, :3] @ self.origin
        ray = point - source
        facing = np.einsum("ij,ij->i", ray, scene.normal[triangle]) < 0
        return np.asarray(facing & self._unobstructed(scene, source, ray, np.linalg.norm(ray, axis=1)))

    @staticmethod
    def _unobstructed(scene: Scene, source: Array, ray: Array, length: Array) -> NDArray[np.bool_]:
        depth = scene.cast(source, ray).depth
        return ~((depth - 1) * length < -_SHADOW_TOLERANCE)
