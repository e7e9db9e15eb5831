# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The connection that may move a DENSO arm: takes it, and leaves motor, tool and work frame as they were found."""

from __future__ import annotations

import contextlib

from .base import Array, MoveRefusedError, RobotError, RobotUnavailableError, Speed
from .bcap import PendingCall
from .bcap_packets import Value
from .denso_config import DensoConfig
from .denso_link import DensoLink
from .denso_pose import p_from_matrix, t_from_matrix

LEAST_PERCENT = 0.1
STRAIGHT = 2

_MOTOR_S = 10.0
_CLOSE_S = 0.5


class DensoArm:
    """Arm taken (group 0, tool 0, work 0), slow speed set, then the motor switched on."""

    def __init__(self, config: DensoConfig) -> None:
        """Within 30 s; RobotUnavailableError says which step the controller refused. Nothing moves."""
        self._config = config
        self.link = DensoLink(config.host, config.port, config.controller)
        self._frames: list[str] = []
        self._taken = self._switched_on = False
        try:
            self._remember_frames()
            self.link.execute("TakeArm", [0, 0])
            self._taken = True
            if config.controller == "rc7":
                self.link.change("Tool=0")
                self.link.change("Work=0")
            self._set_speed(config.external_percent, config.external_percent**2 / 100)
            if not self.link.read("@SERVO_ON", deadline_s=2.0):
                self._switched_on = True
                self.link.execute("Motor", [1, 0], deadline_s=_MOTOR_S)
        except RobotError as error:
            self.close(moving=False)
            raise RobotUnavailableError(
                f"{error}. Needs automatic mode, this machine as executable token, and no other client with the arm"
            ) from error

    def prepare(self, speed: Speed) -> Speed:
        """Sets the speed of the next move; returns what it is when 100 % are what the config says.

        External speed = 100 % * commanded / `full_speed_m_s`, at most `external_percent`; acceleration likewise. The
        commanded speed is not exceeded as long as `full_speed_m_s` is not below the arm's true one. MoveRefusedError
        below 0.1 %.
        """
        config = self._config
        percent = min(config.external_percent, 100 * speed.metres_per_second / config.full_speed_m_s)
        if percent < LEAST_PERCENT:
            slowest = LEAST_PERCENT / 100 * config.full_speed_m_s
            raise MoveRefusedError(
                f"speed: needs {slowest:g} m/s or more (external speed {LEAST_PERCENT:g} %), "
                f"given {speed.metres_per_second:g} m/s"
            )
        acceleration = min(100.0, 100 * speed.metres_per_second2 / config.full_acceleration_m_s2)
        self._set_speed(percent, acceleration)
        return Speed(
            metres_per_second=percent / 100 * config.full_speed_m_s,
            metres_per_second2=acceleration / 100 * config.full_acceleration_m_s2,
        )

    def begin(self, T_gripper2base: Array) -> PendingCall:
        """Sends the straight move to a flange pose (4, 4), done when the encoders say so (@E); returns at once."""
        target: Value
        if self._config.controller == "rc7":
            target = "@E P(" + ", ".join(f"{value:.6f}" for value in p_from_matrix(T_gripper2base)) + ")"
        else:
            target = [t_from_matrix(T_gripper2base), "T", "@E"]
        return self.link.begin_move(STRAIGHT, target)

    def close(self, moving: bool) -> list[str]:
        """Restores, gives the arm back and disconnects; never raises. Returns what could not be restored.

        A motor that was off is switched off again, but not while the arm may still be moving.
        """
        steps: list[tuple[str, Value]] = []
        if self._switched_on and not moving:
            steps.append(("Motor", [0, 0]))
        if self._taken:
            steps.append(("GiveArm", None))
        failed = []
        if self._taken and not moving:
            failed += [f"select {name}" for name in self._frames if not self._restored(name)]
        for command, parameter in steps:
            try:
                self.link.execute(command, parameter, deadline_s=_MOTOR_S if command == "Motor" else _CLOSE_S)
            except RobotError:
                failed.append(command)
        self._taken = self._switched_on = False
        self.link.close()
        return failed

    def _restored(self, frame: str) -> bool:
        with contextlib.suppress(RobotError):
            self.link.change(frame)
            return True
        return False

    def _remember_frames(self) -> None:
        """Tool and work frame that are not 0, which TakeArm would leave at 0; RC7 cannot tell."""
        if self._config.controller == "rc7":
            return
        for command, name in (("CurTool", "Tool"), ("CurWork", "Work")):
            number = self.link.execute(command)
            if number != 0:
                self._frames.append(f"{name}{number}")

    def _set_speed(self, percent: float, acceleration: float) -> None:
        self.link.execute("ExtSpeed", [percent, acceleration, acceleration])
