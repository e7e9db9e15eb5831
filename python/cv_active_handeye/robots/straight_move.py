# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A straight move as whoever watches it sees it: how far off the line, arrived or not, and by when."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .base import Array
from .workspace import step_size

ARRIVED_M, ARRIVED_DEG = 0.05e-3, 0.01
OFF_PATH_M, OFF_PATH_DEG = 2e-3, 2.0

_LEVER_M = 0.25  # how fast a pure rotation runs is the controller's choice; taken as a point this far from the axis
_SLOWER, _EXTRA_S = 6.0, 3.0


@dataclass(frozen=True)
class StraightMove:
    """From one flange pose (4, 4) to another, on a straight line with a uniform turn."""

    start: Array
    end: Array

    def off_path(self, T_gripper2base: Array) -> str | None:
        """What is wrong with a pose (4, 4) on the way, None where it is within 2 mm and 2 deg of it."""
        way = self.end[:3, 3] - self.start[:3, 3]
        done = T_gripper2base[:3, 3] - self.start[:3, 3]
        share = np.clip(done @ way / max(float(way @ way), 1e-12), 0.0, 1.0)
        off = float(np.linalg.norm(done - share * way))
        turns = step_size(self.start, T_gripper2base)[1] + step_size(T_gripper2base, self.end)[1]
        detour = turns - step_size(self.start, self.end)[1]
        if off <= OFF_PATH_M and detour <= OFF_PATH_DEG:
            return None
        return (
            f"{1000 * off:.2f} mm from the line ({1000 * OFF_PATH_M:g} are allowed), "
            f"{detour:.2f} deg of needless turn ({OFF_PATH_DEG:g} are allowed)"
        )

    def remaining(self, T_gripper2base: Array) -> str | None:
        """How far a pose (4, 4) is from the end, None where that is within 0.05 mm and 0.01 deg."""
        length, angle = step_size(T_gripper2base, self.end)
        if length <= ARRIVED_M and angle <= ARRIVED_DEG:
            return None
        return (
            f"{1000 * length:.3f} mm and {angle:.4f} deg from the commanded pose "
            f"({1000 * ARRIVED_M:g} mm and {ARRIVED_DEG:g} deg are allowed)"
        )

    def deadline_s(self, metres_per_second: float, metres_per_second2: float) -> float:
        """3 s and six times what the move takes at this speed and acceleration of the flange."""
        length, angle = step_size(self.start, self.end)
        way = max(length, _LEVER_M * np.radians(angle))
        return float(_EXTRA_S + _SLOWER * (way / metres_per_second + 2 * metres_per_second / metres_per_second2))
