# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""URScript's `rtde_set_watchdog(variable, min_frequency, "stop")`, as ur_rtde's control program calls it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from ....robots.waiting import WatchedTime
from .registers import Registers

_POLL = 0.01  # s of the wall clock


class Watchdogs:
    """The watchdogs of one program, one for each input variable; all end with it.

    A client's package that holds the variable, whatever its value, is an update. Time is that of the client, so of the
    wall clock also where the arm's runs faster; while this process is paused nobody could have been heard.
    """

    def __init__(self, registers: Registers, expired: Callable[[str, float], None]) -> None:
        """`expired` is called with the variable and its limit (s) when no update has come within it, once."""
        self._registers, self._expired = registers, expired
        self._limits: dict[str, float] = {}
        self._end = threading.Event()
        self._thread: threading.Thread | None = None

    def set(self, variable: str, min_frequency: float) -> None:
        """Begins to watch an input variable, or changes its limit; min_frequency: Hz, ValueError unless > 0."""
        if not min_frequency > 0.0:
            raise ValueError(f"watchdog: needs a frequency > 0, given {min_frequency:g}")
        self._limits[variable] = 1.0 / min_frequency
        if self._thread is None:
            self._thread = threading.Thread(target=self._watch, name="UR watchdog", daemon=True)
            self._thread.start()

    def end(self) -> None:
        """Watches no longer."""
        self._end.set()

    def join(self) -> None:
        """Returns when the thread has ended."""
        if self._thread is not None and self._thread is not threading.current_thread():
            self._thread.join(5.0)

    def _watch(self) -> None:
        silent: dict[str, tuple[int, WatchedTime]] = {}
        while not self._end.wait(_POLL):
            now = time.monotonic()
            for variable, limit in list(self._limits.items()):
                updates = self._registers.updates(variable)
                if variable not in silent or silent[variable][0] != updates:
                    silent[variable] = (updates, WatchedTime(now))
                elif silent[variable][1].look(now) > limit:
                    self._end.set()
                    self._expired(variable, limit)
                    return
