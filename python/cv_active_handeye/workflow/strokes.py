# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Characteristic points of print: where the stripe crosses a dark stroke, from the two images of a view."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

import cv_active_handeye as cah

from ..dataset import Image
from ..files import FileFormatError, FloatArray
from .measure import nothing_near
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
    along = 0.0
    for _ in range(_PASSES):
        on_stripe, _ = _on_line(tool, profile, at, int(cah.STRIPE_HORIZONTAL))
        stroke = _stroke(tool, profile.view, image, on_stripe)
        at, spread = _on_line(tool, stroke, on_stripe, int(cah.STRIPE_VERTICAL))
        along = float(np.sqrt(spread[0, 0]))
    on_stripe, spread = _on_line(tool, profile, at, int(cah.STRIPE_HORIZONTAL))
    return Crossing(on_stripe, np.array([along, np.sqrt(spread[1, 1])]))


def _on_line(tool: Profiler, profile: Profile, pixel: FloatArray, orientation: int) -> tuple[FloatArray, FloatArray]:
    """Where the line of the nearest piece passes `pixel` (2,), and its covariance (2, 2) px^2."""
    found, spread = tool.on_line(profile, pixel, orientation=orientation)
    if not np.isfinite(found).all():
        raise InsufficientDataError(nothing_near(profile, pixel))
    return found, spread


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
