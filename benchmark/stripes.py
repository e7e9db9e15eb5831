# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A laser stripe on planes: in every view each surface carries one straight segment, in its part of the image."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from .scene import CENTRE, FAR, NEAR, WIDTH, Array

if TYPE_CHECKING:
    from .world import World

SURFACES, SEGMENT_POINTS = 4, 15
"""60 columns in all."""


@dataclass(frozen=True)
class Stripes:
    """Light plane (nx, ny, nz, d) in the camera frame, S planes (n, e) in the base frame, columns (S, M) seen."""

    light_plane: Array
    surfaces: Array
    columns: Array

    def segments(self, world: World, R_gripper2base: Array, t_gripper2base: Array) -> Array:
        """Exact stripe points (V, S, M, 2) of the recorded images."""
        rows = self.rows(world, world.parameters(), self.light_plane, self.surfaces, R_gripper2base, t_gripper2base)
        columns = np.broadcast_to(self.columns, rows.shape)
        return np.stack([columns, np.asarray(rows, dtype=np.float64)], axis=-1)

    def rows(
        self,
        world: World,
        parameters: NDArray[Any],
        light_plane: NDArray[Any],
        surfaces: NDArray[Any],
        R_gripper2base: NDArray[Any],
        t_gripper2base: NDArray[Any],
    ) -> NDArray[Any]:
        """Rows (V, S, M) of the stripe at the columns; analytic, so that complex steps differentiate it."""
        from .world import pixels

        a, b, c, *t = parameters[10:16]
        turn = np.array([[1, -c, b], [c, 1, -a], [-b, a, 1]])
        R = R_gripper2base @ turn @ world.R_cam2gripper
        position = R_gripper2base @ np.array(t) + t_gripper2base
        normals = np.einsum("si,vij->vsj", surfaces[:, :3], R)
        offsets = surfaces[:, 3] - position @ surfaces[:, :3].T
        m = (offsets[..., None] * light_plane[:3] - light_plane[3] * normals)[:, :, None]
        x = (self.columns - parameters[2]) / parameters[0] + 0 * m[..., 0]
        for _ in range(12):
            ray = np.stack([x, -(m[..., 0] * x + m[..., 2]) / m[..., 1]], axis=-1)
            seen = pixels(parameters, ray)
            x = x + (self.columns - seen[..., 0]) / parameters[0]
        return np.asarray(seen[..., 1])


def random_stripes(rng: np.random.Generator, surfaces: int = SURFACES, points: int = SEGMENT_POINTS) -> Stripes:
    """A light plane that meets the optical axis at working distance at 20 to 25 degrees; tilted planes about CENTRE."""
    angle, tilt = np.radians(rng.uniform(20, 25)), rng.uniform(-0.1, 0.1)
    n = np.array([tilt, np.cos(angle), np.sin(angle)])
    n /= np.linalg.norm(n)
    light_plane = np.append(n, n[2] * 0.5 * (NEAR + FAR))
    planes = []
    for _ in range(surfaces):
        towards = rng.uniform(0, 2 * np.pi)
        lean = np.radians(rng.uniform(10, 30)) * np.array([np.cos(towards), np.sin(towards), 0])
        normal = Rotation.from_rotvec(lean).apply([0, 0, 1])
        planes.append(np.append(normal, normal @ CENTRE + normal[2] * rng.uniform(-0.04, 0.04)))
    places = np.linspace(0.05 * WIDTH, 0.95 * WIDTH, surfaces * points)
    return Stripes(light_plane, np.array(planes), places.reshape(surfaces, points))
