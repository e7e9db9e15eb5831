# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Looks at a UR controller through sockets of our own, with time-outs, before ur_rtde is let near it.

ur_rtde waits for ever for a controller that accepts and stays silent. What is asked here tells also why a controller
cannot be used, in words for the person beside it.
"""

from __future__ import annotations

import re
import socket
import struct
import time
from dataclasses import dataclass

from . import rtde_packets as rtde
from .base import Array, RobotUnavailableError
from .rtde_packets import Packet, PacketError, PacketReader, Recipe, Value
from .ur_pose import pose_matrix
from .ur_watch import PLAYING, ROBOT_MODES, RUNNING_MODE, safety_stop

RTDE_PORT, PROGRAM_PORT, DASHBOARD_PORT = 30004, 30003, 29999
CONNECT_S, ANSWER_S = 2.0, 1.0

_OUTPUTS = Recipe(
    ("timestamp", "robot_mode", "safety_status_bits", "runtime_state"), ("DOUBLE", "INT32", "UINT32", "UINT32")
)
_TOOL = Recipe(("tcp_offset",), ("VECTOR6D",))


@dataclass(frozen=True)
class UrFacts:
    """What a controller says of itself. version: major, minor, bug fix, build. T_tcp2flange: None where it cannot."""

    version: tuple[int, int, int, int]
    robot_mode: int
    safety_bits: int
    runtime_state: int
    T_tcp2flange: Array | None

    @property
    def has_dashboard(self) -> bool:
        """PolyScope X (10) has none."""
        return self.version[0] < 10


def usable(host: str, live: bool, ours: bool = False) -> UrFacts:
    """What the controller says of itself; RobotUnavailableError, within 15 s, where it cannot be used.

    live: whether it is to be moved. ours: a program that runs there was begun by us and may be replaced.
    """
    facts = ask_rtde(host)
    if not live:
        if facts.T_tcp2flange is None:
            version = ".".join(map(str, facts.version[:3]))
            raise RobotUnavailableError(
                f"{host}: PolyScope {version} does not tell its tool centre point, so that the flange is only known "
                "when live"
            )
        return facts
    check_program_port(host)
    check_remote(host, facts)
    stop = safety_stop(facts.safety_bits)
    if stop is not None:
        raise RobotUnavailableError(f"{host}: {stop[0].value}: {stop[1]}")
    if facts.robot_mode != RUNNING_MODE:
        mode = ROBOT_MODES.get(facts.robot_mode, str(facts.robot_mode))
        raise RobotUnavailableError(f"{host}: the robot's mode is '{mode}': power it on and release its brakes")
    if facts.runtime_state == PLAYING and not ours:
        raise RobotUnavailableError(
            f"{host}: a program runs on the controller, somebody's or one that a lost connection left behind: stop it "
            "at the pendant"
        )
    return facts


def ask_rtde(host: str) -> UrFacts:
    """Asks the controller for its version and state; RobotUnavailableError within 2 s + 1 s for each answer."""
    try:
        with _Rtde(host) as link:
            if link.ask(rtde.PROTOCOL, struct.pack(">H", 2)) != b"\x01":
                raise RobotUnavailableError(f"{host}: the controller refuses RTDE protocol version 2; update PolyScope")
            version = struct.unpack(">4I", link.ask(rtde.VERSION, b""))
            state = link.first_package(_OUTPUTS)
            tool = link.first_package(_TOOL)
    except (OSError, PacketError, struct.error) as error:
        raise RobotUnavailableError(_why(host, RTDE_PORT, "RTDE", error)) from error
    if state is None:
        raise RobotUnavailableError(f"{host}: the controller knows no {', '.join(_OUTPUTS.names)}; update PolyScope")
    offset = None if tool is None else tool["tcp_offset"]
    try:
        T_tcp2flange = pose_matrix(offset) if isinstance(offset, tuple) else None
    except ValueError as error:
        raise RobotUnavailableError(f"{host}: tool centre point: {error}; set it at the pendant") from error
    return UrFacts(
        (version[0], version[1], version[2], version[3]),
        _whole(state["robot_mode"]),
        _whole(state["safety_status_bits"]),
        _whole(state["runtime_state"]),
        T_tcp2flange,
    )


def check_program_port(host: str) -> None:
    """RobotUnavailableError within 2 s where the port for programs takes no connection."""
    try:
        socket.create_connection((host, PROGRAM_PORT), CONNECT_S).close()
    except OSError as error:
        raise RobotUnavailableError(_why(host, PROGRAM_PORT, "programs", error)) from error


def ask_dashboard(host: str, *questions: str) -> list[str]:
    """The dashboard's answers, one line each; RobotUnavailableError within 2 s + 1 s for each."""
    try:
        with socket.create_connection((host, DASHBOARD_PORT), CONNECT_S) as link:
            link.settimeout(ANSWER_S)
            with link.makefile("rwb", buffering=0) as lines:
                _line(lines.readline(1000))
                answers = []
                for question in questions:
                    lines.write(question.encode() + b"\n")
                    answers.append(_line(lines.readline(1000)))
                return answers
    except OSError as error:
        raise RobotUnavailableError(_why(host, DASHBOARD_PORT, "dashboard", error)) from error


def check_remote(host: str, facts: UrFacts) -> None:
    """RobotUnavailableError where the controller says that it is in local control; CB3 and X cannot be asked."""
    if facts.version[0] != 5:
        return
    answer = ask_dashboard(host, "is in remote control")[0].lower()
    if re.search(r"\bfalse\b", answer):
        raise RobotUnavailableError(
            f"{host}: the robot is in local control: switch the pendant to Remote (top right corner); if there is no "
            "such choice, enable it in Settings > System > Remote Control"
        )


def serial_number(host: str, facts: UrFacts) -> str | None:
    """The controller's serial number, None where it tells none: PolyScope X, and some older versions.

    RobotUnavailableError, within 4 s, where the dashboard does not answer.
    """
    if not facts.has_dashboard:
        return None
    answer = ask_dashboard(host, "get serial number")[0]
    return answer if re.fullmatch(r"\d+", answer) else None


def stop_without_rtde(host: str, facts: UrFacts) -> bool:
    """The last resort when RTDE is lost: asks dashboard or program port to stop the arm; whether one was told.

    Takes at most 4 s.
    """
    try:
        if facts.has_dashboard:
            return "stopped" in ask_dashboard(host, "stop")[0].lower()
        with socket.create_connection((host, PROGRAM_PORT), CONNECT_S) as link:
            link.sendall(b"def halt():\n  stopl(2.0)\nend\n")
        return True
    except (RobotUnavailableError, OSError):
        return False


class _Rtde:
    """One RTDE connection with time-outs."""

    def __init__(self, host: str) -> None:
        self._socket = socket.create_connection((host, RTDE_PORT), CONNECT_S)
        self._reader = PacketReader()
        self._waiting: list[Packet] = []

    def __enter__(self) -> _Rtde:
        return self

    def __exit__(self, *_: object) -> None:
        self._socket.close()

    def ask(self, kind: int, payload: bytes) -> bytes:
        """Sends a packet and returns the answer of the same kind."""
        self._socket.sendall(Packet(kind, payload).encoded())
        return self._next(kind)

    def first_package(self, recipe: Recipe) -> dict[str, Value] | None:
        """One package of the outputs; None where the controller does not have them all."""
        text = ",".join(recipe.names).encode()
        answer = self.ask(rtde.OUTPUTS, struct.pack(">d", 125.0) + text)
        if answer[1:].decode("ascii", "replace").split(",") != list(recipe.types):
            return None
        self.ask(rtde.START, b"")
        values = recipe.unpack(self._next(rtde.DATA)[1:])
        self.ask(rtde.PAUSE, b"")
        return values

    def _next(self, kind: int) -> bytes:
        deadline = time.monotonic() + ANSWER_S
        while True:
            for i, packet in enumerate(self._waiting):
                if packet.kind == kind:
                    self._waiting = self._waiting[i + 1 :]
                    return packet.payload
            self._waiting = []
            self._socket.settimeout(max(deadline - time.monotonic(), 0.001))
            data = self._socket.recv(65536)
            if not data:
                raise ConnectionResetError("the controller closed the connection")
            self._waiting = list(self._reader.feed(data))


def _line(line: bytes) -> str:
    if not line.endswith(b"\n"):
        raise ConnectionResetError("the controller closed the connection")
    return line.decode("latin1").strip()


def _whole(value: Value) -> int:
    return int(value) if isinstance(value, (int, float)) else 0


def _why(host: str, port: int, service: str, error: Exception) -> str:
    where = f"{host}: port {port} ({service})"
    if isinstance(error, ConnectionRefusedError):
        return f"{where} refuses connections: is this the robot's address, is the controller on and the service enabled"
    if isinstance(error, TimeoutError):
        return f"{where} does not answer: restart the controller if it stays silent, check cable and firewall"
    if isinstance(error, (PacketError, struct.error)):
        return f"{where} answers something that is not RTDE ({error}): is this a UR controller"
    return f"{where} cannot be used: {error}"
