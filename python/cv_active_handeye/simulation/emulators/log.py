# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What happened in an emulator, one JSON object a line: the judge of every test that breaks something."""

from __future__ import annotations

import json
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, Literal, TextIO

Kind = Literal[
    "connect",
    "disconnect",
    "command",
    "motion_begin",
    "motion_end",
    "fault",
    "stop_condition",
    "cleared",
    "output",
    "violation",
]
Event = dict[str, Any]

_KEPT = 20_000  # events in memory; a client that floods the emulator cannot fill it


class EventLog:
    """Events in their order; may be written to from any thread.

    Every event has `time` (`time.monotonic` of this machine, s), `kind` and what belongs to the kind: command: name,
    args; motion_begin: motion (count), length_m, asked (when the command came: finding the joints of the way takes
    time); motion_end: motion, arrived, stop; fault: name, value;
    stop_condition: reason; output: pin, on; violation: text; connect, disconnect: service, peer.
    """

    def __init__(self, path: Path | None = None, listener: Callable[[Event], None] | None = None) -> None:
        """Writes to `path`, too, line by line as it happens; `listener` gets every event (the terminal does)."""
        self._file: TextIO | None = None if path is None else path.open("w", encoding="utf-8")
        self._listener = listener
        self._lock = threading.Lock()
        self._events: deque[Event] = deque(maxlen=_KEPT)

    def add(self, kind: Kind, **what: Any) -> None:
        """Appends an event."""
        with self._lock:
            event: Event = {"time": time.monotonic(), "kind": kind, **what}
            self._events.append(event)
            if self._file is not None:
                self._file.write(json.dumps(event) + "\n")
                self._file.flush()
            if self._listener is not None:
                self._listener(event)

    @property
    def events(self) -> list[Event]:
        """The last 20 000 events."""
        with self._lock:
            return list(self._events)

    def of_kind(self, kind: Kind) -> list[Event]:
        """The events of one kind."""
        return [event for event in self.events if event["kind"] == kind]

    def close(self) -> None:
        """Closes the file."""
        with self._lock:
            if self._file is not None:
                self._file.close()
                self._file = None


def read_events(path: Path) -> list[Event]:
    """Reads the events an emulator wrote; a last line cut off by a kill is left out."""
    lines = path.read_text(encoding="utf-8").split("\n")
    return [json.loads(line) for line in lines[:-1]]


def moves_after_stop(events: Iterable[Event], grace: float = 0.0) -> list[Event]:
    """Returns the motions that a client began, or asked for, later than `grace` s after a stop condition.

    A person who clears the stop condition ends it. Empty = the client did as it must. Of a program that was stopped or
    a clock that stands still a client cannot know before some packages have come: give it as long as it claims to need.
    """
    stopped: float | None = None
    found = []
    for event in events:
        if event["kind"] == "stop_condition" and stopped is None:
            stopped = event["time"]
        elif event["kind"] == "cleared":
            stopped = None
        elif stopped is not None and (event["asked"] if "asked" in event else event["time"]) > stopped + grace:
            refused = event["kind"] == "violation" and event.get("refused_motion", False)
            if event["kind"] == "motion_begin" or refused:
                found.append(event)
    return found
