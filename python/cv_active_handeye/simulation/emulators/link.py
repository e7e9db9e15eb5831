# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The other end of an emulator's control port."""

from __future__ import annotations

import json
import socket
import threading
from types import TracebackType
from typing import Any

from ..config import CellConfig
from .control import DEFAULT_PORT
from .state import ArmState


class EmulatorLinkError(RuntimeError):
    """The emulator does not answer, or refuses a request; the text says which."""


class EmulatorLink:
    """A connection to the control port; every call returns within `timeout` s or raises EmulatorLinkError."""

    def __init__(self, host: str = "127.0.0.1", port: int = DEFAULT_PORT, timeout: float = 5.0) -> None:
        """Connects."""
        self._where = f"emulator at {host}:{port}"
        self._lock = threading.Lock()
        self._buffer = b""
        try:
            self._socket = socket.create_connection((host, port), timeout)
        except OSError as error:
            raise EmulatorLinkError(f"{self._where}: {error}; is `cv-active-handeye emulate` running?") from error

    def cell(self) -> CellConfig:
        """The simulated cell that the emulator was started with."""
        return CellConfig.model_validate(self._ask("cell")["cell"])

    def state(self) -> ArmState:
        """Where the arm is now."""
        return ArmState.from_json(self._ask("state"))

    def fault(self, name: str, value: float | None = None) -> None:
        """Lets a fault set in now; None = its default value, 0 ends it."""
        self._ask("fault", name=name, value=value)

    def plan_fault(self, plan: str) -> None:
        """Prepares a fault: NAME[=VALUE][@SECONDS|@stopN|@moveN]."""
        self._ask("fault", plan=plan)

    def clear(self) -> None:
        """Does what the person at the pendant does: clears stops and faults."""
        self._ask("clear")

    def hold(self, on: bool) -> None:
        """Lets the arm count as steady only after `rendered`; ends with this connection."""
        self._ask("hold", on=on)

    def rendered(self, stop: int, switchings: int) -> None:
        """Tells that the camera feed shows this stop after so many changes of the outputs."""
        self._ask("rendered", stop=stop, switchings=switchings)

    def quit(self) -> None:
        """Ends the emulator."""
        self._ask("quit")

    def close(self) -> None:
        """Disconnects."""
        self._socket.close()

    def __enter__(self) -> EmulatorLink:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _ask(self, command: str, **what: Any) -> dict[str, Any]:
        with self._lock:
            try:
                self._socket.sendall(json.dumps({"cmd": command, **what}).encode() + b"\n")
                answer: dict[str, Any] = json.loads(self._line())
            except (OSError, ValueError) as error:
                raise EmulatorLinkError(f"{self._where}: no answer to {command!r}: {error}") from error
        if not answer["ok"]:
            raise EmulatorLinkError(f"{self._where}: {command!r} refused: {answer['error']}")
        return answer

    def _line(self) -> bytes:
        while b"\n" not in self._buffer:
            block = self._socket.recv(65536)
            if not block:
                raise ConnectionResetError("connection closed")
            self._buffer += block
        line, self._buffer = self._buffer.split(b"\n", 1)
        return line
