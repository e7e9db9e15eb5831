# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""One b-CAP connection with the controller and robot objects that live on it."""

from __future__ import annotations

import contextlib
from typing import Literal

from .base import RobotError, RobotUnavailableError
from .bcap import BcapClient, BcapError, BcapLinkError, PendingCall
from .bcap_codes import Function, result_meaning
from .bcap_packets import Value

Controller = Literal["rc8", "rc9", "rc7"]

PROVIDERS: dict[Controller, str] = {
    "rc8": "CaoProv.DENSO.VRC",
    "rc9": "CaoProv.DENSO.VRC9",
    "rc7": "CaoProv.DENSO.NetwoRC",
}
CONTROLLER_VARIABLES = ("@MODE", "@ERROR_CODE", "@EMERGENCY_STOP")
ROBOT_VARIABLES = ("@SERVO_ON", "@BUSY_STATUS")

_CLOSE_S = 0.5


class DensoLink:
    """Service started, controller connected, robot "Arm" opened. `close` undoes it in reverse order.

    Every call ends within its deadline: BcapError where the controller refuses (with the controller's own text),
    BcapLinkError where the link fails.
    """

    def __init__(self, host: str, port: int, controller: Controller) -> None:
        """Connects within 8 s; RobotUnavailableError says which step failed."""
        try:
            self.client = BcapClient(host, port)
        except RobotError as error:
            raise RobotUnavailableError(
                f"{error}. Check the cable, the address, and that b-CAP is on (port {port})"
            ) from error
        self._controller = self._robot = 0
        self._variables: dict[str, int] = {}
        try:
            connected = self.client.call(Function.CONTROLLER_CONNECT, "", PROVIDERS[controller], "localhost", "")
            self._controller = _handle(connected, "CONTROLLER_CONNECT")
            robot = self.client.call(Function.CONTROLLER_GET_ROBOT, self._controller, "Arm", "")
            self._robot = _handle(robot, "CONTROLLER_GET_ROBOT")
            for name in CONTROLLER_VARIABLES:
                self._variables[name] = self.variable(name)
            for name in ROBOT_VARIABLES:
                answer = self.client.call(Function.ROBOT_GET_VARIABLE, self._robot, name, "")
                self._variables[name] = _handle(answer, name)
        except RobotError as error:
            self.close()
            raise RobotUnavailableError(f"{error}. Is it a {controller.upper()} (`controller`)?") from error

    def variable(self, name: str) -> int:
        """The handle of a controller variable."""
        return _handle(self.client.call(Function.CONTROLLER_GET_VARIABLE, self._controller, name, ""), name)

    def read(self, name: str, deadline_s: float) -> int:
        """An integer or Boolean out of CONTROLLER_VARIABLES and ROBOT_VARIABLES."""
        value = self.client.call(Function.VARIABLE_GET_VALUE, self._variables[name], deadline_s=deadline_s)
        if not isinstance(value, int):
            raise RobotError(f"{name}: needs an integer or Boolean, the controller gave {value!r}")
        return int(value)

    def write(self, name: str, value: Value) -> None:
        """Sets a controller variable, within 2 s a step."""
        handle = self.variable(name)
        try:
            self.client.call(Function.VARIABLE_PUT_VALUE, handle, value)
        finally:
            self.client.call(Function.VARIABLE_RELEASE, handle)

    def execute(self, command: str, parameter: Value = None, deadline_s: float = 2.0) -> Value:
        """A command of the robot object; a refusal comes with the controller's own text."""
        try:
            return self.client.call(Function.ROBOT_EXECUTE, self._robot, command, parameter, deadline_s=deadline_s)
        except BcapError as error:
            raise self.described(error) from error

    def described(self, error: BcapError) -> BcapError:
        """The same error with the controller's own text, where it has to be asked and answers within 0.5 s."""
        if result_meaning(error.code):
            return error
        return BcapError(error.code, error.what, self.describe(error.code))

    def describe(self, code: int) -> str:
        """The controller's text for an HRESULT, empty where it has none or does not answer within 0.5 s."""
        signed = code - (1 << 32) if code >= 1 << 31 else code
        with contextlib.suppress(BcapError, BcapLinkError):
            text = self.client.call(
                Function.CONTROLLER_EXECUTE, self._controller, "GetErrorDescription", signed, deadline_s=_CLOSE_S
            )
            return text if isinstance(text, str) else ""
        return ""

    def begin_move(self, interpolation: int, pose: Value) -> PendingCall:
        """Sends Robot_Move (2 = straight line) and returns at once; the link takes no other call until it has ended."""
        return self.client.begin(Function.ROBOT_MOVE, self._robot, interpolation, pose, "")

    def change(self, name: str) -> None:
        """Selects a tool or work frame, "Tool0" (RC7: "Tool=0") for example."""
        self.client.call(Function.ROBOT_CHANGE, self._robot, name)

    def halt(self, deadline_s: float) -> None:
        """Stops the motion, whoever began it."""
        self.client.call(Function.ROBOT_HALT, self._robot, "", deadline_s=deadline_s)

    def close(self) -> None:
        """Releases what was opened, in reverse order, each step within 0.5 s; stops at a dead link; never raises."""
        steps: list[tuple[Function, int]] = [(Function.VARIABLE_RELEASE, handle) for handle in self._variables.values()]
        if self._robot:
            steps.append((Function.ROBOT_RELEASE, self._robot))
        if self._controller:
            steps.append((Function.CONTROLLER_DISCONNECT, self._controller))
        self._variables, self._robot, self._controller = {}, 0, 0
        for function, handle in steps:
            if self.client.closed:
                break
            with contextlib.suppress(RobotError):
                self.client.call(function, handle, deadline_s=_CLOSE_S)
        self.client.close()


def halt_anew(host: str, port: int, controller: Controller) -> None:
    """Stops the motion over a connection of its own, within 6 s; BcapError or BcapLinkError where that fails."""
    client = BcapClient(host, port)
    try:
        provider = PROVIDERS[controller]
        answer = client.call(Function.CONTROLLER_CONNECT, "", provider, "localhost", "", deadline_s=1.0)
        handle = _handle(answer, "CONTROLLER_CONNECT")
        answer = client.call(Function.CONTROLLER_GET_ROBOT, handle, "Arm", "", deadline_s=1.0)
        client.call(Function.ROBOT_HALT, _handle(answer, "CONTROLLER_GET_ROBOT"), "", deadline_s=1.0)
    finally:
        client.close()


def _handle(answer: Value, what: str) -> int:
    if not isinstance(answer, int):
        raise BcapLinkError(f"{what}: needs a handle, the controller gave {answer!r}")
    return answer
