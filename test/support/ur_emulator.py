# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A UR emulator in a process of its own, on an address that no other test has."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import TracebackType
from typing import Any

from cv_active_handeye.simulation.emulators import EmulatorLink, read_events

_COMMAND = "import sys; from cv_active_handeye.cli import app; app()"


class UrEmulatorProcess:
    """Runs `cv-active-handeye emulate ur` until the block is left; link: its control port."""

    def __init__(self, folder: Path, number: int, *options: str) -> None:
        self.host = f"127.{1 + os.getpid() // 250 % 250}.{1 + os.getpid() % 250}.{number}"
        self.log = folder / f"emulator{number}.jsonl"
        command = [sys.executable, "-c", _COMMAND, "emulate", "ur", "--host", self.host, "--control-port", "0"]
        self._output = folder / f"emulator{number}.txt"  # a pipe that nobody reads would fill and stop the emulator
        with self._output.open("w") as output:
            options = ("--log", str(self.log), *options)
            self.process = subprocess.Popen([*command, *options], stdout=output, stderr=subprocess.STDOUT)
        self.ready = self._wait_until_ready()
        self.link = EmulatorLink(self.host, int(self.ready.rsplit(":", 1)[1]))
        self._first = 0

    def _wait_until_ready(self) -> str:
        deadline = time.monotonic() + 30
        while not (found := re.search(r"^ready UR controller.*\n", self._output.read_text(), re.MULTILINE)):
            assert self.process.poll() is None, self._output.read_text()
            assert time.monotonic() < deadline
            time.sleep(0.02)
        return found[0]

    def begin(self) -> None:
        """The person at the pendant clears everything; `events` begin here."""
        self.link.clear()
        self._first = len(read_events(self.log))

    def events(self) -> list[dict[str, Any]]:
        return read_events(self.log)[self._first :]

    def commands(self) -> list[str]:
        return [event["name"] for event in self.events() if event["kind"] == "command"]

    def end(self) -> str:
        """Ends it as a terminal does, with two signals at once; returns what it printed."""
        self.link.close()
        self.process.send_signal(signal.SIGTERM)
        self.process.send_signal(signal.SIGINT)
        self.process.wait(timeout=20)
        return self._output.read_text()

    def __enter__(self) -> UrEmulatorProcess:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait(timeout=20)
        self.link.close()
