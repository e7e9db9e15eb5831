# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Where the camera stops: motions made for calibration without a target, and motions made for a board. Metres."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from .scene import CENTRE, FAR, NEAR, TETRAHEDRON, Array

DOWN = Rotation.from_euler("x", 180, degrees=True)
TURNS_DEG = np.array(
    [
        [0, 0, -135],
        [-25, 0, 180],
        [14, -20, -90],
        [-15, -18, 180],
        [0, 22, -45],
        [-22, -13, -45],
        [19, -21, 90],
        [-21, 21, 90],
    ]
)
"""Orientations of the camera about its x, y, z axis; those of groups come first."""
STOPS_12, STOPS_24 = (5, 5, 1, 1), (5, 5, 5, 5, 1, 1, 1, 1)
"""Stops at each orientation: 2 x 5 + 2 and 4 x 5 + 4."""


def active_stops(
    rng: np.random.Generator, stops: Sequence[int] = STOPS_24, reach: float = 0.06, turns_deg: Array = TURNS_DEG
) -> tuple[Array, Array]:
    """R_cam2base (V, 3, 3) and positions of the camera (V, 3): `stops[g]` views at the g-th orientation.

    The first of a group is over the middle of the scene, the others about `reach` away towards the corners of a
    tetrahedron, which is turned at random in every group.
    """
    orientations: list[Array] = []
    positions: list[Array] = []
    for group, count in enumerate(stops):
        R = (DOWN * Rotation.from_euler("xyz", turns_deg[group] + rng.uniform(-3, 3, 3), degrees=True)).as_matrix()
        corners = TETRAHEDRON @ Rotation.random(random_state=rng).as_matrix()
        for stop in range(count):
            moved = rng.uniform(0.95, 1.05) * reach * corners[(stop - 1) % 4] if stop else np.zeros(3)
            orientations.append(R)
            positions.append(CENTRE - 0.5 * (NEAR + FAR) * R[:, 2] + R @ moved)
    return np.array(orientations), np.array(positions)


def board_stop(rng: np.random.Generator, tilt_deg: float = 30, roll_deg: float = 90) -> tuple[Array, Array]:
    """One view of a board at CENTRE, at 0.45 to 0.65 m: tilted up to `tilt_deg` about x and y, rolled to `roll_deg`."""
    turn = rng.uniform(-1, 1, 3) * [tilt_deg, tilt_deg, roll_deg]
    R = (DOWN * Rotation.from_euler("xyz", turn, degrees=True)).as_matrix()
    aside = np.append(rng.uniform(-0.03, 0.03, 2), 0)
    return R, CENTRE + R @ aside - rng.uniform(NEAR, FAR) * R[:, 2]
