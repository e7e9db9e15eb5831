# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Any GenICam camera by its maker's GenTL producer (.cti file) and harvesters (extra `genicam`).

Every grab starts the acquisition, triggers it where there is a trigger, takes the first frame and ends the acquisition:
no frame of before can be waiting in a queue.
"""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, Literal

from ..dataset_format import CameraInfo
from .base import Camera, CameraError, Frame
from .common import BadFrameError, OpenCamera, checked_frame, vendor_module, within
from .features import FeatureValue, GenicamConfig, configure, data_set_pixels
from .pixels import decode

_SEARCH_PATH = "GENICAM_GENTL64_PATH"  # where the GenTL standard has producers put themselves


class GenicamCameraConfig(GenicamConfig):
    """producers: .cti files; none = all in the folders of GENICAM_GENTL64_PATH. device: its id, serial number or model;
    None = the first that is found."""

    type: Literal["genicam"] = "genicam"
    producers: tuple[Path, ...] = ()
    device: str | None = None


def connect(config: GenicamCameraConfig) -> Camera:
    """Loads the producers, opens and sets up the camera within `open_timeout_s`; CameraError."""
    harvesters = vendor_module("harvesters.core", "genicam")
    name = f"genicam {config.device or 'camera'}"
    files = _producers(config, name)
    harvester, acquirer = within(
        config.open_timeout_s, lambda: _opened(harvesters, files, config.device, name), name, lambda both: _close(*both)
    )
    try:
        return GenicamCamera(harvester, acquirer, config)
    except Exception as error:
        _close(harvester, acquirer)
        if isinstance(error, CameraError):
            raise
        raise CameraError(f"{name}: cannot be set up: {error}") from error


class GenicamCamera(OpenCamera):
    """An open camera."""

    def __init__(self, harvester: Any, acquirer: Any, config: GenicamCameraConfig) -> None:
        """acquirer: a harvesters.core.ImageAcquirer of `harvester`."""
        self._harvester, self._acquirer, self._config = harvester, acquirer, config
        self._features = _HarvesterFeatures(acquirer.remote_device.node_map)
        about = acquirer.remote_device.parent
        name = f"genicam {about.vendor} {about.model} {about.id_}"
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

    def _expose(self) -> Frame:
        requested = time.monotonic()
        try:
            self._acquirer.start()
            if self._config.trigger == "software":
                requested = time.monotonic()
                self._features.execute("TriggerSoftware")
            buffer = self._acquirer.try_fetch(timeout=self._config.timeout_s)
            return self._frame(buffer, requested)
        except (BadFrameError, CameraError):
            raise
        except Exception as error:  # producers raise whatever they like
            raise CameraError(f"{self.info.name}: {error}. Check power and cable, then open it anew.") from error
        finally:
            with suppress(Exception):  # a camera that is gone has stopped
                self._acquirer.stop()

    def _frame(self, buffer: Any, requested: float) -> Frame:
        if buffer is None:
            raise BadFrameError(f"no frame within {self._config.timeout_s:g} s")
        try:
            if not buffer.is_complete():
                raise BadFrameError("an incomplete frame arrived")
            component = buffer.payload.components[0]
            image = decode(component.data, component.width, component.height, component.data_format)
            return checked_frame(image, _camera_time(buffer), requested)
        finally:
            buffer.queue()

    def close(self) -> None:
        """Releases camera and producers; never raises."""
        _close(self._harvester, self._acquirer)


class _HarvesterFeatures:
    def __init__(self, nodes: Any) -> None:
        self._nodes = nodes

    def has(self, name: str) -> bool:
        return bool(self._nodes.has_node(name))

    def get(self, name: str) -> FeatureValue:
        value: FeatureValue = getattr(self._nodes, name).value
        return value

    def set(self, name: str, value: FeatureValue) -> None:
        getattr(self._nodes, name).value = value

    def choices(self, name: str) -> Sequence[str]:
        return tuple(getattr(self._nodes, name).symbolics)

    def execute(self, name: str) -> None:
        getattr(self._nodes, name).execute()


def _camera_time(buffer: Any) -> float | None:
    """Seconds; a camera without clock says 0, or its producer raises what it likes."""
    try:
        return buffer.timestamp_ns / 1e9 or None
    except Exception:
        return None


def _producers(config: GenicamCameraConfig, name: str) -> list[Path]:
    if config.producers:
        missing = [str(file) for file in config.producers if not file.is_file()]
        if missing:
            raise CameraError(f"{name}: there is no producer file {', '.join(missing)}")
        return list(config.producers)
    folders = [Path(folder) for folder in os.environ.get(_SEARCH_PATH, "").split(os.pathsep) if folder]
    files = [file for folder in folders for file in sorted(folder.glob("*.cti"))]
    if not files:
        raise CameraError(f"{name}: no GenTL producer; install that of the camera's maker, or name its .cti file")
    return files


def _opened(harvesters: Any, files: list[Path], device: str | None, name: str) -> tuple[Any, Any]:
    harvester = harvesters.Harvester()
    try:
        for file in files:
            harvester.add_file(str(file), check_validity=True)
        harvester.update()
        found = harvester.device_info_list
        fitting = [i for i, one in enumerate(found) if device in (None, one.id_, one.serial_number, one.model)]
        if not fitting:
            ids = ", ".join(one.id_ for one in found) or "none"
            raise CameraError(f"{name}: is not found; cameras found: {ids}. Check power and cable, or the name.")
        return harvester, harvester.create(fitting[0])
    except Exception:
        harvester.reset()
        raise


def _close(harvester: Any, acquirer: Any) -> None:
    for release in (acquirer.destroy, harvester.reset):
        with suppress(Exception):  # a camera that is gone cannot be closed, and nobody can do more about it
            release()
