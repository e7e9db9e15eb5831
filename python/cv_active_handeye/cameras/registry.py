# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""All kinds of cameras by their `type`."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from . import basler, folder, genicam, opencv, simulated
from .base import Camera
from .basler import BaslerCameraConfig
from .folder import FolderCameraConfig
from .genicam import GenicamCameraConfig
from .opencv import OpencvCameraConfig
from .simulated import SimulatedCameraConfig

CameraConfig = Annotated[
    OpencvCameraConfig | BaslerCameraConfig | GenicamCameraConfig | FolderCameraConfig | SimulatedCameraConfig,
    Field(discriminator="type"),
]


def open_camera(config: CameraConfig) -> Camera:
    """Opens the camera of a configuration within its `open_timeout_s`; CameraError. Vendor libraries load only now."""
    if isinstance(config, OpencvCameraConfig):
        return opencv.connect(config)
    if isinstance(config, BaslerCameraConfig):
        return basler.connect(config)
    if isinstance(config, GenicamCameraConfig):
        return genicam.connect(config)
    if isinstance(config, FolderCameraConfig):
        return folder.connect(config)
    return simulated.connect(config)
