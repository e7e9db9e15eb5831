# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Procedural albedo textures: several octaves of noise, dead leaves with sharp edges, scratches and print."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Float32Image = NDArray[np.float32]

_SUBPIXEL_BITS = 4
_PREFILTER_TEXELS = 0.8  # the texture holds nothing a pixel of the default camera would alias
_SMALLEST_LEAF_TEXELS = 2.0
_ALBEDO_RANGE = (0.07, 0.92)


@dataclass(frozen=True)
class Style:
    """How a material looks. Coverages are fractions of the area, contrasts are albedo."""

    albedo: float
    noise: float = 0.06
    leaf_cover: float = 0.5
    leaf_contrast: float = 0.15
    leaf_radius_mm: tuple[float, float] = (0.5, 7.0)
    scratches_per_cm2: float = 0.6
    glyphs_per_cm2: float = 0.0
    glyph_mm: tuple[float, float] = (2.0, 8.0)
    grain: float = 0.025


STYLES: dict[str, Style] = {
    "bench": Style(albedo=0.50, noise=0.07, leaf_cover=0.7, leaf_contrast=0.15, scratches_per_cm2=1.0),
    "steel": Style(albedo=0.58, noise=0.05, leaf_cover=0.5, leaf_contrast=0.13, scratches_per_cm2=3.0),
    "rust": Style(albedo=0.42, noise=0.13, leaf_cover=1.6, leaf_contrast=0.13, leaf_radius_mm=(0.4, 4.0)),
    "card": Style(albedo=0.62, noise=0.04, leaf_cover=0.30, leaf_contrast=0.12, glyphs_per_cm2=1.5),
    "label": Style(albedo=0.78, noise=0.03, leaf_cover=0.10, leaf_contrast=0.10, glyphs_per_cm2=5.0, glyph_mm=(2, 4)),
    "paper": Style(albedo=0.75, noise=0.012, leaf_cover=0.02, leaf_contrast=0.03, scratches_per_cm2=0.0, grain=0.008),
    "paint": Style(albedo=0.31, noise=0.05, leaf_cover=0.6, leaf_contrast=0.20, scratches_per_cm2=2.5),
    "stone": Style(albedo=0.46, noise=0.08, leaf_cover=2.5, leaf_contrast=0.17, scratches_per_cm2=0.2),
}


def synthesize(style: Style, shape: tuple[int, int], texel_mm: float, rng: np.random.Generator) -> Float32Image:
    """Return an albedo image, band-limited to about two texels, that repeats nowhere.

    style: the material; shape: (rows, columns); texel_mm: edge of one texel in mm; rng: source of all randomness.
    """
    image = np.full(shape, round(255 * style.albedo), np.uint8)
    _draw_leaves(image, style, texel_mm, rng)
    _draw_scratches(image, style, texel_mm, rng)
    _draw_glyphs(image, style, texel_mm, rng)
    albedo = image.astype(np.float32) / 255.0
    albedo *= 1.0 + style.noise / style.albedo * _octaves(shape, texel_mm, rng)
    albedo += style.grain * rng.standard_normal(shape, dtype=np.float32) * 2.0
    return _band_limited(albedo)


def tile(shape: tuple[int, int], texel_mm: float, rng: np.random.Generator, period_mm: float) -> Float32Image:
    """Return an albedo image that repeats one square of `period_mm` without seams (`rng` decides the square)."""
    period = max(8, round(period_mm / texel_mm))
    margin = max(4, period // 4)
    one = synthesize(STYLES["stone"], (period + margin, period + margin), texel_mm, rng)
    ramp = (np.arange(margin, dtype=np.float32) + 0.5) / margin
    one[:, :margin] = ramp * one[:, :margin] + (1 - ramp) * one[:, period:]
    one = one[:, :period]
    one[:margin] = ramp[:, None] * one[:margin] + (1 - ramp[:, None]) * one[period:]
    one = one[:period]
    repeats = (-(-shape[0] // period), -(-shape[1] // period))
    return np.ascontiguousarray(np.tile(one, repeats)[: shape[0], : shape[1]])


def _band_limited(albedo: Float32Image) -> Float32Image:
    smooth = cv2.GaussianBlur(albedo, (0, 0), _PREFILTER_TEXELS)
    return np.clip(smooth, *_ALBEDO_RANGE).astype(np.float32)


def _octaves(shape: tuple[int, int], texel_mm: float, rng: np.random.Generator) -> Float32Image:
    """Noise of unit variance with equal power in octaves of 1 to 64 mm."""
    total = np.zeros(shape, np.float32)
    wavelengths = 2.0 ** np.arange(0, 7)
    for wavelength in wavelengths:
        cells = [int(size * texel_mm / wavelength) + 4 for size in shape]
        coarse = rng.standard_normal(cells, dtype=np.float32)
        total += cv2.resize(coarse, (shape[1], shape[0]), interpolation=cv2.INTER_CUBIC)
    return total / np.float32(np.sqrt(len(wavelengths)))


def _draw_leaves(image: NDArray[np.uint8], style: Style, texel_mm: float, rng: np.random.Generator) -> None:
    """Dead leaves: shapes of power-law size on top of each other, as in photographs of nature."""
    area_mm2 = image.size * texel_mm**2
    low, high = max(style.leaf_radius_mm[0], _SMALLEST_LEAF_TEXELS * texel_mm), style.leaf_radius_mm[1]
    mean_area = np.pi * 2 * np.log(high / low) / (low**-2 - high**-2)  # of p(r) ~ r^-3
    count = round(style.leaf_cover * area_mm2 / mean_area)
    radius = (low**-2 - rng.random(count) * (low**-2 - high**-2)) ** -0.5 / texel_mm
    radius = -np.sort(-radius) if style.leaf_cover < 1.0 else radius
    centre = rng.random((count, 1, 2)) * (image.shape[1], image.shape[0])
    grey = 255 * np.clip(style.albedo + style.leaf_contrast * rng.standard_normal(count), 0.03, 0.95)
    corners, outline = _outlines(count, rng)
    points = np.round((centre + radius[:, None, None] * outline) * (1 << _SUBPIXEL_BITS)).astype(np.int32)
    for n, shape, g in zip(corners, points, grey, strict=True):
        cv2.fillPoly(image, [shape[:n]], float(g), cv2.LINE_AA, _SUBPIXEL_BITS)


def _outlines(count: int, rng: np.random.Generator) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Unit outlines (count, 12, 2), of which the first `corners` points count: angular and round blobs, stretched."""
    corners = rng.choice(np.array([3, 4, 5, 7, 12]), count)
    turn = rng.uniform(0, 2 * np.pi, (count, 1))
    stretch = rng.uniform(0.5, 1.6, (count, 1))
    radius = rng.uniform(0.7, 1.2, (count, 12))
    angle = 2 * np.pi * np.arange(12) / corners[:, None]
    x, y = radius * np.cos(angle) * stretch, radius * np.sin(angle) / stretch
    c, s = np.cos(turn), np.sin(turn)
    return corners, np.stack([c * x - s * y, s * x + c * y], axis=-1)


def _draw_scratches(image: NDArray[np.uint8], style: Style, texel_mm: float, rng: np.random.Generator) -> None:
    count = round(style.scratches_per_cm2 * image.size * texel_mm**2 / 100)
    start = rng.random((count, 2)) * (image.shape[1], image.shape[0])
    angle = rng.normal(0.3, 0.5, count)
    length = rng.exponential(9.0, count) / texel_mm
    ends = start + length[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    grey = 255 * np.clip(style.albedo + rng.choice([-0.2, 0.25], count) * rng.uniform(0.4, 1, count), 0.03, 0.95)
    width = rng.choice([1, 1, 2, 3], count)
    for a, b, g, w in zip(start, ends, grey, width, strict=True):
        p, q = np.round([a, b]).astype(int)
        cv2.line(image, (int(p[0]), int(p[1])), (int(q[0]), int(q[1])), float(g), int(w), cv2.LINE_AA)


def _draw_glyphs(image: NDArray[np.uint8], style: Style, texel_mm: float, rng: np.random.Generator) -> None:
    count = round(style.glyphs_per_cm2 * image.size * texel_mm**2 / 100)
    letters = "ABCDEFGHKLMNPRSTUVXYZ0123456789"
    for _ in range(count):
        text = "".join(rng.choice(list(letters), int(rng.integers(1, 5))))
        where = (int(rng.integers(image.shape[1])), int(rng.integers(image.shape[0])))
        scale = float(rng.uniform(*style.glyph_mm)) / texel_mm / 22.0  # height in mm; the font is 22 units high
        grey = 255 * float(np.clip(style.albedo - rng.uniform(0.25, 0.5), 0.05, 0.9))
        cv2.putText(image, text, where, cv2.FONT_HERSHEY_DUPLEX, scale, grey, max(1, round(scale * 2)), cv2.LINE_AA)
