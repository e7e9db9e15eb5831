# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Judges what a UR controller says, before and during a motion, without any connection."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from .base import Array, RobotStoppedError, Speed, StopReason
from .straight_move import StraightMove
from .ur_pose import pose_matrix
from .waiting import WatchedTime

RUNNING_MODE, PLAYING = 7, 2
ROBOT_MODES = {
    -1: "no controller",
    0: "disconnected",
    1: "confirming safety",
    2: "booting",
    3: "power off",
    4: "power on, not released",
    5: "idle: brakes not released",
    6: "backdrive",
    8: "updating firmware",
}
_SAFETY = (
    (1 << 5 | 1 << 6 | 1 << 7, StopReason.EMERGENCY_STOP, "release the button, then restart the robot at the pendant"),
    (1 << 8 | 1 << 9, StopReason.CONTROLLER_ERROR, "a safety violation or fault: read the log at the pendant"),
    (1 << 2, StopReason.PROTECTIVE_STOP, "find what was hit or overloaded, then unlock it at the pendant"),
    (1 << 4, StopReason.SAFEGUARD_STOP, "a safeguard is open: leave the cell, then reset it"),
    (1 << 3, StopReason.CONTROLLER_ERROR, "the robot is in recovery: move it out of the violation at the pendant"),
    (1 << 10, StopReason.CONTROLLER_ERROR, "stopped by its safety functions: read the log at the pendant"),
)

_AFTER_MOTION_S = 1.0  # for the arm to arrive after the controller said that the motion is over


@dataclass(frozen=True)
class UrState:
    """One package. time: controller's clock, s; pose: active TCP (4, 4), m; joints: (6,), rad; moving: on its way."""

    time: float
    pose: Array
    joints: Array
    safety_bits: int
    runtime_state: int
    robot_mode: int
    outputs: int
    speed_scaling: float
    connected: bool
    moving: bool

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> UrState:
        """From `ur_child`'s answer; RobotStoppedError where its pose or joints are no numbers."""
        joints = np.array(values["joints"], dtype=np.float64)
        try:
            pose = pose_matrix(values["pose"])
        except ValueError as error:
            raise _no_numbers("pose", values["pose"]) from error
        if joints.shape != (6,) or not np.isfinite(joints).all():
            raise _no_numbers("joints", values["joints"])
        return cls(**{**values, "pose": pose, "joints": joints})


def _no_numbers(what: str, given: object) -> RobotStoppedError:
    text = f"{what}: needs six finite numbers, the controller says {given}: restart it and look at the pendant"
    return RobotStoppedError(StopReason.CONTROLLER_ERROR, text)


def safety_stop(bits: int) -> tuple[StopReason, str] | None:
    """What the safety bits say against moving, with the cure; None where nothing does."""
    for mask, reason, cure in _SAFETY:
        if bits & mask:
            return reason, cure
    return None


def check_state(state: UrState, live: bool) -> None:
    """RobotStoppedError where a package says that the arm must not be moved; `live`: whether our program should run."""
    if not state.connected:
        raise RobotStoppedError(StopReason.LINK_LOST, "the controller closed the connection: check cable and network")
    stop = safety_stop(state.safety_bits)
    if stop is not None:
        raise RobotStoppedError(*stop)
    if state.robot_mode != RUNNING_MODE:
        mode = ROBOT_MODES.get(state.robot_mode, str(state.robot_mode))
        raise RobotStoppedError(StopReason.CONTROLLER_ERROR, f"the robot's mode is '{mode}'")
    if live and state.runtime_state != PLAYING:
        text = (
            "the program on the controller ended: somebody stopped it, a motion was not possible, or the controller "
            "heard nothing of this computer for its watchdog's time (watchdog_s); see the pendant"
        )
        raise RobotStoppedError(StopReason.PROGRAM_STOPPED, text)


class Freshness:
    """Whether the controller's clock still runs, as far as anybody has looked: a pause of this process is no proof."""

    def __init__(self, longest: float) -> None:
        """`longest`: s that the clock may stand still while it is looked at, see `WatchedTime`."""
        self._longest = longest
        self._time: float | None = None
        self._same = WatchedTime(0.0)

    def check(self, state: UrState, now: float) -> None:
        """RobotStoppedError when the time stamp has not changed for too long; `now`: `time.monotonic`."""
        if state.time != self._time:
            self._time = state.time
            self._same.restart(now)
        elif (stood := self._same.look(now)) > self._longest:
            text = f"the controller's clock has stood still for {stood:.2f} s: the pose cannot be trusted"
            raise RobotStoppedError(StopReason.STALE_POSE, text)


class MoveWatch:
    """One straight move, begun at `began` (`time.monotonic`)."""

    def __init__(self, move: StraightMove, speed: Speed, began: float, fresh_s: float) -> None:
        """`fresh_s`: how long the controller's clock may stand still, s."""
        self._move = move
        self._deadline = began + move.deadline_s(speed.metres_per_second, speed.metres_per_second2)
        self._fresh = Freshness(fresh_s)
        self._idle: WatchedTime | None = None

    def arrived(self, state: UrState, now: float) -> bool:
        """Whether the arm has arrived; RobotStoppedError on any doubt."""
        check_state(state, live=True)
        self._fresh.check(state, now)
        off = self._move.off_path(state.pose)
        if off is not None:
            raise RobotStoppedError(StopReason.OFF_PATH, off)
        if now > self._deadline:
            text = f"the move is not over in time; the speed slider is at {100 * state.speed_scaling:.0f} %"
            raise RobotStoppedError(StopReason.DEADLINE, text)
        if state.moving:
            self._idle = None
            return False
        left = self._move.remaining(state.pose)
        if left is None:
            return True
        if self._idle is None:
            self._idle = WatchedTime(now)
        elif self._idle.look(now) > _AFTER_MOTION_S:
            raise RobotStoppedError(StopReason.NOT_ARRIVED, f"the motion is over {left}")
        return False
