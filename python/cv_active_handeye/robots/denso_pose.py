# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Poses of DENSO controllers (mm, deg) to matrices (m) and back.

P-type: x, y, z, RX, RY, RZ, figure with R = Rz(RZ) Ry(RY) Rx(RX), turns about fixed axes. T-type: x, y, z, orient
vector (Y column of R), approach vector (Z column), figure. Figure -1 leaves the choice to the controller. Which
convention a controller has is not believed but asked: see `denso_check`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from .base import Array, RobotError
from .bcap_packets import Value

ANY_FIGURE = -1.0
P_SIZE, T_SIZE = 7, 10

_UNIT = 1e-3  # how far the vectors of a T-type pose may be from unit length and right angles


def matrix_from_p(values: ArrayLike) -> Array:
    """Matrix (4, 4), m, of the P-type values x, y, z (mm), RX, RY, RZ (deg), ..."""
    pose = np.asarray(values, np.float64)
    (cx, cy, cz), (sx, sy, sz) = np.cos(np.radians(pose[3:6])), np.sin(np.radians(pose[3:6]))
    out = np.eye(4)
    out[:3, :3] = [
        [cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx],
        [sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx],
        [-sy, cy * sx, cy * cx],
    ]
    out[:3, 3] = pose[:3] / 1000
    return out


def p_from_matrix(T_gripper2base: Array, figure: float = ANY_FIGURE) -> list[float]:
    """P-type values (7) of a matrix (4, 4), m; angles in (-180, 180], RY in [-90, 90].

    At RY = +-90 only the difference or sum of RX and RZ is determined; RX is then made to fit the RZ that rounding
    leaves, so that the rotation keeps full accuracy there and nearby.
    """
    R = T_gripper2base[:3, :3]
    rz = np.arctan2(R[1, 0], R[0, 0])
    ry = np.arctan2(-R[2, 0], np.hypot(R[0, 0], R[1, 0]))
    turned = np.cos(rz) * R[1] - np.sin(rz) * R[0]  # second row of Ry Rx: (0, cos RX, -sin RX)
    rx = np.arctan2(-turned[2], turned[1])
    return [*map(float, 1000 * T_gripper2base[:3, 3]), *map(float, np.degrees([rx, ry, rz])), float(figure)]


def matrix_from_t(values: ArrayLike) -> Array:
    """Matrix (4, 4), m, of the T-type values x, y, z (mm), orient vector, approach vector, ...

    RobotError where the vectors are not of unit length and at right angles within 1e-3; what is less is taken away.
    """
    pose = np.asarray(values, np.float64)
    orient, approach = pose[3:6], pose[6:9]
    off = np.abs([orient @ orient - 1, approach @ approach - 1, orient @ approach]).max()
    if not off < _UNIT:
        raise RobotError(f"T-type pose: needs unit vectors at right angles within {_UNIT:g}, got {list(pose[3:9])}")
    z = approach / np.linalg.norm(approach)
    y = orient - (orient @ z) * z
    y /= np.linalg.norm(y)
    out = np.eye(4)
    out[:3, :3] = np.column_stack([np.cross(y, z), y, z])
    out[:3, 3] = pose[:3] / 1000
    return out


def t_from_matrix(T_gripper2base: Array, figure: float = ANY_FIGURE) -> list[float]:
    """T-type values (10) of a matrix (4, 4), m."""
    parts = (1000 * T_gripper2base[:3, 3], T_gripper2base[:3, 1], T_gripper2base[:3, 2], [figure])
    return [float(value) for part in parts for value in part]


def numbers(answer: Value, least: int, what: str) -> Array:
    """The numbers of an answer, `least` or more and all finite; RobotError names the command that gave others."""
    if isinstance(answer, (list, tuple)) and all(isinstance(value, (int, float)) for value in answer):
        values = np.array(answer, np.float64)
        if len(values) >= least and np.isfinite(values).all():
            return values
    raise RobotError(f"{what}: needs {least} finite numbers or more, the controller gave {_shortened(answer)}")


def _shortened(answer: Value) -> str:
    text = repr(answer)
    return text if len(text) <= 100 else text[:100] + "..."
