# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The emulated DENSO controller as a whole: its port, and what faults do to it."""

from __future__ import annotations

import socket
from types import TracebackType
from typing import Literal

from ....robots.bcap import PORT
from ....robots.denso_link import Controller
from ..arm import EmulatedArm
from ..server import Server
from .controller import DensoController
from .profiles import PROFILES
from .session import Session

Convention = Literal["xyz", "ZYZ"]

DENSO_FAULTS = frozenset(
    (
        "protective_stop",
        "emergency_stop",
        "unreachable",
        "drop_link",
        "frozen_timestamp",
        "silent_port",
        "not_remote",
        "slow_settling",
        "pose_bias",
        "pose_noise",
        "nan_pose",
        "slow_motion",
        "program_stopped",
    )
)
"""Those of `emulators.FAULTS` that it has; not_remote is manual mode, program_stopped the pendant's stop of all."""

_STOPS = {"not_remote": "manual mode", "program_stopped": "program stopped"}


class DensoEmulator:
    """Serves b-CAP for an arm until `close`; any client that reaches `host` may connect."""

    def __init__(
        self,
        arm: EmulatedArm,
        *,
        host: str = "127.0.0.1",
        port: int = PORT,
        controller: Controller = "rc8",
        convention: Convention = "xyz",
        tool: int = 0,
    ) -> None:
        """Begins to listen; OSError where the port is taken.

        port: 0 = chosen. convention: what RX, RY, RZ mean to P2T (scipy's name); "ZYZ" = a controller that a client
        must refuse. tool: active tool, 0 to 63.
        """
        self._arm = arm
        self._controller = DensoController(arm, PROFILES[controller], convention, tool)
        arm.faults.subscribe(self._fault)
        self._server = Server(host, port, "b-CAP", self._serve, arm.log)
        self.port = self._server.port

    def close(self) -> None:
        """Ends every connection."""
        self._server.close()

    def __enter__(self) -> DensoEmulator:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _serve(self, connection: socket.socket) -> None:
        Session(self._controller, connection).run()

    def _fault(self, name: str, value: float) -> None:
        if not value:
            return
        if name in _STOPS:
            self._arm.halt(_STOPS[name])
        if name in (*_STOPS, "protective_stop", "emergency_stop"):
            self._controller.cut_motor()
        if name == "drop_link":
            self._server.drop()
