# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Emulated controllers in processes of their own, as a user starts them."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from cv_active_handeye.simulation.emulators import EmulatorLink

PROGRAM = [sys.executable, "-c", "import sys; from cv_active_handeye.cli import app; sys.exit(app())"]
"""`cv-active-handeye`."""


class Emulator:
    """`cv-active-handeye emulate` in a process of its own."""

    def __init__(self, device: str, host: str, log: Path, options: Sequence[str]) -> None:
        """Returns when it is ready; `options`: further ones of the command."""
        command = [*PROGRAM, "emulate", device, "--host", host, "--control-port", "0", "--log", str(log)]
        command += options
        self._process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        assert self._process.stdout is not None
        found = (re.search(r"^ready .* control ([0-9.]+):([0-9]+)", line) for line in self._process.stdout)
        ready = next((match for match in found if match is not None), None)
        if ready is None:
            raise RuntimeError("the emulator did not start")
        self._reader = ThreadPoolExecutor(1)
        self._reader.submit(self._process.stdout.read)
        self.address = ready[1], int(ready[2])
        self.link = EmulatorLink(*self.address, 10.0)

    def __enter__(self) -> Emulator:
        return self

    def __exit__(self, *error: object) -> None:
        self.link.close()
        self._process.terminate()
        self._process.wait(20)
        self._reader.shutdown()
