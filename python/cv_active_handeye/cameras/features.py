# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Settings of a GenICam camera by their standard names (SFNC), each read back."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal, Protocol

from pydantic import Field

from ..dataset_format import PixelFormat
from .base import CameraError
from .common import DeviceConfig
from .pixels import CANDIDATES, WantedPixels

FeatureValue = bool | int | float | str


class Features(Protocol):
    """The node map of a camera, whoever's library reads it; errors of that library pass through."""

    def has(self, name: str) -> bool:
        """Whether the camera has it."""
        ...

    def get(self, name: str) -> FeatureValue:
        """Its value."""
        ...

    def set(self, name: str, value: FeatureValue) -> None:
        """Writes it."""
        ...

    def choices(self, name: str) -> Sequence[str]:
        """The values of an enumeration that can be chosen now."""
        ...


class GenicamConfig(DeviceConfig):
    """Settings that all GenICam cameras understand; None leaves the camera as it is.

    exposure_us, gain_db: switch the automatic ones off. pixel_format: 10, 12 and 16 bit arrive as 16 bit, "bgr8" takes
    any 8-bit colour or Bayer format. trigger: "software", or "none" for a camera without trigger, where every grab
    starts the acquisition anew and takes its first frame. features: anything else by the camera's own names, set before
    all others and in this order.
    """

    width: int | None = Field(default=None, gt=0)
    height: int | None = Field(default=None, gt=0)
    exposure_us: float | None = Field(default=None, gt=0)
    gain_db: float | None = None
    pixel_format: WantedPixels = "mono8"
    trigger: Literal["software", "none"] = "software"
    features: Mapping[str, FeatureValue] = Field(default_factory=dict)


def set_checked(features: Features, name: str, value: FeatureValue, camera: str) -> None:
    """Sets a feature and reads it back; numbers may be rounded by 1 %. CameraError says what the camera makes of it."""
    if not features.has(name):
        raise CameraError(f"{camera}: has no feature {name}; leave it out of the settings, or look up its name")
    try:
        features.set(name, value)
        given = features.get(name)
    except Exception as error:
        raise CameraError(f"{camera}: {name} cannot be set to {value!r}: {error}") from error
    if not _same(value, given):
        raise CameraError(f"{camera}: {name} was set to {value!r}, the camera says {given!r}; choose what it offers")


def _same(value: FeatureValue, given: FeatureValue) -> bool:
    if isinstance(value, float) and isinstance(given, (int, float)):
        return abs(given - value) <= 0.01 * abs(value)
    return value == given


def configure(features: Features, config: GenicamConfig, camera: str) -> str:
    """Applies all settings and returns the camera's own name of the pixel format; CameraError."""
    for name, value in config.features.items():
        set_checked(features, name, value, camera)
    for name, size in (("Width", config.width), ("Height", config.height)):
        if size is not None:
            set_checked(features, name, size, camera)
    pixels = _set_pixel_format(features, config.pixel_format, camera)
    if config.exposure_us is not None:
        _switch_off(features, "ExposureAuto", camera)
        newer = features.has("ExposureTime")
        set_checked(features, "ExposureTime" if newer else "ExposureTimeAbs", config.exposure_us, camera)
    if config.gain_db is not None:
        _switch_off(features, "GainAuto", camera)
        set_checked(features, "Gain", config.gain_db, camera)
    _set_trigger(features, config.trigger == "software", camera)
    return pixels


def _set_pixel_format(features: Features, wanted: WantedPixels, camera: str) -> str:
    offered = features.choices("PixelFormat")
    fitting = [name for name in CANDIDATES[wanted] if name in offered]
    if not fitting:
        raise CameraError(f"{camera}: pixel_format {wanted} is not among what it offers: {', '.join(offered)}")
    if features.get("PixelFormat") != fitting[0]:
        set_checked(features, "PixelFormat", fitting[0], camera)
    return fitting[0]


def _switch_off(features: Features, name: str, camera: str) -> None:
    if features.has(name):
        set_checked(features, name, "Off", camera)


def _set_trigger(features: Features, software: bool, camera: str) -> None:
    if not features.has("TriggerMode"):
        if software:
            raise CameraError(f"{camera}: has no trigger; choose trigger: none")
        return
    set_checked(features, "TriggerSelector", "FrameStart", camera)
    set_checked(features, "TriggerMode", "On" if software else "Off", camera)
    if software:
        set_checked(features, "TriggerSource", "Software", camera)


def data_set_pixels(wanted: WantedPixels) -> PixelFormat:
    """The data set's pixel format for a wanted one."""
    formats: dict[WantedPixels, PixelFormat] = {"mono8": "mono8", "bgr8": "bgr8"}
    return formats.get(wanted, "mono16")
