# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Random recordings: the paper's camera over points at 0.45 to 0.65 m. Metres and pixels."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

WIDTH, HEIGHT, FOCAL = 640, 480, 1413.0
NEAR, FAR = 0.45, 0.65
CENTRE = np.array([0.4, 0.1, 0.0])
TETRAHEDRON = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / np.sqrt(3)
TURNS_DEG = np.array([[0, 0, 0], [22, -6, 5], [-10, 18, 80], [-15, -20, -40], [12, 20, 150], [-24, 4, -90]])
"""Orientations of the camera about its x, y, z axis; the first groups translate at the first ones."""


@dataclass(frozen=True)
class Scene:
    """A calibration, V views and N points: what is true, and which points each view sees (`visible`, V x N)."""

    camera_matrix: Array
    R_cam2gripper: Array
    t_cam2gripper: Array
    R_gripper2base: Array
    t_gripper2base: Array
    points: Array
    visible: NDArray[np.bool_]
    groups: list[list[int]]

    def parameters(self) -> Array:
        """fx, fy, cx, cy, skew, rotation error vector (zero), t_cam2gripper."""
        K = self.camera_matrix
        return np.array([K[0, 0], K[1, 1], K[0, 2], K[1, 2], K[0, 1], 0, 0, 0, *self.t_cam2gripper])

    def project(self, parameters: NDArray[Any], points: NDArray[Any]) -> NDArray[Any]:
        """Pixels (V, N, 2) of points (N, 3) in base coordinates.

        First order in the rotation error vector, and analytic, so that complex steps differentiate it.
        """
        fx, fy, cx, cy, skew, a, b, c, *t = parameters
        turn = np.array([[1, -c, b], [c, 1, -a], [-b, a, 1]])
        in_gripper = (points[None] - self.t_gripper2base[:, None]) @ self.R_gripper2base
        x, y, z = np.moveaxis((in_gripper - np.array(t)) @ turn @ self.R_cam2gripper, -1, 0)
        return np.stack([(fx * x + skew * y) / z + cx, fy * y / z + cy], axis=-1)

    def observe(self, rng: np.random.Generator, sigma: float) -> Array:
        """Image points (V, N, 2) with Gaussian noise of `sigma` px per axis; NaN where not visible."""
        pixels = np.asarray(self.project(self.parameters(), self.points), dtype=np.float64)
        pixels += rng.normal(0, sigma, pixels.shape)
        pixels[~self.visible] = np.nan
        return pixels


def random_scene(
    rng: np.random.Generator,
    points: int = 30,
    stops: tuple[int, ...] = (5,),
    missing: float = 0.0,
    square: bool = False,
) -> Scene:
    """`stops[g]` views at the g-th orientation: one over the scene's centre, the others 45 to 56 mm away from it.

    All points are in the image in all views; a share of `missing` is then made invisible at random.
    """
    K = np.array([[FOCAL, 0, WIDTH / 2], [0, FOCAL if square else 1.003 * FOCAL, HEIGHT / 2], [0, 0, 1]])
    R_cam2gripper = Rotation.random(random_state=rng).as_matrix()
    t_cam2gripper = rng.uniform(-0.1, 0.1, 3)
    orientation, position, groups = _camera_poses(rng, stops)
    R_gripper2base = orientation @ R_cam2gripper.T
    t_gripper2base = position - R_gripper2base @ t_cam2gripper
    nothing = np.zeros((0, 3)), np.zeros((len(position), 0), bool)
    scene = Scene(K, R_cam2gripper, t_cam2gripper, R_gripper2base, t_gripper2base, *nothing, groups)
    candidates = np.zeros((0, 3))
    while len(candidates) < points:
        half = np.array([0.5 * WIDTH / FOCAL * FAR, 0.5 * HEIGHT / FOCAL * FAR, 0.5 * (FAR - NEAR)])
        drawn = CENTRE + rng.uniform(-half, half, (8 * points, 3))
        pixels = scene.project(scene.parameters(), drawn)
        inside = ((pixels >= 0) & (pixels < (WIDTH, HEIGHT))).all(axis=(0, 2))
        candidates = np.concatenate([candidates, drawn[inside]])
    visible = rng.random((len(position), points)) >= missing
    return replace(scene, points=candidates[:points], visible=visible)


def _camera_poses(rng: np.random.Generator, stops: tuple[int, ...]) -> tuple[Array, Array, list[list[int]]]:
    """R_cam2base, positions of the camera, and the views of every orientation."""
    down = Rotation.from_euler("x", 180, degrees=True)
    orientations: list[Array] = []
    positions: list[Array] = []
    groups: list[list[int]] = []
    for group, count in enumerate(stops):
        turn = TURNS_DEG[group % len(TURNS_DEG)] + rng.uniform(-3, 3, 3)
        R = (down * Rotation.from_euler("xyz", turn, degrees=True)).as_matrix()
        directions = TETRAHEDRON @ Rotation.random(random_state=rng).as_matrix()
        groups.append(list(range(len(positions), len(positions) + count)))
        for stop in range(count):
            moved = rng.uniform(0.045, 0.056) * directions[(stop - 1) % 4] if stop else np.zeros(3)
            orientations.append(R)
            positions.append(CENTRE - 0.5 * (NEAR + FAR) * R[:, 2] + R @ moved)
    return np.array(orientations), np.array(positions), groups
