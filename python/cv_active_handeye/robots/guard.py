# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The only way to move an arm: every move is checked before it begins, and after a stop there is no other.

This guards against mistakes of programs and plans. It is no safety function: those are the controller's own (emergency
stop, safety planes, reduced mode), and the person's beside it.
"""

from __future__ import annotations

from collections.abc import Callable
from types import TracebackType
from typing import Any

from . import kinematics
from .base import Array, MoveRefusedError, Robot, RobotPose, RobotStoppedError, Speed, StopReason
from .workspace import Workspace, check_joints, mm_text

Event = Callable[..., None]
"""Called with the kind of an event and, by keyword, what belongs to it."""


class GuardedRobot:
    """A robot inside of a workspace; leaving the context stops and closes it.

    After a RobotStoppedError, raised here or handed to `give_up`, every further move raises it again.
    """

    def __init__(self, robot: Robot, workspace: Workspace, speed: Speed, event: Event) -> None:
        """`robot` is open; `event` hears of every move before it begins and after it ended."""
        self.robot = robot
        self.workspace = workspace
        self.speed = speed
        self._event = event
        self._stopped: RobotStoppedError | None = None

    @property
    def stopped(self) -> RobotStoppedError | None:
        """Why nothing moves any more, None while it may."""
        return self._stopped

    def pose(self) -> RobotPose:
        """Returns a fresh reading; a robot that gives none is stopped."""
        with self._giving_up():
            return self.robot.pose()

    def is_steady(self) -> bool:
        """Whether the controller says that the arm has come to rest."""
        with self._giving_up():
            return self.robot.is_steady()

    def set_output(self, pin: int, on: bool) -> None:
        """Switches a digital output."""
        self.robot.set_output(pin, on)

    def check_way(self, start: Array, joints: Array | None, end: Array) -> Array | None:
        """Checks the straight way between two flange poses (4, 4) without moving, from `joints` (6,) where known.

        Returns the joints (6,) at its end, None where the arm's geometry is not known. MoveRefusedError otherwise.
        """
        self.workspace.check_path(start, end)
        if joints is None or self.robot.model is None:
            return None
        return check_joints(kinematics.arm(self.robot.model), joints, end)

    def move_to(self, T_gripper2base: Array) -> None:
        """Moves on a straight line to a flange pose (4, 4), in single moves within the caps, each checked anew."""
        self._check_allowed()
        now = self.pose()
        self.check_way(now.T_gripper2base, now.joints, T_gripper2base)
        for pose in self.workspace.way_points(now.T_gripper2base, T_gripper2base):
            self._move(pose)

    def give_up(self, error: RobotStoppedError) -> None:
        """Stops the arm for good: `error` is what every later move says."""
        self.robot.stop()
        if self._stopped is None:
            self._stopped = error
            self._event("stop_condition", reason=error.reason.value, text=str(error))

    def close(self) -> None:
        """Stops and disconnects; never raises."""
        self.robot.close()

    def __enter__(self) -> GuardedRobot:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if isinstance(error, RobotStoppedError):
            self.give_up(error)
        elif isinstance(error, KeyboardInterrupt):
            self.give_up(RobotStoppedError(StopReason.OPERATOR, "interrupted from the keyboard"))
        self.close()

    def _check_allowed(self) -> None:
        if self._stopped is not None:
            raise RobotStoppedError(self._stopped.reason, f"nothing moves after a stop ({self._stopped})")
        if not self.robot.live:
            raise MoveRefusedError(f"{self.robot.name}: was opened to look only; moving needs --live (live=True)")

    def _move(self, pose: Array) -> None:
        self._check_allowed()
        now = self.pose()
        self.workspace.check_step(now.T_gripper2base, pose)
        self.check_way(now.T_gripper2base, now.joints, pose)
        self.robot.check_reachable(pose)
        self._event("move", to_mm=mm_text(pose[:3, 3]))
        with self._giving_up():
            self.robot.move_linear(pose, self.speed)
        self._event("arrived")

    def _giving_up(self) -> _GivingUp:
        return _GivingUp(self)


class _GivingUp:
    """Latches what stops the robot, whatever call it came from."""

    def __init__(self, guard: GuardedRobot) -> None:
        self._guard = guard

    def __enter__(self) -> None:
        return None

    def __exit__(self, kind: Any, error: BaseException | None, trace: Any) -> None:
        if isinstance(error, RobotStoppedError):
            self._guard.give_up(error)
        elif error is not None and not isinstance(error, MoveRefusedError):
            text = str(error) or type(error).__name__
            operator = isinstance(error, KeyboardInterrupt)
            reason = StopReason.OPERATOR if operator else StopReason.CONTROLLER_ERROR
            self._guard.give_up(RobotStoppedError(reason, "interrupted from the keyboard" if operator else text))
