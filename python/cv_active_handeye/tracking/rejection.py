# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Geometric rejection: of wrong matches between two views, and of wrong observations in finished tracks."""

from __future__ import annotations

from itertools import combinations

import cv2
import numpy as np
from numpy.typing import NDArray

import cv_active_handeye as cah

from .config import TrackingConfig
from .features import Array
from .matching import Indices

Mask = NDArray[np.bool_]

MAGSAC_CONFIDENCE = 0.9999
MAGSAC_ITERATIONS = 5000


class NoEpipolarGeometryError(ValueError):
    """The matches of a pair of views fit no common motion, or show no parallax; the text says which."""


def epipolar_geometry(points_a: Array, points_b: Array, same_orientation: bool, threshold: float) -> Array:
    """Fundamental matrix F (3, 3), x_b^T F x_a = 0, of matches (N, 2), (N, 2) with wrong ones among them.

    Views of equal orientation: F = [e]x with the focus of expansion e (`cah.estimateFOE`; two matches are the minimum).
    Others: MAGSAC++. Raises `NoEpipolarGeometryError`.
    """
    if same_orientation:
        try:
            _, foe, _, _ = cah.estimateFOE(points_a, points_b, method=cah.FOE_RANSAC, threshold=threshold)
        except cah.error as failure:
            raise NoEpipolarGeometryError(str(failure)) from failure
        x, y, z = np.asarray(foe, np.float64).ravel()
        return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    try:
        fundamental, _ = cv2.findFundamentalMat(
            points_a, points_b, cv2.USAC_MAGSAC, threshold, MAGSAC_CONFIDENCE, MAGSAC_ITERATIONS
        )
    except cv2.error:  # OpenCV 4.14 asserts a model where its estimator found none
        fundamental = None
    if fundamental is None or fundamental.shape != (3, 3):
        raise NoEpipolarGeometryError("no fundamental matrix fits the matches")
    return np.asarray(fundamental, np.float64)


def epipolar_distance(fundamental: Array, points_a: Array, points_b: Array) -> Array:
    """Sampson distance in pixels of matches (N, 2), (N, 2), (N,): how far the pair is from fitting F."""
    a, b = (np.column_stack([p, np.ones(len(p))]) for p in (points_a, points_b))
    line_b, line_a = a @ fundamental.T, b @ fundamental
    slope = np.hypot(np.linalg.norm(line_b[:, :2], axis=1), np.linalg.norm(line_a[:, :2], axis=1))
    return np.asarray(np.abs((b * line_b).sum(axis=1)) / np.maximum(slope, 1e-300))


def consistent_observations(points: Array, group_ids: Indices, reference: Indices, config: TrackingConfig) -> Mask:
    """Which observations (V, N) of tracks with positions (V, N, 2) agree with the other views of their track.

    All pairs of views are held against their epipolar geometry, also those never matched directly: lines from two other
    views cross in one point, so a wrong observation cannot hide along one of them. In every track the view with most
    violations is dropped until none is left; a track that loses its reference view is dropped as a whole.
    """
    seen = np.isfinite(points[:, :, 0])
    violated = _violations(points, seen, group_ids, config)
    while True:
        counts = np.einsum("abn,an,bn->an", violated, seen, seen, optimize=True)
        worst, tracks = counts.argmax(axis=0), np.arange(points.shape[1])
        bad = counts[worst, tracks] > 0
        if not bad.any():
            break
        seen[worst[bad], tracks[bad]] = False
    return seen & seen[reference, np.arange(points.shape[1])]


def _violations(points: Array, seen: Mask, group_ids: Indices, config: TrackingConfig) -> NDArray[np.int32]:
    views, tracks = seen.shape
    violated = np.zeros((views, views, tracks), np.int32)
    for a, b in combinations(range(views), 2):
        both = np.flatnonzero(seen[a] & seen[b])
        if len(both) < config.min_pair_matches:
            continue
        pair = points[a, both], points[b, both]
        try:
            geometry = epipolar_geometry(*pair, bool(group_ids[a] == group_ids[b]), config.consistency_threshold)
        except NoEpipolarGeometryError:
            continue
        wrong = epipolar_distance(geometry, *pair) > config.consistency_threshold
        violated[a, b, both] = violated[b, a, both] = wrong
    return violated
