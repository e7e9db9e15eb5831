# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The control program that ur_rtde uploads: its main loop, which obeys the registers, without reading URScript.

The client writes a command's number into input_int_register_0; the program answers in output_int_register_0 (READY,
DONE), 1 (an integer), 2 (progress of an asynchronous motion) and output_double_register_0 to 5 (a vector). Upper-range
registers: the same from register 24 on.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from ....robots.kinematics import UnreachableError
from ....robots.ur_pose import pose_matrix, pose_vector
from ..arm import EmulatorStop
from .registers import DONE, READY
from .watchdog import Watchdogs

if TYPE_CHECKING:
    from .controller import UrController

MOVE_J, MOVE_L, SET_TCP, STOP_L, STOP_J, SET_WATCHDOG = 1, 3, 29, 33, 34, 35
STOP_SCRIPT, NONE = 255, 0
MOTIONS = {1, 2, 3, 4, 45}
NAMES = {
    0: "none",
    1: "moveJ",
    3: "moveL",
    26: "getStepTime",
    29: "setTcp",
    30: "getInverseKinematics",
    33: "stopL",
    34: "stopJ",
    35: "setWatchdog",
    36: "isPoseWithinSafetyLimits",
    37: "isJointsWithinSafetyLimits",
    40: "getTCPOffset",
    43: "getForwardKinematics",
    46: "getInverseKinematics",
    47: "isSteady",
    58: "getActualToolFlangePose",
    60: "getInverseKinematicsHasSolution",
    61: "getInverseKinematicsHasSolution",
    STOP_SCRIPT: "stopScript",
}
"""Commands this program knows."""

_WITHOUT_HANDSHAKE = {6, 9, 10, 11, 24, 25, 26, 27, 38, 58, 66, 67, 68, 69, 70, 71}
_POLL = 0.02  # s between looks at the stop conditions
_START_S = 0.1  # as a controller, which has taken the registers that were sent before the program by then
_RUNNING = 0x8000  # bit of output_int_register_2 while an asynchronous motion is under way


class ControlProgram:
    """One run of the program, in a thread of its own, until it is stopped, a client ends it, or the arm stops."""

    def __init__(self, controller: UrController, offset: int) -> None:
        """Begins at once; `offset`: 0, or 24 with upper-range registers."""
        self._controller, self._offset = controller, offset
        self._registers, self._arm = controller.registers, controller.arm
        self._end = threading.Event()
        self._halt = threading.Event()
        self._motion: threading.Thread | None = None
        self._watchdogs = Watchdogs(self._registers, self._not_heard)
        self._executing = NONE
        self._operation, self._writes = 0, 0
        self._tell_progress(running=False)
        self._registers.set_int(offset, NONE)
        self._thread = threading.Thread(target=self._loop, name="UR program", daemon=True)
        self._thread.start()

    @property
    def running(self) -> bool:
        """Whether it still obeys."""
        return self._thread.is_alive() and not self._end.is_set()

    @property
    def offset(self) -> int:
        """Of its registers."""
        return self._offset

    @property
    def executing(self) -> int:
        """The command that is under way or was not acknowledged by the client, else 0."""
        return self._executing

    def end(self) -> None:
        """Lets no further motion begin and ends the one under way, without waiting for that."""
        self._end.set()
        self._halt.set()
        self._watchdogs.end()

    def stop(self) -> None:
        """Ends it and the motion that it began; returns when both have ended."""
        self.end()
        for thread in (self._thread, self._motion):
            if thread is not None and thread is not threading.current_thread():
                thread.join(5.0)
        self._watchdogs.join()

    def _loop(self) -> None:
        try:
            if self._arm.stop_condition is None:
                self._end.wait(_START_S)
                self._registers.set_int(self._offset, READY)
            while not self._end.is_set() and self._arm.stop_condition is None:
                if not self._step(self._registers.ints(self._offset)[0]):
                    break
                with self._registers.changed:
                    if self._registers.ints(self._offset)[0] in (NONE, self._executing):
                        self._registers.changed.wait(_POLL)
        except EmulatorStop as stop:
            self._controller.tell_stop(stop)
        finally:
            self.end()

    def _step(self, command: int) -> bool:
        """One turn of the main loop; False when the client ends the program."""
        if command in _WITHOUT_HANDSHAKE:
            self._obey(command)
            self._registers.set_int(self._offset, READY)
        elif command == NONE:
            self._executing = NONE
            self._registers.set_int(self._offset, READY)
        elif self._executing == NONE:
            if command == STOP_SCRIPT:
                return False
            self._executing = command
            self._obey(command)
            self._registers.set_int(self._offset, DONE)
        return True

    def _obey(self, command: int) -> None:
        actions: dict[int, Callable[[list[float], list[int]], None]] = {
            MOVE_J: lambda d, n: self._move(True, d, n),
            MOVE_L: lambda d, n: self._move(False, d, n),
            STOP_L: lambda d, n: self._stop_motion(d[0]),
            STOP_J: lambda d, n: self._stop_motion(d[0]),
            SET_TCP: lambda d, n: self._set_tcp(d),
            SET_WATCHDOG: lambda d, n: self._watchdogs.set(f"input_int_register_{self._offset}", d[0]),
            26: lambda d, n: self._registers.set_doubles(self._offset, [0.002]),
            30: lambda d, n: self._inverse(d, np.array(d[6:12])),
            36: lambda d, n: self._answer(self._reachable(d)),
            37: lambda d, n: self._answer(bool((np.abs(d[:6]) <= 2 * np.pi).all())),
            40: lambda d, n: self._answer_vector(self._controller.T_tcp2flange),
            43: lambda d, n: self._answer_vector(self._controller.tcp_pose()),
            46: lambda d, n: self._inverse(d, self._arm.joints),
            47: lambda d, n: self._answer(self._arm.steady()),
            58: lambda d, n: self._answer_vector(self._arm.reported_pose()),
            60: lambda d, n: self._answer(self._reachable(d)),
            61: lambda d, n: self._answer(self._reachable(d)),
        }
        if command not in actions:
            self._arm.log.add("violation", text=f"command {command} is not known to this emulator")
            return
        try:
            actions[command](self._registers.doubles(self._offset), self._registers.ints(self._offset))
        except (UnreachableError, ValueError) as error:
            raise EmulatorStop("unreachable", str(error)) from error

    def _move(self, joints: bool, d: list[float], n: list[int]) -> None:
        self._stop_motion(self._arm.halt_deceleration)
        self._halt = threading.Event()
        if self._end.is_set():
            self._halt.set()
        if n[1] == 1:
            self._motion = threading.Thread(target=self._move_apart, args=(joints, d), name="UR motion", daemon=True)
            self._operation = (self._operation + 1) % 128
            self._tell_progress(running=True)
            self._motion.start()
        else:
            self._move_now(joints, d)

    def _move_apart(self, joints: bool, d: list[float]) -> None:
        try:
            self._move_now(joints, d)
        except EmulatorStop as stop:
            if stop.reason != "cancelled":
                self._end.set()
                self._controller.tell_stop(stop)
        self._tell_progress(running=False)

    def _move_now(self, joints: bool, d: list[float]) -> None:
        if joints:
            self._arm.move_joints(np.array(d[:6]), d[6], d[7], self._halt)
        else:
            self._arm.move_linear(self._flange(d), d[6], d[7], self._halt)

    def _stop_motion(self, deceleration: float) -> None:
        if self._motion is not None:
            self._arm.halt_deceleration = float(np.clip(deceleration, 0.1, 100.0))
            self._halt.set()
            self._motion.join(5.0)
            self._motion = None

    def _not_heard(self, variable: str, limit: float) -> None:
        text = f"no package with {variable} came for {limit:g} s"
        self._arm.log.add("stop_condition", reason="watchdog", text=text)
        self.end()

    def _set_tcp(self, d: list[float]) -> None:
        self._controller.T_tcp2flange = pose_matrix(d[:6])

    def _flange(self, d: list[float]) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        return np.asarray(pose_matrix(d[:6]) @ np.linalg.inv(self._controller.T_tcp2flange))

    def _reachable(self, d: list[float]) -> bool:
        return self._arm.reachable(self._flange(d))

    def _inverse(self, d: list[float], near: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> None:
        self._registers.set_doubles(self._offset, list(self._arm.arm.inverse(self._flange(d), near)))

    def _answer(self, yes: bool) -> None:
        self._registers.set_int(self._offset + 1, int(yes))

    def _answer_vector(self, T: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> None:
        self._registers.set_doubles(self._offset, pose_vector(T))

    def _tell_progress(self, running: bool) -> None:
        self._writes = (self._writes + 1) % 128
        word = self._operation << 24 | self._writes << 16 | (_RUNNING if running else 0)
        self._registers.set_int(self._offset + 2, word)
