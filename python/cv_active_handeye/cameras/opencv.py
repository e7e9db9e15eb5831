# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Cameras, video files and network streams that `cv2.VideoCapture` can open.

How a frame is made sure to be newer than `grab`, by kind of source:
- device and stream: a thread of its own empties the driver's queue all the time, so that a frame's arrival is known. Of
  these a frame counts that arrived `latency_s` or more after `grab` was called: its exposure began after the call if
  exposure, transfer and decoding together last no longer than `latency_s`. OpenCV has no exposure time stamp that would
  hold for all of its backends.
- file: a recording; every grab gives the next frame.

The thread also bounds the time: a read that never returns is left behind, and `grab` tells after its time-out.
"""

from __future__ import annotations

import time
from typing import Literal

import cv2
from pydantic import Field, model_validator

from ..dataset_format import CameraInfo
from .base import Camera, CameraError, Frame
from .common import BadFrameError, DeviceConfig, OpenCamera, checked_frame, pixel_format_of
from .video_reader import Reader

BACKENDS = {
    "any": cv2.CAP_ANY,
    "v4l2": cv2.CAP_V4L2,
    "dshow": cv2.CAP_DSHOW,
    "msmf": cv2.CAP_MSMF,
    "ffmpeg": cv2.CAP_FFMPEG,
    "gstreamer": cv2.CAP_GSTREAMER,
    "images": cv2.CAP_IMAGES,
}
Backend = Literal["any", "v4l2", "dshow", "msmf", "ffmpeg", "gstreamer", "images"]


class OpencvCameraConfig(DeviceConfig):
    """source: number or path (/dev/...) of a device; address (rtsp://...) or GStreamer pipeline of a stream; else a
    file, or images numbered like img%03d.png with the backend "images".

    pixel_format: "bgr8" as decoded, "mono8" from it by cv2.cvtColor, "mono16" undecoded (a device or file with 16-bit
    grey, fourcc "Y16 "). Devices only: width, height in pixels; auto_exposure, exposure, gain in the units of the
    driver (V4L2: auto_exposure 1 = manual, exposure in 0.1 ms); all are read back. latency_s: longest time from the
    beginning of an exposure to the frame's arrival (device 0.3 s, stream 1 s unless given).
    """

    type: Literal["opencv"] = "opencv"
    source: int | str
    backend: Backend = "any"
    pixel_format: Literal["bgr8", "mono8", "mono16"] = "bgr8"
    fourcc: str | None = Field(default=None, min_length=4, max_length=4)
    width: int | None = Field(default=None, gt=0)
    height: int | None = Field(default=None, gt=0)
    auto_exposure: float | None = None
    exposure: float | None = None
    gain: float | None = None
    latency_s: float | None = Field(default=None, ge=0, le=30, allow_inf_nan=False)

    @property
    def kind(self) -> Literal["device", "stream", "file"]:
        """What `source` names."""
        if isinstance(self.source, int) or self.source.startswith("/dev/"):
            return "device"
        return "stream" if "://" in self.source or " ! " in self.source else "file"

    @property
    def latency(self) -> float:
        """`latency_s`, or what it is for this kind of source, s."""
        if self.latency_s is not None:
            return self.latency_s
        return {"device": 0.3, "stream": 1.0, "file": 0.0}[self.kind]

    @model_validator(mode="after")
    def _possible(self) -> OpencvCameraConfig:
        settings = ("fourcc", "width", "height", "auto_exposure", "exposure", "gain")
        given = [key for key in settings if getattr(self, key) is not None]
        if given and self.kind != "device":
            raise ValueError(f"{', '.join(given)}: need a device as source, given the {self.kind} {self.source!r}")
        if self.timeout_s <= self.latency:
            raise ValueError(f"timeout_s: needs more than the latency of {self.latency:g} s, given {self.timeout_s:g}")
        return self

    def properties(self) -> dict[str, tuple[int, float]]:
        """Number and value of every property that is to be set, by the key that asked for it, in this order."""
        code = None if self.fourcc is None else float(cv2.VideoWriter.fourcc(*self.fourcc))
        wanted = {
            "fourcc": (cv2.CAP_PROP_FOURCC, code),
            "width": (cv2.CAP_PROP_FRAME_WIDTH, self.width),
            "height": (cv2.CAP_PROP_FRAME_HEIGHT, self.height),
            "auto_exposure": (cv2.CAP_PROP_AUTO_EXPOSURE, self.auto_exposure),
            "exposure": (cv2.CAP_PROP_EXPOSURE, self.exposure),
            "gain": (cv2.CAP_PROP_GAIN, self.gain),
        }
        return {key: (number, float(value)) for key, (number, value) in wanted.items() if value is not None}


def connect(config: OpencvCameraConfig) -> Camera:
    """Opens the source and waits for its first frame, at most `open_timeout_s`; CameraError."""
    name = f"opencv {config.kind} {config.source}"
    reader = Reader(name, lambda: _opened(config, name), live=config.kind != "file")
    try:
        first = reader.wait(0.0, config.open_timeout_s)
        if first is None:
            raise CameraError(
                f"{name}: gave no frame within {config.open_timeout_s:g} s. Check power, cable and address, or give it "
                "more time (open_timeout_s)."
            )
        image = _as(config.pixel_format, first.image)
        height, width = image.shape[:2]
        info = CameraInfo(width=width, height=height, pixel_format=pixel_format_of(image, name), name=name)
        if info.pixel_format != config.pixel_format:
            raise CameraError(f"{name}: gives {info.pixel_format}, not {config.pixel_format}; change pixel_format")
    except CameraError:
        reader.close()
        raise
    return OpencvCamera(reader, info, config)


class OpencvCamera(OpenCamera):
    """See the module for what is known about a frame's age."""

    def __init__(self, reader: Reader, info: CameraInfo, config: OpencvCameraConfig) -> None:
        """reader: runs already."""
        super().__init__(info, config.retries)
        self._reader = reader
        self._config = config

    def _expose(self) -> Frame:
        requested = time.monotonic()
        frame = self._reader.wait(requested + self._config.latency, self._config.timeout_s)
        if frame is None:
            raise BadFrameError(f"no frame within {self._config.timeout_s:g} s")
        self._reader.take()
        return checked_frame(_as(self._config.pixel_format, frame.image), frame.stream_time, requested)

    def close(self) -> None:
        """Stops the thread; one that hangs in the driver is left to end with the program."""
        self._reader.close()


def _opened(config: OpencvCameraConfig, name: str) -> cv2.VideoCapture:
    backend = BACKENDS[config.backend]
    limits: list[int] = []
    if config.kind == "stream" and "://" in str(config.source) and config.backend in ("any", "ffmpeg"):
        backend = cv2.CAP_FFMPEG
        limits = [cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, round(1000 * config.open_timeout_s)]
        limits += [cv2.CAP_PROP_READ_TIMEOUT_MSEC, round(1000 * config.timeout_s)]
    capture = cv2.VideoCapture()
    source = config.source
    opened = capture.open(source, backend, limits) if isinstance(source, str) else capture.open(source, backend)
    if not opened:
        raise CameraError(f"{name}: cannot be opened. Check the name, and that no other program uses it.")
    for key, (number, value) in config.properties().items():
        _set(capture, number, value, f"{name}: {key}")
    if config.pixel_format == "mono16":
        _set(capture, cv2.CAP_PROP_CONVERT_RGB, 0.0, f"{name}: mono16 without conversion")
    return capture


def _set(capture: cv2.VideoCapture, number: int, value: float, told: str) -> None:
    """Sets and reads back; drivers round to their own steps, so 1 % is taken as equal."""
    accepted = capture.set(number, value)
    given = capture.get(number)
    if not accepted or abs(given - value) > 0.01 * abs(value):
        raise CameraError(f"{told}: {value:g} was asked for, the driver says {given:g}; choose a value that it offers")


def _as(pixel_format: str, image: cv2.typing.MatLike) -> cv2.typing.MatLike:
    if image.ndim == 3 and image.shape[2] == 1:
        image = image[:, :, 0]
    return cv2.cvtColor(image, cv2.COLOR_BGR2GRAY) if pixel_format == "mono8" and image.ndim == 3 else image
