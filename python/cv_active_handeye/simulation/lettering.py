# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Print: letters of straight strokes whose centre lines are known exactly, and marks on them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import erfc

from .parts import Array

INK = 0.07
"""Albedo of the print."""

_EDGE_TEXELS = 0.8  # blur of the print's edges, as that of the textures
_REACH_TEXELS = 5.0  # beyond its edge a stroke leaves no trace
_WIDTH = 0.60  # of a letter, of its height

_LETTERS: dict[str, tuple[tuple[float, float, float, float], ...]] = {
    "A": ((0, 0, 0.5, 1), (0.5, 1, 1, 0), (0.2, 0.4, 0.8, 0.4)),
    "D": ((0, 0, 0, 1), (0, 1, 0.6, 1), (0.6, 1, 1, 0.7), (1, 0.7, 1, 0.3), (1, 0.3, 0.6, 0), (0.6, 0, 0, 0)),
    "E": ((0, 0, 0, 1), (0, 1, 1, 1), (0, 0.5, 0.8, 0.5), (0, 0, 1, 0)),
    "F": ((0, 0, 0, 1), (0, 1, 1, 1), (0, 0.52, 0.8, 0.52)),
    "H": ((0, 0, 0, 1), (1, 0, 1, 1), (0, 0.5, 1, 0.5)),
    "I": ((0.5, 0, 0.5, 1), (0.2, 1, 0.8, 1), (0.2, 0, 0.8, 0)),
    "K": ((0, 0, 0, 1), (0, 0.45, 1, 1), (0.25, 0.6, 1, 0)),
    "L": ((0, 0, 0, 1), (0, 0, 1, 0)),
    "M": ((0, 0, 0, 1), (0, 1, 0.5, 0.3), (0.5, 0.3, 1, 1), (1, 1, 1, 0)),
    "N": ((0, 0, 0, 1), (0, 1, 1, 0), (1, 0, 1, 1)),
    "P": ((0, 0, 0, 1), (0, 1, 0.7, 1), (0.7, 1, 1, 0.8), (1, 0.8, 0.7, 0.5), (0.7, 0.5, 0, 0.5)),
    "T": ((0.5, 0, 0.5, 1), (0, 1, 1, 1)),
    "V": ((0, 1, 0.5, 0), (0.5, 0, 1, 1)),
    "X": ((0, 0, 1, 1), (0, 1, 1, 0)),
}
"""Strokes (x0, y0, x1, y1) in units of the letter's width and height; that of the stem is the first one."""


@dataclass(frozen=True)
class Mark:
    """A place on a stroke: position (3,), direction of the centre line (3,), normal of the surface (3,), unit length.

    Frame of the scene, metres.
    """

    name: str
    position: Array
    along: Array
    normal: Array


def letter_width(height: float) -> float:
    """Width of all letters of a height, without their strokes' own width."""
    return _WIDTH * height


def letter(which: str, height: float, where: Array) -> Array:
    """Strokes (N, 2, 3) of a letter whose lower left corner is the origin of `where` (4, 4), its stem's first."""
    strokes = np.array(_LETTERS[which]).reshape(-1, 2, 2) * [letter_width(height), height]
    return np.asarray(strokes @ where[:3, :2].T + where[:3, 3])


def letters() -> str:
    """All letters there are."""
    return "".join(_LETTERS)


def mark(name: str, stroke: Array, share: float, where: Array) -> Mark:
    """The mark at `share` (0 to 1) of a stroke (2, 3) on the x-y plane of `where` (4, 4)."""
    along = (stroke[1] - stroke[0]) / np.linalg.norm(stroke[1] - stroke[0])
    return Mark(name, stroke[0] + share * (stroke[1] - stroke[0]), along, where[:3, 2].copy())


def print_on(albedo: NDArray[np.float32], ends: Array, widths: Array) -> NDArray[np.float32]:
    """The albedo image (rows along v, columns along u) with strokes printed on it.

    ends (N, 2, 2): (u, v) of the strokes' ends in texels, round beyond; widths (N,): texels. Every edge is a step of
    ink blurred as the textures are, at its exact place, so that a stroke is symmetric about its centre line.
    """
    ink = np.zeros(albedo.shape)
    for (start, end), width in zip(ends, widths, strict=True):
        reach = width / 2 + _REACH_TEXELS
        low = np.maximum(np.floor(np.minimum(start, end) - reach), 0).astype(int)
        high = np.minimum(np.ceil(np.maximum(start, end) + reach) + 1, albedo.shape[::-1]).astype(int)
        window = np.s_[low[1] : high[1], low[0] : high[0]]
        grid = np.stack(np.meshgrid(np.arange(low[0], high[0]), np.arange(low[1], high[1])), axis=-1)
        edge = _distance(grid, start, end) - width / 2
        ink[window] = np.maximum(ink[window], 0.5 * erfc(edge / (np.sqrt(2) * _EDGE_TEXELS)))
    return np.asarray(albedo + ink * (INK - albedo), dtype=np.float32)


def _distance(points: NDArray[np.int64], start: Array, end: Array) -> Array:
    """Distance of points (..., 2) from the straight piece between two points (2,)."""
    piece = end - start
    share = np.clip((points - start) @ piece / (piece @ piece), 0, 1)
    return np.asarray(np.linalg.norm(points - start - share[..., None] * piece, axis=-1))
