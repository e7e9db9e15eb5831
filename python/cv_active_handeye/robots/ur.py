# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Universal Robots on ur_rtde: the flange is what moves and what is read, the tool centre point is given back after.

ur_rtde is third-party software (MIT), not supported by Universal Robots. It runs in a process of its own (`ur_child`),
so that no call of this file can hang on it; when this program is killed, that process stops the arm.
"""

from __future__ import annotations

import logging
import threading
import time
from types import TracebackType
from typing import Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from . import ur_probe
from .base import Array, MoveRefusedError, RobotError, RobotPose, RobotStoppedError, RobotUnavailableError, Speed
from .base import StopReason as Reason
from .kinematics import ARMS
from .straight_move import StraightMove
from .ur_pose import pose_vector
from .ur_probe import UrFacts
from .ur_process import UrCallError, UrProcess, UrProcessLostError, told
from .ur_tool import UrTool, warn_of_left_tool
from .ur_watch import Freshness, MoveWatch, UrState, check_state
from .workspace import mm_text

_OPEN_S, _CALL_S, _SHORT_S, _LEAVE_S = 6.0, 4.0, 1.0, 8.0
_WATCH_S = 0.01
_STANDSTILL_S, _STANDING_RAD = 1.5, 1e-5
_STOPPED_BY_CONTROLLER = {
    *(Reason.PROTECTIVE_STOP, Reason.EMERGENCY_STOP, Reason.SAFEGUARD_STOP),
    *(Reason.PROGRAM_STOPPED, Reason.CONTROLLER_ERROR),
}
_OUTPUTS = 8
_log = logging.getLogger(__name__)


class UrConfig(BaseModel):
    """A UR controller. model: key of `kinematics.ARMS`, other names (ur20, ...) have no known geometry.

    freshness_s: how long the controller's clock may stand still.
    watchdog_s: how long the controller may hear nothing of us before it stops the arm by itself; None = no watchdog.
    upper_registers: use RTDE registers 24 to 47, where a fieldbus owns those below (PolyScope 3.9 or 5.3, and later).
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    type: Literal["ur"] = "ur"
    host: str = Field(min_length=1)
    model: str = "ur5e"
    freshness_s: float = Field(default=0.2, ge=0.05, le=1.0)
    watchdog_s: float | None = Field(default=1.0, ge=0.2, le=5.0)
    upper_registers: bool = False


class UrRobot:
    """A UR arm. Speaks to one controller; every method may be called from any thread.

    Deadlines, also on a dead link: pose 3 s, check_reachable, is_steady and set_output 5 s, move_linear that of
    `StraightMove` and 10 s to stop, stop 10 s, close 30 s; as much again where another thread's call is in the way.
    """

    def __init__(self, config: UrConfig, facts: UrFacts, process: UrProcess, tool: UrTool | None) -> None:
        """Use `connect`. tool: the tool centre point that shall be active again, None where it was not changed."""
        self.name = f"UR {config.model} at {config.host}"
        self.model = config.model if config.model in ARMS else None
        self.live = tool is not None
        self._config, self._facts, self._process, self._tool = config, facts, process, tool
        self._stopped: RobotStoppedError | None = None
        self._stop_wanted = threading.Event()
        self._moving = threading.Lock()
        self._latch = threading.Lock()
        self._closed = False

    @classmethod
    def connect(cls, config: UrConfig, *, live: bool) -> UrRobot:
        """Connects within 30 s; RobotUnavailableError says what is in the way.

        Without `live` only the stream of poses is opened. With it, ur_rtde's program is started on the controller, and
        the flange becomes the tool centre point until `close`; what it was is on disk before (`ur_tool`).
        """
        facts = ur_probe.usable(config.host, live)
        process = UrProcess(config.host)
        try:
            process.ask("open_receive", deadline=_OPEN_S)
            tool = None
            if live:
                process.ask("open_control", config.upper_registers, deadline=_OPEN_S)
                tool = UrTool.take(process, config.host, config.upper_registers, facts)
            else:
                warn_of_left_tool(config.host, facts)
        except (UrCallError, UrProcessLostError) as error:
            process.finish(_LEAVE_S)
            raise RobotUnavailableError(told(config.host, config.upper_registers, error)) from error
        except BaseException:
            process.finish(_LEAVE_S)
            raise
        return cls(config, facts, process, tool)

    def pose(self) -> RobotPose:
        """Returns a fresh flange pose; RobotStoppedError: STALE_POSE where the controller's clock stands, LINK_LOST."""
        state = self._fresh_state()
        return RobotPose(self._flange(state.pose), state.joints, state.time, time.monotonic())

    def check_reachable(self, T_gripper2base: Array) -> None:
        """Asks the controller's kinematics and safety limits about a pose (4, 4), when live; MoveRefusedError."""
        if not self.live:
            return
        if not self._ask_program("reachable", pose_vector(T_gripper2base)):
            raise MoveRefusedError(
                f"{self.name}: the controller says that the flange cannot be at {mm_text(T_gripper2base[:3, 3])} mm: "
                "out of the arm's reach or of its safety limits"
            )

    def move_linear(self, T_gripper2base: Array, speed: Speed) -> None:
        """Moves the flange on a straight line to a pose (4, 4) and watches it; see `base.Robot.move_linear`."""
        if not self.live:
            raise MoveRefusedError(f"{self.name}: was not opened to be moved (live)")
        with self._moving:
            self._check_latch()
            try:
                self._move(np.asarray(T_gripper2base, dtype=np.float64), speed)
            except RobotStoppedError as error:
                raise self._halted(error) from error.__cause__
            except BaseException as error:
                reason = Reason.OPERATOR if isinstance(error, KeyboardInterrupt) else Reason.CONTROLLER_ERROR
                self._halted(RobotStoppedError(reason, f"the move was ended by {type(error).__name__} {error}"))
                raise

    def is_steady(self) -> bool:
        """Whether the controller says that the arm is at rest; when not live, whether its pose stands for 50 ms."""
        if self.live:
            return self._ask_program("steady")
        first = self._fresh_state()
        time.sleep(0.05)
        return bool(np.abs(self._fresh_state().joints - first.joints).max() < 1e-5)

    def stop(self) -> None:
        """Stops the arm, from any thread; after it the robot has to be connected anew. Raises nothing."""
        self._stop_wanted.set()
        if self.live and not self._closed:
            self._halted(RobotStoppedError(Reason.OPERATOR, "a stop was asked for"))

    def set_output(self, pin: int, on: bool) -> None:
        """Switches a standard digital output (0 to 7) and waits up to 0.5 s until the controller shows it."""
        if not 0 <= pin < _OUTPUTS:
            raise RobotError(f"pin: needs 0 to {_OUTPUTS - 1}, given {pin}")
        if not self._ask("output", pin, on, deadline=_CALL_S):
            raise RobotError(f"{self.name}: the controller refuses to switch output {pin}")
        deadline = time.monotonic() + 0.5
        while bool(self._fresh_state().outputs >> pin & 1) != on:
            if time.monotonic() > deadline:
                raise RobotError(f"{self.name}: output {pin} did not change: is another program or safety in charge")
            time.sleep(_WATCH_S)

    def close(self) -> None:
        """Stops, restores the tool centre point, and disconnects; a tool that could not be restored is logged."""
        if self._closed:
            return
        self._closed = True
        self._stop_wanted.set()
        if self._tool is None or self._tool.give(self._process) is None:
            self._process.finish(_LEAVE_S)
            return
        self._process.kill()
        self._process.finish(_SHORT_S)
        hindered = self._tool.give_anew()
        if hindered is not None:
            _log.error("%s: %s (%s)", self.name, self._tool, hindered)

    def __enter__(self) -> UrRobot:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _move(self, target: Array, speed: Speed) -> None:
        before = self._fresh_state()
        check_state(before, live=True)
        watch = MoveWatch(StraightMove(before.pose, target), speed, time.monotonic(), self._config.freshness_s)
        v, a = speed.metres_per_second, speed.metres_per_second2
        if self._stop_wanted.is_set():
            raise RobotStoppedError(Reason.OPERATOR, "a stop was asked for")
        if not self._ask("move", pose_vector(target), v, a, self._config.watchdog_s, deadline=_CALL_S):
            check_state(self._fresh_state(), live=True)
            raise RobotStoppedError(Reason.CONTROLLER_ERROR, "the controller did not begin the move; see the pendant")
        while not watch.arrived(self._state(), time.monotonic()):
            if self._stop_wanted.wait(_WATCH_S):
                raise RobotStoppedError(Reason.OPERATOR, "a stop was asked for")

    def _halted(self, error: RobotStoppedError) -> RobotStoppedError:
        """Stops the arm by all means there are; returns the first reason, which is kept."""
        with self._latch:
            if self._stopped is not None and not self._process.alive:
                return self._stopped
            error = self._stopped = self._stopped or error
        if not self._brought_to_rest(error.reason):
            self._process.kill()
            told = ur_probe.stop_without_rtde(self._config.host, self._facts)
            how = "was told to stop by another way" if told else "COULD NOT BE TOLD TO STOP: press the emergency stop"
            self._stopped = RobotStoppedError(error.reason, f"{_text(error)}; the arm {how}. {self._tool}")
        return self._stopped

    def _brought_to_rest(self, reason: Reason) -> bool:
        """Stops the arm where the controller has not done so by itself; whether it was seen to stand."""
        if reason is Reason.LINK_LOST:
            return False
        try:
            if reason not in _STOPPED_BY_CONTROLLER:
                self._process.ask("stop", deadline=_SHORT_S)
            deadline, last = time.monotonic() + _STANDSTILL_S, self._state()
            while time.monotonic() < deadline:
                time.sleep(2 * _WATCH_S)
                state = self._state()
                fresh = state.connected and state.time != last.time
                if fresh and np.abs(state.joints - last.joints).max() < _STANDING_RAD:
                    return True
                last = state
        except (UrCallError, UrProcessLostError, RobotError):
            pass  # told by the caller
        return False

    def _fresh_state(self) -> UrState:
        """A package that arrived after this call began."""
        first = self._state()
        fresh = Freshness(self._config.freshness_s)
        fresh.check(first, time.monotonic())
        while True:
            state = self._state()
            if not state.connected:
                raise RobotStoppedError(Reason.LINK_LOST, f"{self.name}: the controller closed the connection")
            if state.time != first.time:
                return state
            fresh.check(state, time.monotonic())
            time.sleep(0.002)

    def _state(self) -> UrState:
        return UrState.of(self._ask("state", deadline=_SHORT_S))

    def _ask(self, call: str, *arguments: object, deadline: float) -> Any:
        try:
            return self._process.ask(call, *arguments, deadline=deadline)
        except UrProcessLostError as error:
            raise RobotStoppedError(Reason.LINK_LOST, f"{self.name}: {error}; check cable and network") from error
        except UrCallError as error:
            raise RobotError(f"{self.name}: {call}: {error}") from error

    def _ask_program(self, call: str, *arguments: object) -> bool:
        """An answer of our program on the controller, believed only while that runs and the link stands.

        ur_rtde connects anew by itself where only the link was cut, and answers then.
        """
        self._check_latch()
        answer = bool(self._ask(call, *arguments, deadline=_CALL_S))
        try:
            check_state(self._fresh_state(), live=True)
        except RobotStoppedError as error:
            raise self._halted(error) from error.__cause__
        return answer

    def _check_latch(self) -> None:
        """RobotStoppedError where the arm was stopped before."""
        if self._stopped is not None:
            raise self._stopped

    def _flange(self, T_tcp2base: Array) -> Array:
        if self.live or self._facts.T_tcp2flange is None:
            return T_tcp2base
        return np.asarray(T_tcp2base @ np.linalg.inv(self._facts.T_tcp2flange))


def connect(config: UrConfig, *, live: bool) -> UrRobot:
    """See `UrRobot.connect`."""
    return UrRobot.connect(config, live=live)


def _text(error: RobotStoppedError) -> str:
    return str(error).removeprefix(f"{error.reason.value}: ")
