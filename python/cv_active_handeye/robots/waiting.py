# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Waiting for a controller without taking a pause of this process for its silence.

A process that a busy computer does not run for a while has seen nothing new when it goes on, although the answer waits
in the socket. So time counts only while somebody looks: between two looks not more than `LONGEST_S`.
"""

from __future__ import annotations

import time
from collections.abc import Iterator

LONGEST_S = 0.05
"""What counts between two looks, at most, s. Whoever looks more often than that counts the time of the wall clock."""

_STEP_S = 0.04


class WatchedTime:
    """Seconds since `restart` that were watched; times are those of `time.monotonic`."""

    def __init__(self, now: float) -> None:
        """Begins at `now`."""
        self.restart(now)

    def restart(self, now: float) -> None:
        """Begins anew."""
        self._last, self._watched = now, 0.0

    def look(self, now: float) -> float:
        """Returns what was watched until `now`, s."""
        self._watched += min(now - self._last, LONGEST_S)
        self._last = now
        return self._watched


def watched_waits(seconds: float) -> Iterator[float]:
    """Yields time-outs (s) of single waits, one at least, until `seconds` have been watched."""
    watched, left = WatchedTime(time.monotonic()), seconds
    while True:
        yield min(_STEP_S, left)
        left = seconds - watched.look(time.monotonic())
        if left <= 0.0:
            return
