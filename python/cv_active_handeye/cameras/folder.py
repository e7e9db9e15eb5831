# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A folder of images as a camera: the next one, in the order of their names, for every grab."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Literal

import cv2
import numpy as np

from ..dataset import Image
from ..dataset_format import CameraInfo
from .base import Camera, CameraError, Frame
from .common import OpenCamera, StrictConfig, checked_frame, pixel_format_of

SUFFIXES = (".png", ".tif", ".tiff", ".bmp", ".jpg", ".jpeg", ".pgm", ".ppm")


class FolderCameraConfig(StrictConfig):
    """folder: all its images (`SUFFIXES`) are shown once, sorted by name; they keep their bit depth and channels."""

    type: Literal["folder"] = "folder"
    folder: Path


def connect(config: FolderCameraConfig) -> Camera:
    """Lists the images and reads the first; CameraError where there is none."""
    name = f"folder {config.folder}"
    try:
        files = sorted(file for file in config.folder.iterdir() if file.suffix.lower() in SUFFIXES)
    except OSError as error:
        raise CameraError(f"{name}: cannot be listed: {error.strerror}; give an existing folder") from error
    if not files:
        raise CameraError(f"{name}: has no image; needed: files that end with {', '.join(SUFFIXES)}")
    first = _read(files[0], name)
    height, width = first.shape[:2]
    info = CameraInfo(width=width, height=height, pixel_format=pixel_format_of(first, name), name=name)
    return FolderCamera(files, info)


class FolderCamera(OpenCamera):
    """Frames were exposed long ago: `requested` and `received` only say when they were read."""

    def __init__(self, files: list[Path], info: CameraInfo) -> None:
        """files: in the order in which they are shown."""
        super().__init__(info, retries=0)
        self._files = files
        self._shown = 0

    def _expose(self) -> Frame:
        requested = time.monotonic()
        if self._shown == len(self._files):
            raise CameraError(f"{self.info.name}: all {self._shown} images have been shown; add images or open it anew")
        image = _read(self._files[self._shown], self.info.name)
        self._shown += 1
        return checked_frame(image, None, requested)

    def close(self) -> None:
        """Nothing is held open."""


def _read(file: Path, name: str) -> Image:
    image = cv2.imread(str(file), cv2.IMREAD_UNCHANGED)
    if image is None:
        raise CameraError(f"{name}: {file.name} is not an image OpenCV can read; remove or replace it")
    pixel_format_of(image, f"{name}, {file.name}")
    return np.asarray(image, np.uint8) if image.dtype == np.uint8 else np.asarray(image, np.uint16)
