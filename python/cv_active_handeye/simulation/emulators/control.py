# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The port beside an emulated controller: what only the simulation knows, and the person at the pendant.

TCP, one JSON object a line each way. Requests: {"cmd": "cell"}, {"cmd": "state"}, {"cmd": "fault", "name": ...,
"value": ...} or {"cmd": "fault", "plan": "NAME[=VALUE][@...]"}, {"cmd": "clear"}, {"cmd": "hold", "on": true},
{"cmd": "rendered", "stop": 3, "switchings": 1}, {"cmd": "quit"}. Answers: {"ok": true, ...} or {"ok": false, "error":
"..."}. A hold ends with the connection that asked for it.
"""

from __future__ import annotations

import json
import socket
from collections.abc import Callable
from typing import Any

from .arm import EmulatedArm
from .faults import FaultPlan
from .server import Lines, Server

DEFAULT_PORT = 30020

Answer = dict[str, Any]


class ControlPort:
    """Serves the commands above for one arm; `on_quit` is called when a client asks the emulator to end."""

    def __init__(self, arm: EmulatedArm, host: str, port: int, on_quit: Callable[[], None]) -> None:
        """Begins to listen on `host`, `port` (0 = chosen)."""
        self._arm, self._quit = arm, on_quit
        self._server = Server(host, port, "control", self._serve, arm.log)
        self.port = self._server.port

    def close(self) -> None:
        """Ends every connection."""
        self._server.close()

    def _serve(self, connection: socket.socket) -> None:
        lines, holding = Lines(connection), False
        try:
            while (line := lines.read()) is not None:
                request = _parsed(line)
                answer = self._answer(request)
                holding = bool(request.get("on")) if request.get("cmd") == "hold" and answer["ok"] else holding
                connection.sendall(json.dumps(answer).encode() + b"\n")
                if request.get("cmd") == "quit":
                    self._quit()
        finally:
            if holding:
                self._arm.hold(False)

    def _answer(self, request: dict[str, Any]) -> Answer:
        commands: dict[str, Callable[[dict[str, Any]], Answer]] = {
            "cell": lambda _: {"cell": self._arm.cell.model_dump(mode="json")},
            "state": lambda _: self._arm.state().to_json(),
            "fault": self._fault,
            "clear": lambda _: self._done(self._arm.clear),
            "hold": lambda r: self._done(self._arm.hold, _typed(r, "on", bool)),
            "rendered": lambda r: self._done(self._arm.rendered, _typed(r, "stop", int), _typed(r, "switchings", int)),
            "quit": lambda _: {},
        }
        name = request.get("cmd")
        try:
            if not isinstance(name, str) or name not in commands:
                raise ValueError(f"cmd: needs one of {', '.join(commands)}; given {name!r}")
            return {"ok": True, **commands[name](request)}
        except (ValueError, TypeError) as error:
            return {"ok": False, "error": str(error)}

    def _fault(self, request: dict[str, Any]) -> Answer:
        if "plan" in request:
            self._arm.faults.plan(FaultPlan.parse(_typed(request, "plan", str)))
        else:
            value = request.get("value")
            self._arm.faults.set(_typed(request, "name", str), None if value is None else float(value))
        return {}

    @staticmethod
    def _done(action: Callable[..., None], *arguments: object) -> Answer:
        action(*arguments)
        return {}


def _parsed(line: bytes) -> dict[str, Any]:
    try:
        request = json.loads(line)
    except (ValueError, RecursionError):
        return {"cmd": None}
    return request if isinstance(request, dict) else {"cmd": None}


def _typed(request: dict[str, Any], key: str, kind: type) -> Any:
    value = request.get(key)
    if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
        raise ValueError(f"{key}: needs {kind.__name__}, given {value!r}")
    return value
