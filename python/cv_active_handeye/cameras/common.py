# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What the device files share: settings, vendor libraries, deadlines, retries, and the check of every frame."""

from __future__ import annotations

import importlib
import threading
import time
import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable
from types import TracebackType
from typing import Any, NoReturn, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from ..dataset import Image
from ..dataset_format import CameraInfo, PixelFormat
from .base import CameraError, Frame

Opened = TypeVar("Opened")


class StrictConfig(BaseModel):
    """Settings of a camera; keys that are not listed are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class DeviceConfig(StrictConfig):
    """Settings of every real camera.

    timeout_s: for one frame; retries: how often a damaged or missing frame is taken again, so that `grab` returns
    within (1 + retries) * timeout_s. open_timeout_s: for finding and opening the device.
    """

    timeout_s: float = Field(default=2.0, gt=0, le=60, allow_inf_nan=False)
    retries: int = Field(default=2, ge=0, le=20)
    open_timeout_s: float = Field(default=15.0, gt=0, le=120, allow_inf_nan=False)


class BadFrameError(Exception):
    """One frame is missing or damaged; another try may help. The text says what was wrong."""


class OpenCamera(ABC):
    """A camera whose frames come one after the other from `_expose`."""

    def __init__(self, info: CameraInfo, retries: int) -> None:
        """info: what every frame must agree with."""
        self.info = info
        self._retries = retries

    @abstractmethod
    def _expose(self) -> Frame:
        """One try; BadFrameError where another may help, CameraError where not."""

    @abstractmethod
    def close(self) -> None:
        """Releases the device; never raises."""

    def grab(self) -> Frame:
        """Returns a frame exposed after this call; CameraError after the retries."""
        problems: list[str] = []
        for _ in range(1 + self._retries):
            try:
                frame = self._expose()
            except BadFrameError as problem:
                problems.append(str(problem))
                continue
            check_image(frame.image, self.info)
            return frame
        raise CameraError(
            f"{self.info.name}: no usable frame in {len(problems)} tries: {'; '.join(dict.fromkeys(problems))}. "
            "Check power, cable and bandwidth, or give it more time (timeout_s) or tries (retries)."
        )

    def set_line(self, on: bool) -> None:
        """Refuses: a device file with an output line says otherwise."""
        state = "on" if on else "off"
        raise CameraError(f"{self.info.name}: has no output line to switch {state}; choose another laser switch")

    def __enter__(self) -> OpenCamera:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def pixel_format_of(image: NDArray[Any], name: str) -> PixelFormat:
    """The data set's name for (H, W) or (H, W, 3) pixels of 8 or 16 bit; CameraError for anything else."""
    formats: dict[tuple[int, str], PixelFormat] = {
        (2, "uint8"): "mono8",
        (2, "uint16"): "mono16",
        (3, "uint8"): "bgr8",
        (3, "uint16"): "bgr16",
    }
    found = formats.get((image.ndim, str(image.dtype)))
    if found is None or (image.ndim == 3 and image.shape[2] != 3):
        raise CameraError(
            f"{name}: gives pixels {image.shape} of {image.dtype}; needed: grey or BGR of 8 or 16 bit. "
            "Choose another pixel format."
        )
    return found


def check_image(image: Image, info: CameraInfo) -> None:
    """CameraError unless size and pixel format are those of `info`."""
    given = (image.shape[1], image.shape[0], pixel_format_of(image, info.name))
    needed = (info.width, info.height, info.pixel_format)
    if given != needed:
        raise CameraError(
            f"{info.name}: gave a frame of {given[0]} x {given[1]} {given[2]} instead of "
            f"{needed[0]} x {needed[1]} {needed[2]}; its settings changed while it was open. Open it anew."
        )


def checked_frame(image: NDArray[Any], camera_time: float | None, requested: float) -> Frame:
    """The frame that has just arrived."""
    return Frame(np.ascontiguousarray(image), camera_time, requested, time.monotonic())


def vendor_module(module: str, extra: str) -> Any:
    """Imports a vendor's library; CameraError names the extra that brings it."""
    try:
        with warnings.catch_warnings():  # SWIG's modules warn when they load, and crash where a warning is an error
            warnings.simplefilter("ignore", DeprecationWarning)
            return importlib.import_module(module)
    except ImportError as error:
        raise CameraError(
            f"{module}: cannot be imported ({error}); pip install 'cv_active_handeye[{extra}]'"
        ) from error


def within(seconds: float, action: Callable[[], Opened], name: str, release: Callable[[Opened], None]) -> Opened:
    """Returns what `action` opens; CameraError after `seconds`, and `release` closes what comes later."""
    lock = threading.Lock()
    done = threading.Event()
    outcome: list[Opened] = []
    errors: list[Exception] = []
    given_up = False

    def run() -> None:
        try:
            opened = action()
        except Exception as error:
            errors.append(error)
            done.set()
            return
        with lock:
            if not given_up:
                outcome.append(opened)
                done.set()
                return
        release(opened)

    threading.Thread(target=run, name=f"open {name}", daemon=True).start()
    done.wait(seconds)
    with lock:
        given_up = not outcome
    if errors:
        raise _told(name, errors[0]) from errors[0]
    if not outcome:
        _refuse_to_wait(name, seconds)
    return outcome[0]


def _told(name: str, error: Exception) -> CameraError:
    if isinstance(error, CameraError):
        return error
    return CameraError(f"{name}: cannot be opened: {error}. Check that no other program uses it.")


def _refuse_to_wait(name: str, seconds: float) -> NoReturn:
    raise CameraError(
        f"{name}: did not open within {seconds:g} s. Check power, cable and address, or give it more time "
        "(open_timeout_s)."
    )
