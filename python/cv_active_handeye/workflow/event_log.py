# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""`events.jsonl`: what a capture did and saw, a line an event, on disk before the program goes on."""

from __future__ import annotations

import json
import os
import time
from datetime import datetime, timezone
from pathlib import Path
from types import TracebackType
from typing import Any

FILE_NAME = "events.jsonl"


class EventLog:
    """Appends events to a file; a crash or power cut loses none that was logged.

    An event that cannot be written (full disk) must not keep a robot from being stopped: the error is kept in `failed`,
    and `check` raises it before the next thing is begun.
    """

    def __init__(self, path: Path) -> None:
        """Opens the file, a new one or that of an earlier capture."""
        unfinished = path.is_file() and path.stat().st_size > 0 and not path.read_bytes().endswith(b"\n")
        self._file = os.open(path, os.O_APPEND | os.O_CREAT | os.O_WRONLY, 0o644)
        self.failed: OSError | None = None
        if unfinished:
            self._write(b"\n")

    def __call__(self, kind: str, **said: Any) -> None:
        """Writes one event: UTC, this machine's monotonic clock (s), its kind, and what belongs to it."""
        now = datetime.now(timezone.utc).isoformat(timespec="milliseconds")
        line = json.dumps({"utc": now, "monotonic": round(time.monotonic(), 4), "event": kind, **said})
        self._write(line.encode() + b"\n")

    def check(self) -> None:
        """OSError where an event could not be written."""
        if self.failed is not None:
            raise self.failed

    def close(self) -> None:
        """Closes the file."""
        os.close(self._file)

    def __enter__(self) -> EventLog:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _write(self, line: bytes) -> None:
        try:
            os.write(self._file, line)
            os.fsync(self._file)
        except OSError as error:
            self.failed = error


def read_events(path: Path) -> list[dict[str, Any]]:
    """The events of a log in their order, without lines that a power cut left unfinished."""
    events = []
    for line in path.read_bytes().split(b"\n"):
        try:
            events.append(json.loads(line))
        except ValueError:
            continue
    return events
