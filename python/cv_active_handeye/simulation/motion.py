# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The recordings: where the camera goes, how it looks at the bench, and whether the arm can do it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from ..robots.kinematics import SerialArm, UnreachableError
from .parts import Array

STAND_OFF = 0.55
"""Distance (m) from the camera to the aimed point at the middle of every orientation's stops."""

_SHORT_MOVE = (0.15, 1.0)  # metres and degrees: moved on a straight line, longer ones joint by joint
_GROUP = np.array([[0, 0, 94], [83, 0, -28], [-83, 0, -28], [0, 75, -38], [0, -75, 0]]) / 1000


@dataclass(frozen=True)
class Look:
    """One orientation: fixed-axis angles (deg) about the image's x, y and the optical axis.

    stops: camera positions (N, 3) relative to the first look, metres, camera frame.
    """

    euler_deg: tuple[float, float, float]
    stops: Array


def default_looks() -> list[Look]:
    """Return the 14 stops: two groups of four translations, then two orientations with two stops each.

    The second group is the first one mirrored. Over 20 seeds the closed forms' errors are a tenth (rotation) to a third
    (focal length, t_cam2gripper) smaller than with two equal tetrahedra of stops.
    """
    return [
        Look((6, -14, 0), _GROUP),
        Look((-6, 14, 0), -_GROUP),
        Look((3, -2, -90), np.array([[24, 24, -40], [-32, -24, 40]]) / 1000),
        Look((-20, -2, -35), np.array([[-32, 24, 40], [32, -24, -40]]) / 1000),
    ]


def check_looks() -> list[Look]:
    """Return 5 stops for verifying a calibration: a translation, and turns about all axes."""
    return [
        Look((3, -8, -10), np.array([[20, 20, 30], [-20, -20, -30]]) / 1000),
        Look((-10, 8, -45), np.array([[-25, 20, -20]]) / 1000),
        Look((8, -6, -110), np.array([[25, -20, 20]]) / 1000),
        Look((-14, -8, -70), np.array([[-20, -20, -30]]) / 1000),
    ]


def scan_looks() -> list[Look]:
    """Return 40 stops of a scan: straight down, in steps of 5 mm across the stripe, over 195 mm of the bench."""
    along = np.linspace(-97.5, 97.5, 40) / 1000
    return [Look((0, 0, 0), np.column_stack([0 * along, along, 0 * along]))]


LOOKS = {"default": default_looks, "check": check_looks, "scan": scan_looks}
"""The recordings by the names of `CellConfig.motion`."""


def camera_poses(looks: list[Look], aim: Array) -> list[Array]:
    """Return camera poses (4, 4) in the bench frame.

    aim: point (3,) of the bench in the middle of the view of every orientation. Without turn the camera looks
    straight down with the image's x along the bench's x.
    """
    down = Rotation.from_euler("x", 180, degrees=True)
    out = []
    for look in looks:
        R = (down * Rotation.from_euler("xyz", look.euler_deg, degrees=True)).as_matrix()
        for stop in look.stops:
            pose = np.eye(4)
            pose[:3, :3] = R
            pose[:3, 3] = aim - STAND_OFF * R[:, 2] + R @ stop
            out.append(pose)
    return out


def check_motion(arm: SerialArm, poses: list[Array]) -> Array:
    """Return joint values (N, 6) for a list of flange poses (4, 4), each reached from the one before.

    Short moves without turning are straight lines, checked along the way; others go joint by joint, which stays within
    limits by itself. Raises UnreachableError naming the stop.
    """
    joints: list[Array] = []
    for i, pose in enumerate(poses):
        straight = bool(joints) and _is_short(poses[i - 1], pose)
        joints.append(_next_joints(arm, joints[-1] if joints else None, pose, straight, f"stop {i} of {len(poses)}"))
    return np.array(joints).reshape(-1, 6)


def _next_joints(arm: SerialArm, now: Array | None, pose: Array, straight: bool, stop: str) -> Array:
    try:
        if straight and now is not None:
            return np.asarray(arm.follow(now, pose)[-1])
        return arm.inverse(pose, near=now)
    except UnreachableError as error:
        raise UnreachableError(f"{stop}: {error}") from error


def _is_short(a: Array, b: Array) -> bool:
    turn = Rotation.from_matrix(a[:3, :3].T @ b[:3, :3]).magnitude()
    return bool(np.linalg.norm(b[:3, 3] - a[:3, 3]) <= _SHORT_MOVE[0] and np.degrees(turn) <= _SHORT_MOVE[1])
