# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Sub-pixel refinement: every observation of a track is aligned to one reference patch of the track."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from .config import TrackingConfig
from .features import Array, Array32
from .matching import Indices
from .patches import UPSAMPLING, Alignment, Warps, align, make_templates, upsample

SIGMA_FLOOR = 0.02
SIGMA_SCALE = 1.0
MAX_LAST_STEP_PX = 0.02
MAX_SHAPE_CHANGE = 0.4


@dataclass
class Observations:
    """Positions (V, N, 2) and standard deviations per axis (V, N) of N tracks, NaN = not seen; reference view (N,)."""

    points: Array
    sigmas: Array
    reference: Indices


def refine_tracks(
    images: Sequence[Array32], points: Array, config: TrackingConfig, progress: Callable[[int], None]
) -> Observations:
    """Align all observations to the reference patch of their track.

    points (V, N, 2): detected positions, NaN = not seen. The track *is* the scene point at the centre of its reference
    patch, a pixel nearest to the detected feature; so its position in the reference view is exact by definition and
    only the agreement of the other views with it matters. `progress` is told every finished view.
    """
    warps = view_warps(points)
    reference = choose_references(points, warps)
    refined, sigmas = np.full_like(points, np.nan), np.full(points.shape[:2], np.nan)
    enlarged = [upsample(image) for image in images]
    for view, image in enumerate(images):
        tracks = np.flatnonzero(reference == view)
        centres = np.rint(points[view, tracks])
        inside = _inside(centres, image.shape, config.patch_radius + 1)
        tracks, centres = tracks[inside], centres[inside]
        if len(tracks):
            _refine_from(view, tracks, centres, enlarged, points, warps, config, refined, sigmas)
        progress(view)
    return Observations(refined, sigmas, reference)


def view_warps(points: Array) -> dict[tuple[int, int], Array]:
    """Homography from view a to view b for every ordered pair with enough common tracks, as a first guess of how
    patches are turned, scaled and foreshortened; the scene need not be a plane."""
    seen = np.isfinite(points[:, :, 0])
    warps: dict[tuple[int, int], Array] = {}
    for a in range(len(points)):
        for b in range(a + 1, len(points)):
            both = seen[a] & seen[b]
            if np.count_nonzero(both) < 8:
                continue
            homography, _ = cv2.findHomography(points[a, both], points[b, both], cv2.USAC_MAGSAC, 10.0)
            if homography is not None:
                warps[a, b], warps[b, a] = homography, np.linalg.inv(homography)
    return warps


def choose_references(points: Array, warps: dict[tuple[int, int], Array]) -> Indices:
    """Reference view of every track: the one from which the others look least scaled and foreshortened."""
    views = len(points)
    cost = np.full((views, views), 2.0)
    np.fill_diagonal(cost, 0.0)
    centre = np.nanmean(points.reshape(-1, 2), axis=0, keepdims=True)
    for (a, b), homography in warps.items():
        stretch = np.log(np.linalg.svd(local_warps(homography, centre)[0][0], compute_uv=False))
        cost[a, b] = np.abs(stretch).max()
    seen = np.isfinite(points[:, :, 0])
    total = np.where(seen, cost @ seen, np.inf)
    return np.asarray(total.argmin(axis=0), np.int64)


def _refine_from(
    view: int,
    tracks: Indices,
    centres: Array,
    enlarged: Sequence[Array32],
    points: Array,
    warps: dict[tuple[int, int], Array],
    config: TrackingConfig,
    refined: Array,
    sigmas: Array,
) -> None:
    templates = make_templates(enlarged[view], centres, config.patch_radius)
    own_variance = np.full((len(points), len(tracks)), np.nan)
    for other in range(len(points)):
        index = np.flatnonzero(np.isfinite(points[other, tracks, 0]))
        if other == view or (view, other) not in warps or len(index) == 0:
            continue
        shape, perspective = local_warps(warps[view, other], centres[index])
        rounding = centres[index] - points[view, tracks[index]]
        position = points[other, tracks[index]] + np.einsum("nij,nj->ni", shape, rounding)
        start = Warps(position, shape, perspective)
        found = align(templates[index], enlarged[other], start, config.max_iterations)
        variance = _variance(found, templates.noise_gain[index])
        good = _acceptable(found, start, config) & (variance < config.max_sigma**2)
        good &= _inside(found.warps.position, _original_shape(enlarged[other]), 1)
        refined[other, tracks[index[good]]] = found.warps.position[good]
        sigmas[other, tracks[index[good]]] = np.sqrt(variance[good])
        own_variance[other, index[good]] = variance[good]
    kept = np.isfinite(own_variance).any(axis=0)
    refined[view, tracks[kept]] = centres[kept]
    sigmas[view, tracks[kept]] = np.sqrt(np.nanmedian(own_variance[:, kept], axis=0))


def _variance(found: Alignment, noise_gain: Array) -> Array:
    """Variance per axis, (n,), mean of the two axes."""
    spread = found.residual[:, None, None] ** 2 * noise_gain
    covariance = found.warps.shape @ spread @ found.warps.shape.transpose(0, 2, 1)
    return np.asarray(SIGMA_FLOOR**2 + SIGMA_SCALE**2 * 0.5 * np.trace(covariance, axis1=1, axis2=2))


def _acceptable(found: Alignment, start: Warps, config: TrackingConfig) -> NDArray[np.bool_]:
    change = np.linalg.solve(start.shape, found.warps.shape) - np.eye(2)
    return np.asarray(
        (np.linalg.norm(found.warps.position - start.position, axis=1) < config.max_wander)
        & (found.correlation > config.min_correlation)
        & (found.last_step < MAX_LAST_STEP_PX)
        & (np.abs(change).max(axis=(1, 2)) < MAX_SHAPE_CHANGE)
    )


def local_warps(homography: Array, points: Array) -> tuple[Array, Array]:
    """How a homography maps the neighbourhood of points (n, 2): H(x + d) = H(x) + shape d / (1 + perspective . d).

    Returns shape (n, 2, 2) and perspective (n, 2).
    """
    mapped = np.column_stack([points, np.ones(len(points))]) @ homography.T
    position, depth = mapped[:, :2] / mapped[:, 2:], mapped[:, 2, None]
    numerator = homography[None, :2, :2] - position[:, :, None] * homography[None, 2:, :2]
    return np.asarray(numerator / depth[:, :, None]), np.asarray(homography[2, :2] / depth)


def _original_shape(enlarged: Array32) -> tuple[int, int]:
    return enlarged.shape[0] // UPSAMPLING, enlarged.shape[1] // UPSAMPLING


def _inside(points: Array, shape: tuple[int, ...], margin: float) -> NDArray[np.bool_]:
    limit = np.array([shape[1], shape[0]]) - 1 - margin
    return np.asarray(((points >= margin) & (points <= limit)).all(axis=1))
