# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A thread that owns a `cv2.VideoCapture`, so that nobody else ever waits for a driver."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

import cv2

from .base import CameraError

_FAILURES = 20  # failing reads in a row that mean the end of a live source
_PAUSE = 0.02  # s after each of them


@dataclass(frozen=True)
class Arrived:
    """An image as decoded, when it arrived (`time.monotonic`), and the source's own time, s, where it has one."""

    image: cv2.typing.MatLike
    arrived: float
    stream_time: float | None


class Reader:
    """Reads all the time and keeps the newest frame (live), or waits with the next one until it is taken (a file)."""

    def __init__(self, name: str, opener: Callable[[], cv2.VideoCapture], *, live: bool) -> None:
        """opener: runs in the thread and may raise CameraError; it is told by `wait`."""
        self._name, self._opener, self._live = name, opener, live
        self._changed = threading.Condition()
        self._newest: Arrived | None = None
        self._count = 0
        self._closing = False
        self._problem: CameraError | None = None
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def wait(self, not_before: float, seconds: float) -> Arrived | None:
        """Returns a frame that arrived at or after `not_before` (a file: the next one), None after `seconds`.

        CameraError where the source cannot be opened or has ended.
        """
        with self._changed:
            self._changed.wait_for(lambda: self._ready(not_before) or self._problem is not None, seconds)
            if self._ready(not_before):
                return self._newest
            if self._problem is not None:
                raise CameraError(str(self._problem))
            return None

    def take(self) -> None:
        """Makes room for the next frame of a file; a live source goes on by itself."""
        with self._changed:
            if not self._live:
                self._newest = None
            self._changed.notify_all()

    def close(self) -> None:
        """Ends the thread, which releases the source; waits for it no longer than a second."""
        with self._changed:
            self._closing = True
            self._changed.notify_all()
        self._thread.join(1.0)

    def _ready(self, not_before: float) -> bool:
        return self._newest is not None and (not self._live or self._newest.arrived >= not_before)

    def _run(self) -> None:
        try:
            capture = self._opener()
        except Exception as error:
            told = error if isinstance(error, CameraError) else CameraError(f"{self._name}: {error}")
            self._end(told)
            return
        try:
            self._read_all(capture)
        except cv2.error as error:
            self._end(CameraError(f"{self._name}: {error}"))
        finally:
            capture.release()

    def _read_all(self, capture: cv2.VideoCapture) -> None:
        failures = 0
        while not self._closing:
            read, image = capture.read()
            if read:
                failures = 0
                self._store(image, capture.get(cv2.CAP_PROP_POS_MSEC))
                continue
            failures += 1
            if not self._live or failures == _FAILURES:
                self._end(self._ended())
                return
            time.sleep(_PAUSE)

    def _store(self, image: cv2.typing.MatLike, position_ms: float) -> None:
        stream_time = position_ms / 1000 if position_ms > 0 else None
        with self._changed:
            self._newest = Arrived(image, time.monotonic(), stream_time)
            self._count += 1
            self._changed.notify_all()
            self._changed.wait_for(lambda: self._live or self._closing or self._newest is None)

    def _ended(self) -> CameraError:
        if self._live:
            return CameraError(
                f"{self._name}: stopped delivering after {self._count} frames. Check power and cable; open it anew."
            )
        return CameraError(f"{self._name}: ended after {self._count} frames; there are no more")

    def _end(self, problem: CameraError) -> None:
        with self._changed:
            self._problem = problem
            self._changed.notify_all()
