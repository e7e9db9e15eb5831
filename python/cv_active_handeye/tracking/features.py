# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Features of one image: SIFT positions and descriptors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from .config import TrackingConfig

Array = NDArray[np.float64]
Array32 = NDArray[np.float32]

BRIGHT = 200.0
BGR_TO_GREY = np.array([0.114, 0.587, 0.299], np.float32)  # ITU-R BT.601


@dataclass(frozen=True)
class Features:
    """n features of one image.

    points (n, 2): pixels, centres at integers; descriptors (n, 128): RootSIFT, unit length.
    """

    points: Array
    descriptors: Array32

    def __len__(self) -> int:
        return len(self.points)


def grey_image(image: NDArray[np.generic], name: str) -> Array32:
    """Grey values as float32. image: 8 or 16 bit, one channel or three (BGR); `name` is for errors."""
    if image.dtype not in (np.uint8, np.uint16):
        raise ValueError(f"{name}: need uint8 or uint16 pixels, got {image.dtype}")
    if not (image.ndim == 2 or (image.ndim == 3 and image.shape[2] in (1, 3))) or min(image.shape[:2]) < 32:
        raise ValueError(f"{name}: need H x W or H x W x 3 of at least 32 x 32 pixels, got shape {image.shape}")
    grey = np.ascontiguousarray(image).astype(np.float32)
    if grey.ndim == 3:
        grey = grey @ BGR_TO_GREY if grey.shape[2] == 3 else grey[:, :, 0]
    return np.ascontiguousarray(grey, np.float32)


def normalise_brightness(greys: Sequence[Array32]) -> list[Array32]:
    """Scale the images of a recording by one common factor, so that the brightest 0.5 % of all pixels lie above 200.

    SIFT's contrast threshold is absolute: without this, dark or 16-bit recordings would give no features, or all noise.
    """
    bright = float(np.percentile(np.concatenate([grey[::4, ::4].ravel() for grey in greys]), 99.5))
    factor = np.float32(BRIGHT / max(bright, 1.0))
    return [grey * factor for grey in greys]


def detect_features(grey: Array32, config: TrackingConfig) -> Features:
    """Features of an image with grey values of 0 to 255.

    SIFT with precise upscaling: without it, OpenCV's positions are biased by 0.25 px in x and y.
    """
    detector = cv2.SIFT.create(
        nfeatures=config.max_features,
        contrastThreshold=config.contrast_threshold,
        enable_precise_upscale=True,
    )
    keypoints, descriptors = detector.detectAndCompute(np.asarray(np.clip(np.rint(grey), 0, 255), np.uint8), None)
    if not keypoints:
        return Features(np.empty((0, 2)), np.empty((0, 128), np.float32))
    points = np.array([k.pt for k in keypoints], np.float64)
    root = np.sqrt(descriptors / np.maximum(descriptors.sum(axis=1, keepdims=True), 1e-6))
    return Features(points, np.ascontiguousarray(root, np.float32))
