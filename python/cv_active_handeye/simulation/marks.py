# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Marks under the laser: from where its stripe lies on them, and where exactly it crosses their strokes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from .laser import Laser
from .lettering import Mark
from .parts import Array

ROWS = ((0, 1, 2, 3), (4, 5, 6), (7, 8, 9), (10,), (11,), (12,), (13,), (14,))
"""Which of the marks S1 to S15 one stripe crosses."""

ASPECTS = ((6.0, 12.0), (-9.0, -12.0), (6.0, -12.0), (-9.0, 12.0))
"""Degrees by which camera and laser are turned about the row of marks and, within the light's plane, about its normal;
one view each."""

_MIDDLE = np.array([0.012, 0.0, 0.02])  # of sheet and blocks: where the views look


def measuring_poses(laser: Laser, marks: Sequence[Mark]) -> list[Array]:
    """Camera poses (4, 4), camera to scene: for every row of marks the views from all sides, its stripe on the row."""
    rows = [[marks[i] for i in row] for row in ROWS]
    return [_pose_over(laser, row, *aspect) for row in rows for aspect in ASPECTS]


def views_of(number: int) -> range:
    """The views of `measuring_poses` whose stripe crosses mark `number`."""
    row = next(k for k, row in enumerate(ROWS) if number in row)
    return range(row * len(ASPECTS), (row + 1) * len(ASPECTS))


def _pose_over(laser: Laser, row: Sequence[Mark], tilt_deg: float, roll_deg: float) -> Array:
    """The light's plane through the row of marks; about straight down without tilt and roll."""
    positions = np.array([mark.position for mark in row])
    across = np.cross(row[0].along, row[0].normal)
    along = across if len(row) == 1 else positions[-1] - positions[0]
    along /= np.linalg.norm(along)
    down = Rotation.from_euler("x", 180, degrees=True).as_matrix()
    normal = down @ laser.n
    seen = _frame(_across(down[:, 0], normal), normal)  # of camera and light when it looks straight down
    aimed = _frame(along, _across(normal, along))
    roll, tilt = (
        Rotation.from_rotvec(np.radians(a) * axis).as_matrix()
        for a, axis in ((roll_deg, aimed[:, 2]), (tilt_deg, along))
    )
    pose = np.eye(4)
    pose[:3, :3] = tilt @ roll @ aimed @ seen.T @ down
    lit = np.array([0.0, 0.0, laser.d / laser.n[2]])
    centre = positions.mean(axis=0)
    centre += along * (along @ (_MIDDLE - centre))
    pose[:3, 3] = centre - pose[:3, :3] @ lit
    return pose


def _across(vector: Array, axis: Array) -> Array:
    """The part of a vector across a unit axis, of unit length."""
    part = vector - axis * (axis @ vector)
    return np.asarray(part / np.linalg.norm(part))


def _frame(along: Array, normal: Array) -> Array:
    """Axes in columns: along the stripe, within the light's plane, its normal."""
    return np.column_stack([along, np.cross(normal, along), normal])


def crossings(laser: Laser, T_cam2scene: Array, marks: Sequence[Mark]) -> Array:
    """Points (M, 3), scene frame, where the light's plane meets the centre lines of the marks' strokes.

    The plane through a stroke's centre line and along the surface's normal, the surface and the light meet there.
    """
    normal = T_cam2scene[:3, :3] @ laser.n
    offset = laser.d + normal @ T_cam2scene[:3, 3]
    positions, along = np.array([m.position for m in marks]), np.array([m.along for m in marks])
    return np.asarray(positions + along * ((offset - positions @ normal) / (along @ normal))[:, None])
