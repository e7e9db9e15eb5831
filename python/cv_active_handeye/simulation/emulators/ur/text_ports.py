# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The ports that take text: programs, and the dashboard."""

from __future__ import annotations

import socket
from collections.abc import Callable

from ..server import Lines, ProtocolViolation
from .controller import UrController

_LONGEST_PROGRAM = 1_000_000


def serve_programs(connection: socket.socket, controller: UrController) -> None:
    """Takes programs; one ends with a line `end` at its beginning."""
    lines, program, size = Lines(connection), [], 0
    while (line := lines.read()) is not None:
        text = line.decode("latin1").rstrip("\r")
        program.append(text)
        size += len(text)
        if size > _LONGEST_PROGRAM:
            raise ProtocolViolation(f"a program of more than {_LONGEST_PROGRAM} bytes")
        if text == "end":
            if not controller.arm.faults.value("silent_port"):
                controller.start_program("\n".join(program).lstrip("\n"))
            program, size = [], 0


def serve_dashboard(connection: socket.socket, controller: UrController) -> None:
    """Answers the dashboard's commands, a line each."""
    if controller.arm.faults.value("silent_port"):
        connection.recv(1)
        return
    connection.sendall(b"Connected: Universal Robots Dashboard Server\n")
    lines = Lines(connection)
    while (line := lines.read()) is not None:
        command = line.decode("latin1").strip().lower()
        if controller.arm.faults.value("silent_port"):
            continue
        connection.sendall(dashboard_answer(command, controller).encode() + b"\n")
        if command == "quit":
            return


def dashboard_answer(command: str, controller: UrController) -> str:
    """What the dashboard says to a command in lower case."""
    answers: dict[str, Callable[[UrController], str]] = {
        "polyscopeversion": lambda c: f"URSoftware {'.'.join(map(str, c.version))} (Jan 01 2024)",
        "get serial number": lambda c: c.serial,
        "get robot model": lambda c: "UR5",
        "is in remote control": lambda c: "true" if c.remote else "false",
        "robotmode": lambda c: "Robotmode: " + ("RUNNING" if c.robot_mode == 7 else "POWER_OFF"),
        "safetymode": lambda c: "Safetymode: " + _safety(c),
        "safetystatus": lambda c: "Safetystatus: " + _safety(c),
        "running": lambda c: f"Program running: {str(c.playing).lower()}",
        "programstate": lambda c: ("PLAYING" if c.playing else "STOPPED") + " rtde_control.urp",
        "stop": _stop,
        "unlock protective stop": _unlock,
        "close safety popup": lambda c: "closing safety popup",
        "quit": lambda c: "Disconnected",
    }
    if command not in answers:
        controller.arm.log.add("violation", text=f"dashboard: {command[:60]!r} is not known to this emulator")
        return f"could not understand: {command}"
    if command in ("stop", "unlock protective stop"):
        controller.arm.log.add("command", name=command, args=[])
    return answers[command](controller)


def _safety(controller: UrController) -> str:
    stop = controller.arm.stop_condition
    return {None: "NORMAL", "protective stop": "PROTECTIVE_STOP"}.get(stop, "ROBOT_EMERGENCY_STOP")


def _stop(controller: UrController) -> str:
    controller.stop_program()
    return "Stopped"


def _unlock(controller: UrController) -> str:
    if controller.arm.stop_condition != "protective stop":
        return "Cannot unlock protective stop"
    controller.arm.clear()
    return "Protective stop releasing"
