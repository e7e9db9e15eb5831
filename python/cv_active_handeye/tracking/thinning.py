# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Leaving out tracks whose patches overlap: they see the same pixels, so their errors are nearly the same."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from .features import Array


def independent_tracks(points: Array, sigmas: Array, size: tuple[int, int], distance: float) -> NDArray[np.bool_]:
    """Which of N tracks to keep so that in every view their points are at least `distance` pixels apart, (N,).

    points (V, N, 2), sigmas (V, N): pixels, NaN = not seen; size: width and height of the images. Of two that are too
    near the one that says more (sum of 1 / sigma^2) stays. Distances are exact to a pixel.
    """
    seen = np.isfinite(sigmas)
    keep = np.ones(points.shape[1], np.bool_)
    if distance <= 0:
        return keep
    information = np.where(seen, 1.0 / np.where(seen, sigmas, 1.0) ** 2, 0.0).sum(axis=0)
    pixels = np.clip(np.rint(np.where(seen[:, :, None], points, 0.0)).astype(np.int64), 0, np.array(size) - 1)
    taken = np.zeros((len(points), size[1], size[0]), np.uint8)
    for track in np.argsort(-information, kind="stable"):
        views = np.flatnonzero(seen[:, track])
        x, y = pixels[views, track].T
        keep[track] = not taken[views, y, x].any()
        if keep[track]:
            for view, u, v in zip(views, x, y, strict=True):
                cv2.circle(taken[view], (int(u), int(v)), round(distance), 1, cv2.FILLED)
    return keep
