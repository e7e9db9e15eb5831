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
from .patches import Alignment, Templates, Warps, align, make_templates, original_shape, upsample

MAX_LAST_STEP_PX = 0.02
MAX_SHAPE_CHANGE = 0.4

# Fitted to the simulated cell, good and bad light (benchmark/tracking.py prints how well they hold).
SIGMA_FLOOR_PX = 0.003
SIGMA_SCALE = 1.2
NOISE_QUANTILE = 0.25
NOISE_SPREAD = 1.15
MISFIT_POWER = 1.5


@dataclass(frozen=True)
class Observations:
    """N tracks in V views, NaN = not seen.

    points (V, N, 2): pixels; sigmas (V, N): standard deviation per axis, px; reference (N,): the view that defines it.
    """

    points: Array
    sigmas: Array
    reference: Indices


@dataclass(frozen=True)
class _Found:
    """What the alignment gave for every observation: position (V, N, 2), standard deviation (V, N) if the residual was
    white noise, and RMS residual (V, N) in grey values of the reference."""

    points: Array
    white_sigmas: Array
    residuals: Array


@dataclass(frozen=True)
class _Patches:
    """The reference patches in one view: their tracks (n,), centres (n, 2), templates."""

    view: int
    tracks: Indices
    centres: Array
    templates: Templates


def refine_tracks(
    images: Sequence[Array32], points: Array, config: TrackingConfig, progress: Callable[[int], None]
) -> Observations:
    """Align all observations to the reference patch of their track.

    points (V, N, 2): detected positions, NaN = not seen. The track *is* the scene point at the centre of its reference
    patch, the pixel nearest to the detected feature; so its position in the reference view is exact by definition and
    only the agreement of the other views with it matters. `progress` is told every finished view.
    """
    warps = view_warps(points)
    reference = choose_references(points, warps)
    found = _Found(np.full_like(points, np.nan), *(np.full(points.shape[:2], np.nan) for _ in range(2)))
    patches = [_cut_patches(view, image, points, reference, config) for view, image in enumerate(images)]
    for part in patches:
        found.points[part.view, part.tracks] = part.centres
    for view, image in enumerate(images):
        enlarged = upsample(image)
        for part in patches:
            if (part.view, view) in warps:
                _refine(part, view, enlarged, points, warps[part.view, view], config, found)
        progress(view)
    return _with_sigmas(found, reference, config)


def _cut_patches(view: int, image: Array32, points: Array, reference: Indices, config: TrackingConfig) -> _Patches:
    tracks = _distinct(np.flatnonzero(reference == view), points, view)
    centres = np.rint(points[view, tracks])
    inside = _inside(centres, image.shape, config.patch_radius + 1)
    templates = make_templates(upsample(image), centres[inside], config.patch_radius)
    return _Patches(view, tracks[inside], centres[inside], templates)


def _with_sigmas(found: _Found, reference: Indices, config: TrackingConfig) -> Observations:
    """Standard deviations of all observations.

    What is known is the error of an observation against its reference: residual and structure of the patch give it for
    white noise. Residuals above the usual noise are misfit (an edge of the object, a shadow, a highlight in the patch),
    which moves patches further than noise of the same size. Each of the two ends gets half of the variance.
    """
    tracks = np.arange(len(reference))
    noise = np.nanquantile(found.residuals, NOISE_QUANTILE) if np.isfinite(found.residuals).any() else 1.0
    misfit = np.maximum(found.residuals / (NOISE_SPREAD * noise), 1.0) ** MISFIT_POWER
    relative = np.hypot(SIGMA_FLOOR_PX, SIGMA_SCALE * found.white_sigmas * misfit)
    relative[~(relative < config.max_sigma)] = np.nan
    points = np.where(np.isfinite(relative)[:, :, None], found.points, np.nan)
    alive = np.isfinite(relative).any(axis=0)
    relative[reference[alive], tracks[alive]] = np.nanmedian(relative[:, alive], axis=0)
    points[reference[alive], tracks[alive]] = found.points[reference[alive], tracks[alive]]
    return Observations(points, relative / np.sqrt(2.0), reference)


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
            try:
                homography, _ = cv2.findHomography(points[a, both], points[b, both], cv2.USAC_MAGSAC, 10.0)
            except cv2.error:  # as in rejection.epipolar_geometry
                homography = None
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


def _distinct(tracks: Indices, points: Array, view: int) -> Indices:
    """Of tracks with the same reference patch, the one seen in most views; they would all end at the same positions."""
    longest_first = tracks[np.argsort(-np.isfinite(points[:, tracks, 0]).sum(axis=0), kind="stable")]
    _, first = np.unique(np.rint(points[view, longest_first]), axis=0, return_index=True)
    return np.sort(longest_first[first])


def _refine(
    part: _Patches,
    view: int,
    enlarged: Array32,
    points: Array,
    homography: Array,
    config: TrackingConfig,
    found: _Found,
) -> None:
    """Align patches to another view; `homography` is a first guess of the warp. Writes into `found`."""
    index = np.flatnonzero(np.isfinite(points[view, part.tracks, 0]))
    tracks, centres = part.tracks[index], part.centres[index]
    shape, perspective = local_warps(homography, centres)
    rounding = centres - points[part.view, tracks]
    position = points[view, tracks] + np.einsum("nij,nj->ni", shape, rounding)
    start = Warps(position, shape, perspective)
    templates = part.templates[index]
    aligned = align(templates, enlarged, start, config.max_iterations)
    good = _acceptable(aligned, start, config)
    good &= _inside(aligned.warps.position, original_shape(enlarged), 1)
    found.points[view, tracks[good]] = aligned.warps.position[good]
    found.residuals[view, tracks[good]] = aligned.residual[good]
    found.white_sigmas[view, tracks[good]] = _white_sigma(aligned, templates.noise_gain)[good]


def _white_sigma(aligned: Alignment, noise_gain: Array) -> Array:
    """Standard deviation per axis (n,), mean of the two axes, if the residual is white noise."""
    spread = aligned.residual[:, None, None] ** 2 * noise_gain
    covariance = aligned.warps.shape @ spread @ aligned.warps.shape.transpose(0, 2, 1)
    return np.asarray(np.sqrt(0.5 * np.trace(covariance, axis1=1, axis2=2)))


def _acceptable(aligned: Alignment, start: Warps, config: TrackingConfig) -> NDArray[np.bool_]:
    change = np.linalg.solve(start.shape, aligned.warps.shape) - np.eye(2)
    return np.asarray(
        (np.linalg.norm(aligned.warps.position - start.position, axis=1) < config.max_wander)
        & (aligned.correlation > config.min_correlation)
        & (aligned.last_step < MAX_LAST_STEP_PX)
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


def _inside(points: Array, shape: tuple[int, ...], margin: float) -> NDArray[np.bool_]:
    limit = np.array([shape[1], shape[0]]) - 1 - margin
    return np.asarray(((points >= margin) & (points <= limit)).all(axis=1))
