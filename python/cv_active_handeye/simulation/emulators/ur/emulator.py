# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The emulated controller on its ports."""

from __future__ import annotations

import zlib
from types import TracebackType

from ..arm import EmulatedArm
from ..server import Server
from .controller import UrController
from .rtde_port import Claims, RtdeConnection
from .text_ports import serve_dashboard, serve_programs

RTDE, PROGRAMS, DASHBOARD = 30004, 30003, 29999
"""The ports of every UR controller; ur_rtde knows no others."""


class UrEmulator:
    """Serves one arm as a UR controller of a PolyScope version on `host`. Use as a context manager."""

    def __init__(self, arm: EmulatedArm, host: str = "127.0.0.1", version: str = "5.11") -> None:
        """Begins to listen; OSError where a port is taken. Several emulators: addresses 127.0.0.2, 127.0.0.3, ..."""
        self.host = host
        serial = f"2023{zlib.crc32(host.encode()):010d}"  # every address another controller
        self.controller = controller = UrController(arm, version, serial=serial)
        claims = Claims()
        self._servers = [
            Server(host, RTDE, "rtde", lambda c: RtdeConnection(c, controller, claims).serve(), arm.log),
        ]
        try:
            self._listen("programs", host, PROGRAMS)
            if controller.version[0] < 10:
                self._listen("dashboard", host, DASHBOARD)
        except OSError:
            self.close()
            raise
        arm.faults.subscribe(self._fault)

    def close(self) -> None:
        """Ends the program and every connection, and returns when all threads have ended."""
        self.controller.stop_program()
        for server in self._servers:
            server.close()

    def __enter__(self) -> UrEmulator:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _listen(self, service: str, host: str, port: int) -> None:
        serve = serve_programs if service == "programs" else serve_dashboard
        controller = self.controller
        self._servers.append(Server(host, port, service, lambda c: serve(c, controller), controller.arm.log))

    def _fault(self, name: str, value: float) -> None:
        if value and name == "drop_link":
            for server in self._servers:
                server.drop()
