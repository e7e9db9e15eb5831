# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""From the images of one recording to point tracks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

import cv_active_handeye as cah

from .config import TrackingConfig
from .features import Array, Array32, Features, detect_features, grey_image, normalise_brightness
from .matching import Indices, Pair, match_pair, nearest_copy, select_pairs
from .merging import merge_matches
from .refinement import Observations, refine_tracks
from .rejection import NoEpipolarGeometryError, consistent_observations, epipolar_distance, epipolar_geometry
from .thinning import independent_tracks

Progress = Callable[[int, int], None]


class TrackingError(ValueError):
    """The images cannot be tracked; the text says why and names the views."""


@dataclass(frozen=True)
class Tracks:
    """N scene points followed through V views.

    points (V, N, 2): pixels of the distorted image, centres at integers, NaN = not seen; `list(tracks.points)` is the
    `imagePoints` of the calibration functions.
    sigmas (V, N): standard deviation per axis in pixels, NaN = not seen.
    reference (N,): the view whose patch defines the track. Errors of different views of a track are independent.
    detected (V, N, 2): where the detector saw the points before refinement; for comparison.
    left_out: pairs of views that gave no matches, and why.
    """

    points: Array
    sigmas: Array
    reference: Indices
    detected: Array
    left_out: dict[Pair, str]

    def __len__(self) -> int:
        return int(self.points.shape[1])

    @property
    def seen(self) -> NDArray[np.bool_]:
        """Which view sees which track, (V, N)."""
        return np.isfinite(self.points[:, :, 0])

    @property
    def empty_views(self) -> list[int]:
        """Views that see no track."""
        return [int(view) for view in np.flatnonzero(~self.seen.any(axis=1))]


def track_points(
    images: Sequence[NDArray[np.generic]],
    R_gripper2base: ArrayLike,
    config: TrackingConfig | None = None,
    progress: Progress | None = None,
) -> Tracks:
    """Find the same scene points in all images of one recording, to a few hundredths of a pixel.

    images: V images of equal size, 8 or 16 bit, grey or BGR, laser off. R_gripper2base (V, 3, 3): orientation of every
    view, used only to tell which views are pure translations of each other. progress(done, total) is called after
    every step. The same input gives the same tracks. Raises `TrackingError` for unusable images.
    """
    config = config or TrackingConfig()
    greys = _checked_images(images)
    rotations = np.asarray(R_gripper2base, np.float64)
    if rotations.shape != (len(greys), 3, 3):
        raise TrackingError(
            f"R_gripper2base: need one 3x3 rotation for each of {len(greys)} images, got shape {rotations.shape}"
        )
    groups = cah.groupViews(list(rotations), orientationTolerance=config.orientation_tolerance)
    group_ids = np.asarray(groups, np.int64).ravel()
    pairs = select_pairs(group_ids, config)
    tell = _Counter(2 * len(greys) + len(pairs), progress)

    features = [tell.after(detect_features(grey, config)) for grey in greys]
    matches, left_out = _match_views(features, pairs, group_ids, config, tell)
    detected = _detected_points(features, matches, left_out, config)
    refined = refine_tracks(greys, detected, config, lambda _: tell.step())
    return _reject_and_pack(refined, detected, group_ids, left_out, greys[0].shape, config)


class _Counter:
    def __init__(self, total: int, progress: Progress | None) -> None:
        self._done, self._total, self._progress = 0, total, progress

    def step(self) -> None:
        self._done += 1
        if self._progress is not None:
            self._progress(self._done, self._total)

    def after(self, features: Features) -> Features:
        self.step()
        return features


def _checked_images(images: Sequence[NDArray[np.generic]]) -> list[Array32]:
    if len(images) < 2:
        raise TrackingError(f"images: need at least 2, got {len(images)}")
    try:
        greys = [grey_image(np.asarray(image), f"image {index}") for index, image in enumerate(images)]
    except ValueError as failure:
        raise TrackingError(str(failure)) from failure
    for index, grey in enumerate(greys):
        if grey.shape != greys[0].shape:
            sizes = [f"{g.shape[1]} x {g.shape[0]}" for g in (greys[0], grey)]
            raise TrackingError(f"images: need equal sizes, image 0 is {sizes[0]} and image {index} is {sizes[1]}")
    return normalise_brightness(greys)


def _match_views(
    features: Sequence[Features], pairs: Sequence[Pair], group_ids: Indices, config: TrackingConfig, tell: _Counter
) -> tuple[dict[Pair, Indices], dict[Pair, str]]:
    copies = [nearest_copy(f) for f in features]
    matches: dict[Pair, Indices] = {}
    left_out: dict[Pair, str] = {}
    for a, b in pairs:
        found = match_pair(features[a], features[b], copies[a], copies[b], config)
        try:
            same_orientation = bool(group_ids[a] == group_ids[b])
            matches[a, b] = _consistent_matches(found, features[a], features[b], same_orientation, config)
        except NoEpipolarGeometryError as reason:
            left_out[a, b] = str(reason)
        tell.step()
    return matches, left_out


def _consistent_matches(
    found: Indices, a: Features, b: Features, same_orientation: bool, config: TrackingConfig
) -> Indices:
    if len(found) < config.min_pair_matches:
        raise NoEpipolarGeometryError(f"{len(found)} matches, need {config.min_pair_matches}")
    points = a.points[found[:, 0]], b.points[found[:, 1]]
    geometry = epipolar_geometry(*points, same_orientation, config.match_threshold)
    fits = epipolar_distance(geometry, *points) < config.match_threshold
    count = int(np.count_nonzero(fits))
    if count < max(config.min_pair_matches, config.min_inlier_fraction * len(found)):
        raise NoEpipolarGeometryError(f"only {count} of {len(found)} matches fit one motion of the camera")
    return found[fits]


def _detected_points(
    features: Sequence[Features], matches: dict[Pair, Indices], left_out: dict[Pair, str], config: TrackingConfig
) -> Array:
    tracks = merge_matches(features, matches, min(config.min_views, len(features)))
    if tracks.shape[1] == 0:
        counts = ", ".join(f"{view}: {len(f)}" for view, f in enumerate(features))
        reasons = "; ".join(f"views {a} and {b}: {reason}" for (a, b), reason in list(left_out.items())[:5])
        raise TrackingError(
            f"images: no point was found in {min(config.min_views, len(features))} views. "
            f"Features in view {counts}. {reasons or 'All matches were ambiguous.'}"
        )
    found = [
        np.where((index >= 0)[:, None], np.vstack([f.points, [[np.nan, np.nan]]])[index], np.nan)
        for f, index in zip(features, tracks, strict=True)
    ]
    return np.stack(found)


def _reject_and_pack(
    refined: Observations,
    detected: Array,
    group_ids: Indices,
    left_out: dict[Pair, str],
    shape: tuple[int, ...],
    config: TrackingConfig,
) -> Tracks:
    good = consistent_observations(refined.points, group_ids, refined.reference, config)
    kept = np.count_nonzero(good, axis=0) >= min(config.min_views, len(good))
    if not kept.any():
        raise TrackingError("images: no track survived refinement; are they sharp, and of one unchanged scene?")
    sigmas = np.where(good, refined.sigmas, np.nan)[:, kept]
    kept[kept] = independent_tracks(refined.points[:, kept], sigmas, (shape[1], shape[0]), config.min_distance)
    good, reference = good[:, kept], refined.reference[kept]
    points = np.where(good[:, :, None], refined.points[:, kept], np.nan)
    sigmas = np.where(good, refined.sigmas[:, kept], np.nan)
    return Tracks(points, sigmas, reference, np.where(good[:, :, None], detected[:, kept], np.nan), left_out)
