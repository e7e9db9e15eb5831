# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Basler cameras by pypylon (extra `basler`), its camera emulator included.

Every grab starts the acquisition for one frame, triggers it and ends the acquisition: no frame of before can be waiting
in a queue, and a standing robot has the milliseconds. (The emulator reads its image file at that trigger.)
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import suppress
from typing import Any, Literal

from ..dataset_format import CameraInfo
from .base import Camera, CameraError, Frame
from .common import BadFrameError, OpenCamera, checked_frame, vendor_module, within
from .features import FeatureValue, GenicamConfig, configure, data_set_pixels, set_checked
from .pixels import decode


class BaslerCameraConfig(GenicamConfig):
    """serial: of the camera, None = the first that is found. line, user_output: for a laser, e.g. "Line2" switched by
    "UserOutput1"; None = no output."""

    type: Literal["basler"] = "basler"
    serial: str | None = None
    line: str | None = None
    user_output: str = "UserOutput1"


def connect(config: BaslerCameraConfig) -> Camera:
    """Finds, opens and sets up the camera within `open_timeout_s`; CameraError."""
    pylon = vendor_module("pypylon.pylon", "basler")
    name = f"basler {config.serial or 'camera'}"
    device = within(config.open_timeout_s, lambda: _opened(pylon, config, name), name, _close)
    try:
        return BaslerCamera(pylon, device, config)
    except Exception as error:
        _close(device)
        if isinstance(error, CameraError):
            raise
        raise CameraError(f"{name}: cannot be set up: {error}") from error


class BaslerCamera(OpenCamera):
    """An open camera, its output line off."""

    def __init__(self, pylon: Any, device: Any, config: BaslerCameraConfig) -> None:
        """device: an open pylon.InstantCamera."""
        self._pylon, self._device, self._config = pylon, device, config
        self._features = _PylonFeatures(device.GetNodeMap())
        about = device.GetDeviceInfo()
        name = f"basler {about.GetModelName()} {about.GetSerialNumber()}"
        self._pixels = configure(self._features, config, name)
        super().__init__(
            CameraInfo(
                width=int(self._features.get("Width")),
                height=int(self._features.get("Height")),
                pixel_format=data_set_pixels(config.pixel_format),
                name=name,
            ),
            config.retries,
        )
        self._set_up_line()

    def _set_up_line(self) -> None:
        line, name = self._config.line, self.info.name
        if line is None:
            return
        self.set_line(False)
        set_checked(self._features, "LineSelector", line, name)
        if self._features.get("LineMode") != "Output":
            set_checked(self._features, "LineMode", "Output", name)
        set_checked(self._features, "LineSource", self._config.user_output, name)

    def _expose(self) -> Frame:
        pylon, device = self._pylon, self._device
        deadline = time.monotonic() + self._config.timeout_s
        try:
            device.StartGrabbingMax(1, pylon.GrabStrategy_OneByOne)
            requested = time.monotonic()
            if self._config.trigger == "software":
                device.WaitForFrameTriggerReady(_milliseconds_to(deadline), pylon.TimeoutHandling_Return)
                requested = time.monotonic()
                device.ExecuteSoftwareTrigger()
            result = device.RetrieveResult(_milliseconds_to(deadline), pylon.TimeoutHandling_Return)
            return self._frame(result, requested)
        except pylon.GenericException as error:
            raise self._lost(error) from error
        finally:
            with suppress(pylon.GenericException):  # a camera that is gone has stopped
                device.StopGrabbing()

    def _frame(self, result: Any, requested: float) -> Frame:
        if not result.IsValid():
            raise BadFrameError(f"no frame within {self._config.timeout_s:g} s")
        try:
            if not result.GrabSucceeded():
                raise BadFrameError(f"{result.GetErrorDescription()} (code 0x{result.GetErrorCode():x})")
            image = decode(result.GetArray(), result.GetWidth(), result.GetHeight(), self._pixels)
            return checked_frame(image, self._seconds(result.GetTimeStamp()), requested)
        finally:
            result.Release()

    def _seconds(self, ticks: int) -> float | None:
        """GigE cameras have ticks of their own, USB cameras nanoseconds; 0 = no clock (the emulator)."""
        if ticks == 0:
            return None
        name = "GevTimestampTickFrequency"
        return ticks / (float(self._features.get(name)) if self._features.has(name) else 1e9)

    def _lost(self, error: Exception) -> CameraError:
        if self._device.IsCameraDeviceRemoved():
            return CameraError(f"{self.info.name}: was unplugged or lost its power; connect it and open it anew")
        return CameraError(f"{self.info.name}: {error}")

    def set_line(self, on: bool) -> None:
        """Switches the output line of the configuration; CameraError where it names none."""
        if self._config.line is None:
            super().set_line(on)
        try:
            set_checked(self._features, "UserOutputSelector", self._config.user_output, self.info.name)
            set_checked(self._features, "UserOutputValue", on, self.info.name)
        except self._pylon.GenericException as error:
            raise self._lost(error) from error

    def close(self) -> None:
        """Switches the line off and releases the camera; never raises."""
        if self._config.line is not None:
            with suppress(CameraError):  # a camera that is gone has no line either
                self.set_line(False)
        _close(self._device)


class _PylonFeatures:
    def __init__(self, nodes: Any) -> None:
        self._nodes = nodes

    def has(self, name: str) -> bool:
        return bool(self._nodes.GetNode(name).IsValid())

    def get(self, name: str) -> FeatureValue:
        value: FeatureValue = self._nodes.GetNode(name).GetValue()
        return value

    def set(self, name: str, value: FeatureValue) -> None:
        self._nodes.GetNode(name).SetValue(value)

    def choices(self, name: str) -> Sequence[str]:
        return tuple(self._nodes.GetNode(name).GetSymbolics())


def _milliseconds_to(deadline: float) -> int:
    return max(1, round(1000 * (deadline - time.monotonic())))


def _opened(pylon: Any, config: BaslerCameraConfig, name: str) -> Any:
    factory = pylon.TlFactory.GetInstance()
    found = factory.EnumerateDevices()
    fitting = [about for about in found if config.serial in (None, about.GetSerialNumber())]
    if not fitting:
        serials = ", ".join(about.GetSerialNumber() for about in found) or "none"
        raise CameraError(
            f"{name}: is not found; cameras found: {serials}. Check power and cable, or the serial number."
        )
    device = pylon.InstantCamera(factory.CreateDevice(fitting[0]))
    device.Open()
    return device


def _close(device: Any) -> None:
    with suppress(Exception):  # a camera that is gone cannot be closed, and nobody can do more about it
        device.Close()
