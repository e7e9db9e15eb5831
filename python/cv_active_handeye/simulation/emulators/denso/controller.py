# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The state of the emulated controller, shared by all its connections."""

from __future__ import annotations

import threading

import numpy as np

from ....robots.base import Array
from ....robots.bcap_codes import Result
from ....robots.denso_watch import AUTO_MODE
from ..arm import EmulatedArm, EmulatorStop
from .errors import ARM_NOT_TAKEN, MOTOR_OFF, NOT_AUTOMATIC, OUT_OF_RANGE, STOPPED, Refusal, invalid, signed
from .profiles import Profile
from .targets import Target

FULL_SPEED, FULL_ACCELERATION = 10.0, 50.0
"""Of the flange at 100 %, m/s and m/s^2."""
FULL_JOINT_SPEED, FULL_JOINT_ACCELERATION = np.radians(300.0), np.radians(1500.0)

_MANUAL = 1
_TOOL_MM = 10.0  # length of tool n is n times this


class DensoController:
    """Who has the arm, motor, speed, frames, mode and errors. Thread-safe."""

    def __init__(self, arm: EmulatedArm, profile: Profile, convention: str, tool: int) -> None:
        """See `DensoEmulator`."""
        self.arm, self.profile, self.convention = arm, profile, convention
        self.external = (100.0, 100.0)
        self.internal_percent = 100.0
        self.tool, self.work = tool, 0
        self._lock = threading.RLock()
        self._owner: object | None = None
        self._motor = self._speed_set = False
        self._error, self._error_clears = 0, 0
        self._cancel = threading.Event()
        self._frozen: tuple[float, Array] | None = None

    def take_arm(self, client: object, keep: bool) -> None:
        """Gives the arm to a client; without `keep` speed, tool and work frame go to their first values."""
        self.require_running()
        with self._lock:
            if self._owner not in (None, client):
                raise Refusal(Result.E_ACCESSDENIED)
            self._owner, self._speed_set = client, False
            if not keep:
                self.internal_percent, self.tool, self.work = 100.0, 0, 0

    def give_arm(self, client: object) -> None:
        """Takes the arm back; a motion of this client ends."""
        with self._lock:
            if self._owner is client:
                self._owner = None
                self._cancel.set()

    def set_external(self, client: object, percent: float, acceleration: float) -> None:
        """External speed and acceleration, percent."""
        self.require_arm(client)
        if not (0.1 <= percent <= 100 and 0.0001 <= acceleration <= 100):
            raise Refusal(Result.E_INVALIDARG, f"ExtSpeed {percent:g}, {acceleration:g} is out of range")
        with self._lock:
            self.external, self._speed_set = (percent, acceleration), True

    def set_motor(self, client: object, on: bool) -> None:
        """Switches the motor; a client that did not set the speed before has erred, although it is obeyed."""
        self.require_arm(client)
        if on:
            self.require_running()
            if not self._speed_set:
                self.arm.log.add("violation", text="Motor before ExtSpeed: the speed is whatever was left")
        with self._lock:
            self._motor = on

    @property
    def motor(self) -> bool:
        """Whether the motor has power."""
        return self._motor and self.arm.stop_condition is None

    @property
    def mode(self) -> int:
        """1 = manual, 3 = automatic."""
        return _MANUAL if self.arm.faults.value("not_remote") else AUTO_MODE

    @property
    def error_code(self) -> int:
        """The last error as a signed integer, 0 = none."""
        condition = self.arm.stop_condition
        if condition is not None:
            return signed(STOPPED[condition])
        with self._lock:
            return signed(self._error) if self._error_clears == self.arm.clears else 0

    def clear_errors(self) -> None:
        """ClearError; what a person has to clear stays."""
        with self._lock:
            self._error = 0

    def cut_motor(self) -> None:
        """Power goes off and has to be switched on again."""
        with self._lock:
            self._motor = False

    def reading(self) -> tuple[float, Array, Array]:
        """Clock (s), pose (4, 4) of the active tool, joints (6,), as the controller says them."""
        if self.arm.faults.value("frozen_timestamp"):
            self._frozen = self._frozen or (self.arm.now, self.arm.reported_pose())
            return self._frozen[0], self._frozen[1] @ self._tool_frame(), self.arm.joints
        self._frozen = None
        if self.arm.faults.value("nan_pose"):
            return self.arm.now, np.full((4, 4), np.nan), self.arm.joints
        return self.arm.now, self.arm.reported_pose() @ self._tool_frame(), self.arm.joints

    def flange_target(self, target: Target) -> Array:
        """The flange pose (4, 4) that brings the active tool to a P- or T-type target."""
        return np.asarray(target.matrix() @ np.linalg.inv(self._tool_frame()))

    def expect_motion(self) -> None:
        """A motion is about to be worked on: a halt from now on is meant for it."""
        self._cancel.clear()

    def move(self, client: object, straight: bool, target: Target, percent: float) -> None:
        """Moves and returns on arrival; Refusal otherwise."""
        if self.arm.stop_condition is None:  # else the arm refuses, and logs that it was asked
            self.require_arm(client)
            self.require_running()
            if not self._motor:
                raise Refusal(MOTOR_OFF, "a motion was asked for with the motor off")
        share, harder = self.external[0] / 100 * percent / 100 * self.internal_percent / 100, self.external[1] / 100
        try:
            if straight and target.kind != "J":
                pose = self.flange_target(target)
                self.arm.move_linear(pose, share * FULL_SPEED, harder * FULL_ACCELERATION, self._cancel)
            else:
                speed, acceleration = share * FULL_JOINT_SPEED, harder * FULL_JOINT_ACCELERATION
                self.arm.move_joints(self.joints_of(target), speed, acceleration, self._cancel)
        except EmulatorStop as stop:
            raise self._ended(stop) from stop

    def joints_of(self, target: Target) -> Array:
        """Joints (6,), rad, of a target; Refusal where there are none."""
        if target.kind == "J":
            return np.radians(target.values[:6])
        try:
            return self.arm.arm.inverse(self.flange_target(target), self.arm.joints)
        except ValueError as error:
            raise Refusal(OUT_OF_RANGE) from error

    def change_frame(self, client: object, name: str) -> None:
        """Selects a tool or work frame by its name."""
        self.require_arm(client)
        for number in range(64):
            tool, work = (syntax.format(number) for syntax in self.profile.frame_syntax)
            if name.lower() == tool.lower():
                self.tool = number
                return
            if name.lower() == work.lower():
                self.work = number
                return
        raise invalid(f"Robot_Change: needs a tool or work frame as {tool} or {work}, got {name!r:.40}")

    def halt(self) -> None:
        """Ends the motion under way."""
        self._cancel.set()

    def require_arm(self, client: object) -> None:
        """Refusal where the arm is not this client's."""
        if self._owner is not client:
            raise Refusal(ARM_NOT_TAKEN, "a command that needs the arm came without TakeArm")

    def require_running(self) -> None:
        """Refusal where the mode or an error forbids motion."""
        if self.error_code:
            raise Refusal(self.error_code & 0xFFFFFFFF)
        if self.mode != AUTO_MODE:
            raise Refusal(NOT_AUTOMATIC)

    def _ended(self, stop: EmulatorStop) -> Refusal:
        if stop.reason == "cancelled":
            return Refusal(Result.E_ABORT)
        if stop.reason in STOPPED:
            return Refusal(STOPPED[stop.reason])
        with self._lock:
            self._error, self._error_clears = OUT_OF_RANGE, self.arm.clears
        return Refusal(OUT_OF_RANGE)

    def _tool_frame(self) -> Array:
        frame = np.eye(4)
        frame[2, 3] = self.tool * _TOOL_MM / 1000
        return frame
