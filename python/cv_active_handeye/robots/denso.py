# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""DENSO arms with RC8, RC8A or RC9 (RC7: experimental) over b-CAP, by two connections: one moves, one watches.

The second one halts: a connection takes no other call while its motion goes on. Opened with `live=False` there is only
the one that watches, no arm is taken and no motor switched on.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import TracebackType

import numpy as np

from .base import (
    Array,
    MoveRefusedError,
    RobotError,
    RobotPose,
    RobotStoppedError,
    RobotUnavailableError,
    Speed,
    StopReason,
)
from .bcap import BcapError, BcapLinkError, PendingCall
from .denso_arm import DensoArm
from .denso_check import check_convention, check_convention_by_model, check_flange
from .denso_config import DensoConfig
from .denso_link import DensoLink, halt_anew
from .denso_pose import p_from_matrix
from .denso_watch import DensoWatch, told_stops
from .straight_move import StraightMove

__all__ = ["DensoConfig", "DensoRobot", "connect"]

_POLL_S = 0.01
_HALT_S, _HALTED_S, _ARRIVAL_S = 0.5, 2.0, 1.0
_CLOSE_WAIT_S = 12.0  # for a move of another thread to be halted, over a new connection if need be
_SPEED_WINDOW_S = 0.1
_SPEED_FACTOR, _SPEED_EXTRA_M_S = 1.25, 0.01

_log = logging.getLogger(__name__)


def connect(config: DensoConfig, *, live: bool) -> DensoRobot:
    """Opens the robot within 60 s; RobotUnavailableError says what is missing and what to do about it.

    The controller is asked what its angles mean before anything is believed. live: whether it may be moved; needs
    automatic mode, no error, no emergency stop, and nobody else with the arm.
    """
    link = DensoLink(config.host, config.port, config.controller)
    arm: DensoArm | None = None
    try:
        watch = DensoWatch(link, config.controller, config.freshness_s)
        if live:
            watch.check(motor_on=False)
            arm = DensoArm(config)
        if config.controller == "rc7" and config.model is not None:
            check_convention_by_model(link, config.model)
        else:
            check_flange(link)
            check_convention(link)
        watch.pose()
    except BaseException as error:
        if arm is not None:
            arm.close(moving=False)
        link.close()
        if isinstance(error, RobotError) and not isinstance(error, RobotUnavailableError):
            raise RobotUnavailableError(f"DENSO at {config.host}:{config.port}: {error}") from error
        raise
    return DensoRobot(config, watch, arm)


class DensoRobot:
    """`robots.base.Robot` for DENSO; see `connect`. A stop of any kind is final until somebody connects anew."""

    def __init__(self, config: DensoConfig, watch: DensoWatch, arm: DensoArm | None) -> None:
        self.name = f"DENSO {config.controller.upper()} at {config.host}:{config.port}"
        self.model = config.model
        self.live = arm is not None
        self._config, self._watch, self._arm = config, watch, arm
        self._moves = threading.Lock()
        self._pending: PendingCall | None = None
        self._stopped: RobotStoppedError | None = None
        self._closed = False

    def pose(self) -> RobotPose:
        """See `Robot.pose`; within three times the freshness limit."""
        with self._final():
            return self._watch.pose()

    def check_reachable(self, T_gripper2base: Array) -> None:
        """Asks OutRange within 2 s: MoveRefusedError where the pose (4, 4) is out of range; RC7 cannot tell."""
        if self._config.controller == "rc7":
            return
        with self._final(), told_stops("OutRange"):
            answer = self._watch.link.execute("OutRange", [[p_from_matrix(T_gripper2base), "P"], 0, 0])
        if answer != 0:
            where = ", ".join(f"{1000 * value:.0f}" for value in T_gripper2base[:3, 3])
            raise MoveRefusedError(f"{self.name}: the flange pose at ({where}) mm is out of range (OutRange: {answer})")

    def move_linear(self, T_gripper2base: Array, speed: Speed) -> None:
        """See `Robot.move_linear`; deadline: `StraightMove.deadline_s`, and 9 s for stopping on a dead link."""
        if self._arm is None:
            raise MoveRefusedError(f"{self.name}: was not opened to be moved (live)")
        if not self._moves.acquire(blocking=False):
            raise MoveRefusedError(f"{self.name}: another move is under way")
        try:
            self._refuse_after_stop()
            try:
                self._move(self._arm, np.asarray(T_gripper2base, np.float64), speed)
            except MoveRefusedError:
                raise
            except BaseException as error:
                stop = self._as_stop(error)
                self._stopped = self._with_halt(self._stopped or stop)
                raise self._stopped from error
        finally:
            self._moves.release()

    def is_steady(self) -> bool:
        """See `Robot.is_steady`: not BUSY, within the freshness limit."""
        with self._final():
            return not self._watch.busy()

    def stop(self) -> None:
        """See `Robot.stop`: halts over the connection that watches, else over a new one; 7 s at the most."""
        if self._stopped is None:
            self._stopped = RobotStoppedError(StopReason.OPERATOR, "stopped by this program's user; connect anew")
        if self.live and not self._closed:
            self._halt()

    def set_output(self, pin: int, on: bool) -> None:
        """Switches IO[pin], within 6 s; RobotError where it does not exist or the robot is not live."""
        if self._arm is None:
            raise RobotError(f"{self.name}: outputs are only switched when it was opened live")
        try:
            self._watch.link.write(f"IO[{pin}]", on)
        except BcapError as error:
            raise RobotError(f"{self.name}: output {pin} cannot be switched: {error}") from error
        except BcapLinkError as error:
            with self._final():
                raise RobotStoppedError(StopReason.LINK_LOST, f"output {pin} may be on or off: {error}") from error

    def close(self) -> None:
        """See `Robot.close`; within 25 s."""
        if self._closed:
            return
        if self._moves.locked():
            self.stop()
        free = self._moves.acquire(timeout=_CLOSE_WAIT_S)
        self._closed = True
        try:
            self._restore(moving=not free or self._pending is not None)
        finally:
            if free:
                self._moves.release()

    def __enter__(self) -> DensoRobot:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _restore(self, moving: bool) -> None:
        if self._arm is not None:
            failed = self._arm.close(moving)
            if failed:
                _log.warning("%s: could not be restored, do it at the pendant: %s", self.name, ", ".join(failed))
        self._watch.link.close()

    @contextmanager
    def _final(self) -> Iterator[None]:
        """Whatever stops in here stops for good."""
        try:
            yield
        except RobotStoppedError as error:
            self._stopped = self._stopped or error
            raise

    def _refuse_after_stop(self) -> None:
        if self._closed:
            raise MoveRefusedError(f"{self.name}: was closed")
        if self._stopped is not None:
            raise self._stopped

    def _move(self, arm: DensoArm, target: Array, speed: Speed) -> None:
        self._watch.check(motor_on=True)
        self.check_reachable(target)
        with told_stops("the speed"):
            actual = arm.prepare(speed)
        self._watch.check(motor_on=True)  # again, for these calls took a while
        self._watch.pose()
        start = self._watch.pose()  # the second one tells that the clock goes on
        move = StraightMove(start.T_gripper2base, target)
        deadline = time.monotonic() + move.deadline_s(actual.metres_per_second, actual.metres_per_second2)
        self._refuse_after_stop()
        with told_stops("the motion"):
            self._pending = arm.begin(target)
            self._follow(move, self._pending, deadline, speed, start)
            self._finish(arm, self._pending)
        self._arrive(move, min(deadline, time.monotonic() + _ARRIVAL_S))

    def _follow(self, move: StraightMove, pending: PendingCall, deadline: float, speed: Speed, last: RobotPose) -> None:
        """Watches until the motion's call has its answer."""
        while not pending.poll(_POLL_S):
            if self._stopped is not None:
                raise self._stopped
            now = self._watch.pose()
            wrong = move.off_path(now.T_gripper2base)
            if wrong is None and now.controller_time - last.controller_time >= _SPEED_WINDOW_S:
                wrong, last = self._too_fast(last, now, speed), now
            if wrong is not None:
                raise RobotStoppedError(StopReason.OFF_PATH, wrong)
            self._watch.check(motor_on=True)
            if time.monotonic() > deadline:
                raise RobotStoppedError(StopReason.DEADLINE, "the move takes far longer than its length and speed say")

    def _too_fast(self, last: RobotPose, now: RobotPose, speed: Speed) -> str | None:
        """Says so where the flange is faster than commanded; without a controller's clock nobody can tell."""
        if not self._watch.has_clock:
            return None
        way = np.linalg.norm(now.T_gripper2base[:3, 3] - last.T_gripper2base[:3, 3])
        is_speed = float(way) / (now.controller_time - last.controller_time)
        allowed = _SPEED_FACTOR * speed.metres_per_second + _SPEED_EXTRA_M_S
        if is_speed <= allowed:
            return None
        return (
            f"the flange moves at {is_speed:.3f} m/s, {speed.metres_per_second:g} m/s were commanded: "
            f"full_speed_m_s = {self._config.full_speed_m_s:g} is too small for this arm"
        )

    def _finish(self, arm: DensoArm, pending: PendingCall) -> None:
        try:
            pending.result(0.0)
        except BcapError as error:
            self._pending = None
            if self._stopped is not None:
                raise self._stopped from error
            self._watch.check(motor_on=True)
            raise arm.link.described(error) from error
        self._pending = None

    def _arrive(self, move: StraightMove, deadline: float) -> None:
        while (remaining := move.remaining(self._watch.pose().T_gripper2base)) is not None:
            if self._stopped is not None:
                raise self._stopped
            if time.monotonic() > deadline:
                self._watch.check(motor_on=True)
                raise RobotStoppedError(StopReason.NOT_ARRIVED, f"the controller says done, but the arm is {remaining}")
            time.sleep(_POLL_S)

    @staticmethod
    def _as_stop(error: BaseException) -> RobotStoppedError:
        if isinstance(error, RobotStoppedError):
            return error
        if isinstance(error, KeyboardInterrupt):
            return RobotStoppedError(StopReason.OPERATOR, "interrupted; connect anew")
        return RobotStoppedError(StopReason.CONTROLLER_ERROR, f"{type(error).__name__}: {error}")

    def _with_halt(self, stop: RobotStoppedError) -> RobotStoppedError:
        """Halts what is under way; the same stop, with a warning where the arm may still be moving."""
        if self._pending is None or self._halted(self._pending):
            return stop
        text = str(stop).removeprefix(f"{stop.reason.value}: ")
        return RobotStoppedError(stop.reason, f"{text}. THE ARM COULD NOT BE HALTED AND MAY STILL MOVE")

    def _halted(self, pending: PendingCall) -> bool:
        """Halts and waits for the motion's call to end, 2 s at the most; whether the controller confirmed either."""
        confirmed = self._halt()
        try:
            if not pending.poll(_HALTED_S):
                pending.give_up(f"did not end within {_HALTED_S:g} s after the halt")
            confirmed = True
        except BcapLinkError as error:
            _log.warning("%s", error)
        if confirmed:
            self._pending = None
        return confirmed

    def _halt(self) -> bool:
        """Whether the controller took the halt: over the link that watches, else over a new one."""
        try:
            self._watch.link.halt(_HALT_S)
            return True
        except RobotError as error:
            _log.warning("halt: %s; trying a new connection", error)
        try:
            halt_anew(self._config.host, self._config.port, self._config.controller)
            return True
        except RobotError as error:
            _log.error("halt: %s", error)
            return False
