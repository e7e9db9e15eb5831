# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What a camera is to this software: one frame at a time, taken after it was asked for."""

from __future__ import annotations

from dataclasses import dataclass
from types import TracebackType
from typing import Protocol, runtime_checkable

from ..dataset import Image
from ..dataset_format import CameraInfo


class CameraError(RuntimeError):
    """No camera, no frame, or a damaged one; the text names the camera, what happened, and what can be done."""


@dataclass(frozen=True)
class Frame:
    """One image (H, W) or (H, W, 3) BGR, 8 or 16 bit.

    camera_time: the camera's own clock, s, None where it has none. requested, received: `time.monotonic` before the
    exposure was asked for and after the frame had arrived; the exposure lies between them.
    """

    image: Image
    camera_time: float | None
    requested: float
    received: float


@runtime_checkable
class Camera(Protocol):
    """A camera that is open. Use as a context manager."""

    info: CameraInfo
    """Size, pixel format and name, as they go into the data set."""

    def grab(self) -> Frame:
        """Returns a frame whose exposure began after this call; CameraError after the time-out and its retries."""
        ...

    def set_line(self, on: bool) -> None:
        """Switches the camera's output line (a laser's, for example); CameraError where it has none."""
        ...

    def close(self) -> None:
        """Releases the device; never raises."""
        ...

    def __enter__(self) -> Camera: ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None: ...
