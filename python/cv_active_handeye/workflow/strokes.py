# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Characteristic points of print: where the stripe crosses a dark stroke, from the two images of a view."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

import cv_active_handeye as cah

from ..dataset import Image
from ..files import FileFormatError, FloatArray
from ..measured_points import PointRow
from .measure import stripe_line
from .profiles import Profile, Profiler
from .reporter import InsufficientDataError

STROKE_SIGMA = 1.4
"""Expected standard deviation of a stroke's cross profile, px: 4 px of ink. Half to twice this is found."""

WINDOW = (18, 9)
"""Half size of the window around the crossing, across and along the stroke, px: without the next stroke in it."""

LEAST_SNR = 1.5
"""Of the smoothed profile: in so small a window the stroke itself counts as noise; contrast is what it has to have."""

LEAST_ROWS = 8
_PASSES = 3  # stripe and stroke are nearly perpendicular: each pass leaves a tenth of the error before


class Crossing(NamedTuple):
    """Where stripe and stroke cross: pixel (2,); sigmas (2,): standard deviations of u (stroke) and v (stripe), px."""

    pixel: FloatArray
    sigmas: FloatArray


def stroke_crossing(tool: Profiler, profile: Profile, pixel: FloatArray) -> Crossing:
    """The crossing of a horizontal stripe and a dark, about vertical stroke near `pixel` (2,), which is a rough click.

    The stripe is that of the laser image, the stroke that of the laser-off image: upside down in brightness it is a
    vertical stripe. Raises `InsufficientDataError` where the view has no laser-off image, no stroke or no stripe there,
    `FileFormatError` for a data set with vertical stripes.
    """
    if tool.along != 0:
        raise FileFormatError(f"{tool.dataset.folder}: needs a horizontal stripe across the strokes, has vertical ones")
    image = tool.dataset.image(profile.view)
    if image is None:
        raise InsufficientDataError(f"view {profile.view}: needs an image with the laser off to find strokes, has none")
    at = np.asarray(pixel, dtype=np.float64)
    for _ in range(_PASSES):
        on_stripe, _ = _on_line(profile, at, 0)
        at, along = _on_line(_stroke(tool, profile.view, image, on_stripe), on_stripe, 1)
    on_stripe, across = _on_line(profile, at, 0)
    return Crossing(on_stripe, np.array([along, across]))


def _on_line(profile: Profile, pixel: FloatArray, along: int) -> tuple[FloatArray, float]:
    """Where the line of the nearest piece passes `pixel` (2,), and its sigma across, px; `along`: 0 = u, 1 = v."""
    row = PointRow("crossing", "crossing", profile.view, float(pixel[0]), float(pixel[1]))
    try:
        return stripe_line(profile, row, along, 1.0)
    except FileFormatError as error:
        raise InsufficientDataError(str(error)) from error


def _stroke(tool: Profiler, view: int, image: Image, pixel: FloatArray) -> Profile:
    """Centre line of the dark stroke in the window around `pixel`, a point a row."""
    corner = np.maximum(np.rint(pixel).astype(int) - WINDOW, 0)
    end = corner + 2 * np.array(WINDOW) + 1
    inverted = np.invert(image[corner[1] : end[1], corner[0] : end[0]])
    params = cah.StripeParams()
    params.orientation, params.sigma = int(cah.STRIPE_VERTICAL), STROKE_SIGMA
    params.minSnr = LEAST_SNR
    points, sigmas = cah.detectStripe(inverted, params=params)
    points = points + corner
    K, D = tool.calibration.camera_matrix, tool.calibration.distortion_coefficients
    found = len(points) > 0
    pieces = cah.splitStripe(points, sigmas, K, D, minPoints=LEAST_ROWS) if found else np.zeros(0, np.int32)
    return Profile(view, points, sigmas.reshape(-1), pieces.reshape(-1), np.zeros(len(points), np.float32))
