# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Matches between pairs of views: which pairs, and which features in them."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from .config import TrackingConfig
from .features import Array32, Features

Indices = NDArray[np.int64]
Pair = tuple[int, int]

SAME_PLACE_PX = 2.0
NEXT_VIEWS = 4


def select_pairs(group_ids: Indices, config: TrackingConfig) -> list[Pair]:
    """Pairs of views to match, (a, b) with a < b.

    All of them up to `config.all_pairs_up_to` views. Beyond it: all pairs inside a group of equal orientation, the
    first views of all groups with each other, and every view with the four that follow it in the recording.
    """
    views = range(len(group_ids))
    if len(views) <= config.all_pairs_up_to:
        return list(combinations(views, 2))
    first_views = set(np.unique(group_ids, return_index=True)[1].tolist())
    return [
        (a, b)
        for a, b in combinations(views, 2)
        if group_ids[a] == group_ids[b] or {a, b} <= first_views or b - a <= NEXT_VIEWS
    ]


def nearest_copy(features: Features) -> Array32:
    """Descriptor distance of every feature to the most similar one elsewhere in the same image, (n,).

    On repeated texture it is small. Several SIFT features at one place (orientations) are not copies.
    """
    if len(features) < 2:
        return np.full(len(features), np.inf, np.float32)
    similarity = features.descriptors @ features.descriptors.T
    x, y = features.points.astype(np.float32).T
    same = (np.abs(x[:, None] - x) < SAME_PLACE_PX) & (np.abs(y[:, None] - y) < SAME_PLACE_PX)
    similarity[same] = -1.0
    return _distance(similarity.max(axis=1))


def match_pair(a: Features, b: Features, copy_a: Array32, copy_b: Array32, config: TrackingConfig) -> Indices:
    """Mutual nearest neighbours that are unambiguous; returns their indices (m, 2).

    The ratio test is held against the second nearest of either image and against the nearest copy of the feature in
    its own image (`nearest_copy`): the copy may lie outside the other image and would go unnoticed there. Features with
    a very near copy are not matched at all.
    """
    if len(a) < 2 or len(b) < 2:
        return np.empty((0, 2), np.int64)
    similarity = a.descriptors @ b.descriptors.T
    best_b = similarity.argmax(axis=1)
    nearest = similarity[np.arange(len(a)), best_b]
    i = np.flatnonzero(nearest >= similarity.max(axis=0)[best_b])
    j = best_b[i]
    similarity[i, j] = -1.0
    found, second = _distance(nearest[i]), _distance(np.maximum(similarity.max(axis=1)[i], similarity.max(axis=0)[j]))
    copy = np.minimum(copy_a[i], copy_b[j])
    good = (found < config.ratio * np.minimum(second, copy)) & (copy > config.copy_distance)
    return np.asarray(np.column_stack([i, j])[good], np.int64)


def _distance(similarity: Array32) -> Array32:
    """Distance of two unit vectors from their scalar product."""
    return np.asarray(np.sqrt(np.maximum(2.0 - 2.0 * similarity, 0.0)), np.float32)
