# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What the drawing of the simulated cell says; the cell itself differs from it a little, as its seed draws."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..robots.workspace import Box, Workspace
from .config import CellConfig
from .motion import STAND_OFF
from .parts import Array

MOUNTING_DEG = np.array([4.1, -4.6, 2.7])
"""Rotation vector of R_cam2gripper."""
MOUNTING = np.array([-0.005, 0.103, 0.103])
"""t_cam2gripper, m."""
LASER_ORIGIN = np.array([0.004, -0.100, 0.010])
"""Where the light sheet begins, m, camera frame."""
LASER_SLANT = 0.02
"""Angle of the stripe in the image, rad."""
ROOM_MM = 350.0
"""Half the edge of the box that the arm has around where it starts."""


def light_plane_through(origin: Array, crossing: Array, along: Array) -> Array:
    """The plane (4,) n.X = d, d > 0, m, through two points (3,) and along a direction (3,)."""
    n = np.cross(crossing - origin, along)
    n /= np.linalg.norm(n)
    d = float(n @ origin)
    return np.append(n, d) * (1.0 if d > 0 else -1.0)


def nominal_planning(config: CellConfig, T_gripper2base: Array) -> dict[str, Any]:
    """What to plan with in the simulated cell, for `PlanSettings`: the drawing, and a box around a flange pose."""
    crossing = np.array([0.0, 0.0, STAND_OFF])
    along = np.array([np.cos(LASER_SLANT), np.sin(LASER_SLANT), 0.015])
    plane = light_plane_through(LASER_ORIGIN, crossing, along)
    middle = 1000 * T_gripper2base[:3, 3]
    box = Box(lower_mm=_point(middle - ROOM_MM), upper_mm=_point(middle + ROOM_MM))
    camera = _point(1000 * MOUNTING)
    return {
        "workspace": Workspace(box=box, tool_points_mm=(camera,)),
        "image_width": config.width,
        "image_height": config.height,
        "focal_px": config.focal_px,
        "t_cam2gripper_mm": camera,
        "R_cam2gripper_deg": _point(MOUNTING_DEG),
        "stand_off_mm": 1000 * STAND_OFF,
        "light_plane_mm": (*_point(plane[:3]), 1000 * float(plane[3])) if config.laser else None,
    }


def _point(values: Array) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return x, y, z
