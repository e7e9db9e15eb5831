# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What a robot is to this software, whoever made it.

SI units and 4 x 4 flange-to-base matrices; a device's own units and pose convention stay in its file. A robot is opened
with `live=False` unless somebody said otherwise, and then has no connection that could move it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from types import TracebackType
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

Array = NDArray[np.float64]


class StopReason(str, Enum):
    """Why a robot stands still and must not be moved by this program again."""

    PROTECTIVE_STOP = "protective stop"
    EMERGENCY_STOP = "emergency stop"
    SAFEGUARD_STOP = "safeguard stop"
    CONTROLLER_ERROR = "controller error"
    PROGRAM_STOPPED = "program stopped"
    LINK_LOST = "link lost"
    STALE_POSE = "stale pose"
    DEADLINE = "deadline"
    NOT_ARRIVED = "not arrived"
    OFF_PATH = "off the path"
    OPERATOR = "operator"


class RobotError(RuntimeError):
    """Something about the robot; the text names what, where, and what the person beside it can do."""


class RobotUnavailableError(RobotError):
    """No connection, or the controller refuses it (no answer, not in remote control, registers in use, wrong mode)."""


class MoveRefusedError(RobotError):
    """A move that was not begun: not live, beyond a cap, outside of the workspace, out of the arm's reach."""


class RobotStoppedError(RobotError):
    """The robot was stopped or stands in doubt. Nothing moves it any more until a person connects anew."""

    def __init__(self, reason: StopReason, text: str) -> None:
        """`text` says what was seen and what to do; the reason is put before it."""
        super().__init__(f"{reason.value}: {text}")
        self.reason = reason


@dataclass(frozen=True)
class RobotPose:
    """One fresh reading.

    T_gripper2base: flange (4, 4), m. joints: (6,), rad, as the controller shows them. controller_time: the controller's
    own clock, s. received: `time.monotonic` of this machine when the reading arrived, s.
    """

    T_gripper2base: Array
    joints: Array
    controller_time: float
    received: float


class Speed(BaseModel):
    """How fast a straight move may be: m/s and m/s^2 of the flange. The cap of 0.25 m/s is that of manual mode."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    metres_per_second: float = Field(default=0.05, gt=0, le=0.25)
    metres_per_second2: float = Field(default=0.2, gt=0, le=1.0)

    def seconds(self, length: float) -> float:
        """Time for a way of so many metres with a trapezoidal profile."""
        v, a = self.metres_per_second, self.metres_per_second2
        return length / v + v / a if length > v * v / a else 2 * math.sqrt(length / a)


@runtime_checkable
class Robot(Protocol):
    """An arm with six axes. Use as a context manager: leaving it stops, restores what was changed, and disconnects.

    Every call returns within a deadline of its own and never hangs on a dead link.
    """

    name: str
    """For messages and the data set: maker, model, address."""
    model: str | None
    """Key of `kinematics.ARMS` where the geometry is known, else None."""
    live: bool
    """Whether it was opened to be moved."""

    def pose(self) -> RobotPose:
        """Returns a fresh reading; RobotStoppedError (STALE_POSE, LINK_LOST) where none arrives within 0.2 s."""
        ...

    def check_reachable(self, T_gripper2base: Array) -> None:
        """Asks the controller, where it can tell, whether it could take a pose (4, 4); MoveRefusedError if not."""
        ...

    def move_linear(self, T_gripper2base: Array, speed: Speed) -> None:
        """Moves the flange on a straight line to a pose (4, 4) and returns when it has arrived.

        Watches the controller all the way and stops the arm on any doubt: RobotStoppedError. MoveRefusedError where
        nothing was begun. A move has a deadline made of its length and speed.
        """
        ...

    def is_steady(self) -> bool:
        """Whether the controller says that the arm has come to rest."""
        ...

    def stop(self) -> None:
        """Stops the arm; may be called at any time, from any thread, again and again. Errors are swallowed."""
        ...

    def set_output(self, pin: int, on: bool) -> None:
        """Switches a digital output (a laser's, for example); RobotError where the pin does not exist."""
        ...

    def close(self) -> None:
        """Stops, restores tool and mode as they were found, and disconnects; never raises."""
        ...

    def __enter__(self) -> Robot: ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None: ...
