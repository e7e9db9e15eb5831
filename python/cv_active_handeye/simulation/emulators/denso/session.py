# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""One connection of a client: its handles, the order of its calls, and one call at a time with keep-alives."""

from __future__ import annotations

import contextlib
import re
import select
import socket
import threading
from typing import Literal

from ....robots.bcap_codes import Function, Result
from ....robots.bcap_packets import Packet, PacketError, PacketStream, Value, encode_packet
from ..log import Kind as EventKind
from ..server import ProtocolViolation
from . import commands
from .controller import DensoController
from .errors import Refusal, invalid
from .targets import Target

Kind = Literal["controller", "robot", "controller variable", "robot variable"]

_LEAST_WDT_MS = 80
_MOST_HANDLES = 1000
_SPEED = re.compile(r"\s*(?:SPEED|S)\s*=\s*(\d+(?:\.\d+)?)\s*", re.IGNORECASE)
_STRAIGHT, _POINT_TO_POINT = 2, 1
_LOGGED = {
    Function.CONTROLLER_CONNECT,
    Function.ROBOT_CHANGE,
    Function.ROBOT_HALT,
    Function.ROBOT_MOVE,
    Function.VARIABLE_PUT_VALUE,
}
_RELEASES: dict[Function, tuple[Kind, ...]] = {
    Function.CONTROLLER_DISCONNECT: ("controller",),
    Function.ROBOT_RELEASE: ("robot",),
    Function.VARIABLE_RELEASE: ("controller variable", "robot variable"),
}
_OF_ROBOT = (
    Function.ROBOT_GET_VARIABLE,
    Function.ROBOT_EXECUTE,
    Function.ROBOT_CHANGE,
    Function.ROBOT_HALT,
    Function.ROBOT_MOVE,
)


class Session:
    """Serves one connection; call `run` in its thread."""

    def __init__(self, controller: DensoController, connection: socket.socket) -> None:
        self._controller, self._connection = controller, connection
        self._started = False
        self._keep_alive_s: float | None = None
        self._handles: dict[int, tuple[Kind, str]] = {}
        self._last_handle = 0
        self._lock = threading.Lock()
        self._moving: Packet | None = None
        self._mover: threading.Thread | None = None

    def run(self) -> None:
        """Until the client is gone; then its motion ends and the arm is given back."""
        stream = PacketStream()
        try:
            while True:
                if not select.select([self._connection], [], [], self._keep_alive_s)[0]:
                    self._keep_alive()
                    continue
                data = self._connection.recv(65536)
                if not data or not all(self._take(packet) for packet in stream.feed(data)):
                    return
        except PacketError as error:
            raise ProtocolViolation(str(error)) from error
        finally:
            self._controller.give_arm(self)
            if self._mover is not None:
                self._mover.join()

    def _take(self, packet: Packet) -> bool:
        """Works on a request; False where it was the last one."""
        if packet.code in _LOGGED:
            self._log("command", name=Function(packet.code).name, args=_shown(packet.arguments))
        with self._lock:
            busy = self._moving is not None
            if not busy and packet.code == Function.ROBOT_MOVE:
                self._moving = packet
                self._controller.expect_motion()
                self._mover = threading.Thread(target=self._move, args=(packet,), daemon=True)
                self._mover.start()
                return True
        if busy:
            self._log("violation", text="a call came while another one was being worked on")
            self._send(Packet(packet.serial, Result.E_BUSY_CONNECTION))
        else:
            self._send(self.answer(packet))
        return packet.code != Function.SERVICE_STOP

    def _move(self, packet: Packet) -> None:
        answer = self.answer(packet)
        with self._lock:
            self._moving = None
            self._send(answer)

    def _keep_alive(self) -> None:
        with self._lock:
            if self._moving is not None:
                self._send(Packet(self._moving.serial, Result.S_EXECUTING))

    def _send(self, packet: Packet) -> None:
        if not self._controller.arm.faults.value("silent_port"):
            with contextlib.suppress(OSError):  # a client that is gone; `run` finds out
                self._connection.sendall(encode_packet(packet))

    def answer(self, packet: Packet) -> Packet:
        """The answer to a request, however long it takes; all that touches what a client sent."""
        try:
            value = self._call(packet.code, packet.arguments)
        except Refusal as refusal:
            if refusal.client_erred:
                self._log("violation", text=refusal.client_erred, refused_motion=packet.code == Function.ROBOT_MOVE)
            return Packet(packet.serial, refusal.code)
        return Packet(packet.serial, Result.S_OK, () if value is None else (value,))

    def _call(self, code: int, given: tuple[Value, ...]) -> Value:
        if code == Function.SERVICE_START:
            self._start(given)
            return None
        if not self._started:
            raise Refusal(Result.E_UNEXPECTED, f"function {code} came before SERVICE_START")
        if code == Function.SERVICE_STOP:
            return None
        if code == Function.CONTROLLER_CONNECT:
            if _text(given, 1).lower() != self._controller.profile.provider.lower():
                raise invalid(f"provider: needs {self._controller.profile.provider}, got {_text(given, 1)!r:.60}")
            return self._handle("controller", "")
        if code in _RELEASES:
            self._object(given, *_RELEASES[Function(code)])
            del self._handles[_integer(given, 0)]
            return None
        return self._object_call(code, given)

    def _object_call(self, code: int, given: tuple[Value, ...]) -> Value:
        """Functions whose first argument is a handle."""
        controller = self._controller
        if code in (Function.CONTROLLER_GET_ROBOT, Function.CONTROLLER_GET_VARIABLE, Function.CONTROLLER_EXECUTE):
            self._object(given, "controller")
            if code == Function.CONTROLLER_EXECUTE:
                self._log_command(_text(given, 1), given)
                return commands.controller_execute(controller, _text(given, 1), _parameter(given))
            robot = code == Function.CONTROLLER_GET_ROBOT
            return self._handle("robot" if robot else "controller variable", _text(given, 1))
        if code in (Function.VARIABLE_GET_VALUE, Function.VARIABLE_PUT_VALUE):
            kind, name = self._object(given, "controller variable", "robot variable")
            if code == Function.VARIABLE_GET_VALUE:
                return commands.variable(controller, kind == "robot variable", name)
            commands.put_variable(controller, name, given[1] if len(given) > 1 else None)
            return None
        if code not in _OF_ROBOT:
            raise Refusal(Result.E_NOTIMPL)
        self._object(given, "robot")
        return self._robot_call(Function(code), given)

    def _robot_call(self, function: Function, given: tuple[Value, ...]) -> Value:
        controller = self._controller
        if function == Function.ROBOT_GET_VARIABLE:
            return self._handle("robot variable", _text(given, 1))
        if function == Function.ROBOT_EXECUTE:
            self._log_command(_text(given, 1), given)
            return commands.robot_execute(controller, self, _text(given, 1), _parameter(given))
        if function == Function.ROBOT_CHANGE:
            controller.change_frame(self, _text(given, 1))
        elif function == Function.ROBOT_HALT:
            controller.halt()
        else:
            self._robot_move(given)
        return None

    def _robot_move(self, given: tuple[Value, ...]) -> None:
        interpolation = _integer(given, 1)
        if interpolation not in (_STRAIGHT, _POINT_TO_POINT) or len(given) < 3:
            raise invalid("Robot_Move: needs a robot, interpolation 1 or 2, pose data and an option")
        option = given[3] if len(given) > 3 else ""
        speed = _SPEED.fullmatch(option) if isinstance(option, str) else None
        if option not in ("", None) and speed is None:
            raise invalid(f"Robot_Move: the emulator knows SPEED=number only, got {option!r:.40}")
        percent = float(speed[1]) if speed else 100.0
        self._controller.move(self, interpolation == _STRAIGHT, Target.parse(given[2]), percent)

    def _start(self, given: tuple[Value, ...]) -> None:
        option = _text(given, 0) if given else ""
        match = re.search(r"WDT=(\d{1,6})", option)
        if match is not None and int(match[1]) < _LEAST_WDT_MS:
            raise invalid(f"WDT: needs {_LEAST_WDT_MS} ms or more, got {match[1]}")
        self._keep_alive_s = None if match is None else int(match[1]) / 1000
        self._started = True

    def _handle(self, kind: Kind, name: str) -> int:
        if len(self._handles) >= _MOST_HANDLES:
            raise Refusal(Result.E_OUTOFMEMORY, f"more than {_MOST_HANDLES} handles were opened and not released")
        self._last_handle += 1
        self._handles[self._last_handle] = (kind, name)
        if kind in ("controller variable", "robot variable"):
            try:
                commands.variable(self._controller, kind == "robot variable", name)
            except Refusal:
                del self._handles[self._last_handle]
                raise
        return self._last_handle

    def _object(self, given: tuple[Value, ...], *kinds: Kind) -> tuple[Kind, str]:
        kind, name = self._handles.get(_integer(given, 0), ("none", ""))
        for wanted in kinds:
            if kind == wanted:
                return wanted, name
        raise Refusal(Result.E_HANDLE, f"handle {given[0]!r:.20} is {kind}, needs {' or '.join(kinds)}")

    def _log_command(self, command: str, given: tuple[Value, ...]) -> None:
        if command.lower() in commands.LOGGED:
            self._log("command", name=command, args=_shown(given[2:]))

    def _log(self, kind: EventKind, **what: object) -> None:
        self._controller.arm.log.add(kind, **what)


def _integer(given: tuple[Value, ...], index: int) -> int:
    value = given[index] if index < len(given) else None
    if not isinstance(value, int):
        raise invalid(f"argument {index}: needs an integer")
    return value


def _text(given: tuple[Value, ...], index: int) -> str:
    value = given[index] if index < len(given) else None
    if not isinstance(value, str):
        raise invalid(f"argument {index}: needs text")
    return value


def _parameter(given: tuple[Value, ...]) -> Value:
    return given[2] if len(given) > 2 else None


def _shown(given: tuple[Value, ...]) -> list[str]:
    return [f"{value!r:.120}" for value in given]
