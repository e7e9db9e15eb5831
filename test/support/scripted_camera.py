# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A camera and a laser that show where a scripted robot stands, and fail where a test says so."""

from __future__ import annotations

import time
from collections.abc import Callable
from types import TracebackType

import cv2
import numpy as np
from numpy.typing import NDArray
from support.scripted_robot import ScriptedRobot

from cv_active_handeye.cameras.base import Frame
from cv_active_handeye.dataset_format import CameraInfo


class ScriptedCamera:
    """A texture that moves by 1 px for every mm of the robot's x, brighter by 50 when the laser is on."""

    info = CameraInfo(width=96, height=64, name="scripted")

    def __init__(self, robot: ScriptedRobot) -> None:
        self.robot = robot
        self.laser = False
        self.laser_calls: list[bool] = []
        self.grabbed = 0
        self.shift_px = 0.0
        self.on_grab: Callable[[], None] = lambda: None
        noise = np.random.default_rng(8).uniform(20, 180, (80, 400)).astype(np.float32)
        self._texture = cv2.GaussianBlur(noise, (0, 0), 2)

    def grab(self) -> Frame:
        self.on_grab()
        self.grabbed += 1
        x = 150 + self.shift_px + 1000 * float(self.robot.T[0, 3]) % 50
        window = cv2.getRectSubPix(self._texture, (96, 64), (x, 40))
        image: NDArray[np.uint8] = np.clip(window + 50 * self.laser, 0, 255).astype(np.uint8)
        return Frame(image, None, time.monotonic(), time.monotonic())

    def set_line(self, on: bool) -> None:
        self.laser = on
        self.laser_calls.append(on)

    def close(self) -> None:
        self.laser_calls.append(False)

    def __enter__(self) -> ScriptedCamera:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
