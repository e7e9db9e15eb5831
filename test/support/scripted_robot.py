# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A robot that is where it was told to be at once, remembers every call, and fails where a test says so."""

from __future__ import annotations

import time
from collections.abc import Callable
from types import TracebackType

import numpy as np
from numpy.typing import NDArray

from cv_active_handeye.robots.base import RobotPose, Speed
from cv_active_handeye.robots.workspace import Box, Workspace

Array = NDArray[np.float64]

BOX = Workspace(box=Box(lower_mm=(-500, -500, -500), upper_mm=(500, 500, 500)))


class ScriptedRobot:
    """`on_move`, `on_pose`: called first in move_linear and pose; they may raise, wait or change the robot."""

    name = "scripted"
    model: str | None = None

    def __init__(self, live: bool = True) -> None:
        self.live = live
        self.T: Array = np.eye(4)
        self.calls: list[str] = []
        self.targets: list[Array] = []
        self.steady = True
        self.clock = 0.0
        self.on_move: Callable[[], None] = lambda: None
        self.on_pose: Callable[[], None] = lambda: None

    def pose(self) -> RobotPose:
        self.on_pose()
        self.clock += 0.002
        return RobotPose(self.T.copy(), np.zeros(6), self.clock, time.monotonic())

    def check_reachable(self, T_gripper2base: Array) -> None:
        self.calls.append("check_reachable")

    def move_linear(self, T_gripper2base: Array, speed: Speed) -> None:
        self.calls.append("move_linear")
        self.on_move()
        self.targets.append(T_gripper2base)
        self.T = T_gripper2base.copy()

    def is_steady(self) -> bool:
        return self.steady

    def stop(self) -> None:
        self.calls.append("stop")

    def set_output(self, pin: int, on: bool) -> None:
        self.calls.append(f"output {pin} {on}")

    def close(self) -> None:
        self.calls.append("close")

    def __enter__(self) -> ScriptedRobot:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def at(x_mm: float, y_mm: float = 0.0, z_mm: float = 0.0) -> Array:
    """A flange pose (4, 4) without turn."""
    out = np.eye(4)
    out[:3, 3] = np.array([x_mm, y_mm, z_mm]) / 1000
    return out
