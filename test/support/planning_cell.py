# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A UR5e over a table for the planner, and its kinematics written down a second time."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from cv_active_handeye.robots.workspace import Box, Workspace
from cv_active_handeye.workflow.plan_settings import PlanSettings
from cv_active_handeye.workflow.plan_views import Start

Array = NDArray[np.float64]

JOINTS = np.radians([-178.1, -18.0, -87.0, 15.0, -93.0, 179.5])
TOOL_MM = ((0.0, 110.0, 120.0),)
DH = [(0.1625, 0.0, 90), (0, -0.425, 0), (0, -0.3922, 0), (0.1333, 0, 90), (0.0997, 0, -90), (0.0996, 0, 0)]
"""d, a [m], alpha [deg] of the maker's data sheet."""


def flange(q: Array) -> Array:
    """Flange pose (4, 4) for joints (6,), rad."""
    T = np.eye(4)
    for angle, (d, a, alpha) in zip(q, DH, strict=True):
        turn, twist = np.eye(4), np.eye(4)
        turn[:3, :3] = Rotation.from_euler("z", angle).as_matrix()
        turn[2, 3] = d
        twist[:3, :3] = Rotation.from_euler("x", alpha, degrees=True).as_matrix()
        twist[0, 3] = a
        T = T @ turn @ twist
    return T


def joints_near(T: Array, q: Array) -> Array:
    """Joints (6,) near q that take a pose, found by least squares on `flange`."""

    def miss(x: Array) -> Array:
        error = np.linalg.inv(T) @ flange(x)
        return np.concatenate([error[:3, 3], Rotation.from_matrix(error[:3, :3]).as_rotvec()])

    found = least_squares(miss, q, xtol=1e-12, ftol=1e-12, gtol=1e-12)
    assert np.abs(found.fun).max() < 1e-7
    return np.asarray(found.x)


def smallest_singular_value(q: Array) -> float:
    """Of the derivative of `flange`, lengths over the reach of 0.85 m, by finite differences."""
    T, step, columns = flange(q), 1e-6, []
    for k in range(6):
        moved = np.linalg.inv(T) @ flange(q + step * np.eye(6)[k])
        columns.append([*(moved[:3, 3] / 0.85), *Rotation.from_matrix(moved[:3, :3]).as_rotvec()])
    return float(np.linalg.svd(np.array(columns).T / step, compute_uv=False)[-1])


@cache
def start(model: str | None = "ur5e") -> Start:
    """The camera looks at the table from 0.55 m."""
    return Start("UR5e of the test", model, flange(JOINTS), JOINTS if model else None)


def settings(**changes: Any) -> PlanSettings:
    """Box 300 mm around the start, a table, a tool point, 12 stops."""
    middle = 1000 * flange(JOINTS)[:3, 3]
    box = Box(lower_mm=tuple(middle - 300), upper_mm=tuple(middle + 300))
    table = Box(lower_mm=(-2000, -2000, -1000), upper_mm=(2000, 2000, middle[2] - 250))
    content: dict[str, Any] = {
        "workspace": Workspace(box=box, no_go=(table,), tool_points_mm=TOOL_MM),
        "image_width": 640,
        "image_height": 480,
        "focal_px": 1400.0,
        "t_cam2gripper_mm": (0.0, 100.0, 100.0),
        "R_cam2gripper_deg": (4.0, -5.0, 3.0),
        "stand_off_mm": 550.0,
        "stops": 12,
    }
    return PlanSettings.model_validate(content | changes)
