# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What a DENSO controller says of itself: fresh poses, and conditions under which nothing may move."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator

import numpy as np

from .base import Array, MoveRefusedError, RobotError, RobotPose, RobotStoppedError, StopReason
from .bcap import BcapError, BcapLinkError
from .bcap_packets import Value
from .denso_link import Controller, DensoLink
from .denso_pose import P_SIZE, matrix_from_p, numbers

AUTO_MODE = 3
_MODES = {1: "manual", 2: "teach check", 3: "automatic"}
_POLL_S = 0.002


class DensoWatch:
    """Reads over a connection of its own, so that it can look, and halt, while a motion keeps the other one busy."""

    def __init__(self, link: DensoLink, controller: Controller, freshness_s: float) -> None:
        self.link = link
        self.has_clock = controller != "rc7"
        self._freshness_s = freshness_s
        self._stamp = -np.inf

    def pose(self) -> RobotPose:
        """A reading not older than the freshness limit; RobotStoppedError (STALE_POSE, LINK_LOST) otherwise.

        With a controller clock (HighCurPosEx, ms) the time stamp has to be another one than that of the last reading.
        Without (RC7) the time of the answer takes its place. A reading that came too late is asked for once more: it
        may be this process that was paused.
        """
        began, late = time.monotonic(), False
        with told_stops("the pose"):
            while True:
                stamp, values = self._stamped()
                joints = numbers(self._ask("CurJnt"), 6, "CurJnt")
                received = time.monotonic()
                if stamp != self._stamp and received - began <= self._freshness_s:
                    break
                if late:
                    raise RobotStoppedError(StopReason.STALE_POSE, self._stale(stamp))
                late = received - began > self._freshness_s
                if late:
                    began = received
                else:
                    time.sleep(_POLL_S)
        self._stamp = stamp
        return RobotPose(matrix_from_p(values), np.radians(joints[:6]), stamp, received)

    def check(self, motor_on: bool) -> None:
        """RobotStoppedError where the controller is in a state in which nothing may move."""
        with told_stops("the state"):
            code = self._read("@ERROR_CODE") & 0xFFFFFFFF  # first: what is read after it may be its cause
            if self._read("@EMERGENCY_STOP"):
                raise RobotStoppedError(
                    StopReason.EMERGENCY_STOP, "release the emergency stop, clear the error at the pendant"
                )
            mode = self._read("@MODE")
            if mode != AUTO_MODE:
                raise RobotStoppedError(
                    StopReason.PROGRAM_STOPPED,
                    f"the controller is in {_MODES.get(mode, 'an unknown')} mode ({mode}), automatic is needed",
                )
            if code:
                text = self.link.describe(code) or "no description"
                raise RobotStoppedError(
                    StopReason.CONTROLLER_ERROR,
                    f"{code:#010x} ({text}); find the cause and clear the error at the pendant",
                )
            if motor_on and not self._read("@SERVO_ON"):
                self.check(motor_on=False)  # by an error that came after the code was read?
                raise RobotStoppedError(StopReason.PROGRAM_STOPPED, "the motor was switched off")

    def motor_is_on(self) -> bool:
        """Whether the motor is on; RobotStoppedError where the controller does not answer."""
        with told_stops("the motor's state"):
            return bool(self._read("@SERVO_ON"))

    def busy(self) -> bool:
        """Whether the controller says that the arm moves or settles; RobotStoppedError where it does not answer."""
        with told_stops("whether the arm moves"):
            return bool(self._read("@BUSY_STATUS"))

    def _stamped(self) -> tuple[float, Array]:
        if not self.has_clock:
            return time.monotonic(), numbers(self._ask("CurPos"), P_SIZE, "CurPos")
        values = numbers(self._ask("HighCurPosEx"), 1 + P_SIZE, "HighCurPosEx")
        return float(values[0]) / 1000, values[1:]

    def _stale(self, stamp: float) -> str:
        limit = f"within {self._freshness_s:g} s"
        if stamp == self._stamp:
            return f"the controller's clock stands still at {stamp:.3f} s; no fresh pose came {limit}"
        return f"no pose came {limit}: the network or the controller is too slow"

    def _ask(self, command: str) -> Value:
        return self.link.execute(command, deadline_s=self._freshness_s)

    def _read(self, name: str) -> int:
        return self.link.read(name, self._freshness_s)


@contextlib.contextmanager
def told_stops(what: str) -> Iterator[None]:
    """Turns errors of b-CAP into RobotStoppedError: LINK_LOST or CONTROLLER_ERROR; `what` was asked for."""
    try:
        yield
    except (RobotStoppedError, MoveRefusedError):
        raise
    except BcapLinkError as error:
        raise RobotStoppedError(
            StopReason.LINK_LOST, f"{what} is not known ({error}); look at the arm, then at cable and controller"
        ) from error
    except BcapError as error:
        raise RobotStoppedError(StopReason.CONTROLLER_ERROR, f"{what}: {error}") from error
    except RobotError as error:
        raise RobotStoppedError(StopReason.CONTROLLER_ERROR, str(error)) from error
