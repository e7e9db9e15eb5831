# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Matches of pairs become tracks: one feature a view at most."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from .features import Features
from .matching import SAME_PLACE_PX, Indices, Pair


def merge_matches(features: Sequence[Features], matches: Mapping[Pair, Indices], min_views: int) -> Indices:
    """Tracks (V, N): index of the feature in every view, -1 where it has none.

    Matches are joined by union-find, and so are features at exactly one place (SIFT gives one for each orientation).
    Where a track holds features at two places of one view, that view is dropped from it; where this happens in more
    than half of its views the track is ambiguous and left out.
    """
    offsets = np.concatenate([[0], np.cumsum([len(f) for f in features])]).astype(np.int64)
    parent = _same_places(features, offsets)
    for (a, b), pairs in matches.items():
        for i, j in (pairs + offsets[[a, b]]).tolist():
            _union(parent, i, j)
    used = np.zeros(len(parent), bool)
    for (a, b), pairs in matches.items():
        used[pairs[:, 0] + offsets[a]] = used[pairs[:, 1] + offsets[b]] = True
    members: dict[int, list[int]] = {}
    for node in np.flatnonzero(used).tolist():
        members.setdefault(_find(parent, node), []).append(node)
    columns = []
    for nodes in members.values():
        column = _one_feature_a_view(np.array(nodes), offsets, features)
        if np.count_nonzero(column >= 0) >= min_views:
            columns.append(column)
    return np.array(columns, np.int64).reshape(-1, len(features)).T


def _same_places(features: Sequence[Features], offsets: Indices) -> NDArray[np.int64]:
    """Parents for union-find, (n,): the first feature at the same position of the same view."""
    parents = []
    for offset, found in zip(offsets, features, strict=False):
        _, first, place = np.unique(found.points, axis=0, return_index=True, return_inverse=True)
        parents.append(offset + first[place.ravel()])
    return np.concatenate(parents).astype(np.int64)


def _one_feature_a_view(nodes: Indices, offsets: Indices, features: Sequence[Features]) -> Indices:
    column = np.full(len(features), -1, np.int64)
    views = np.searchsorted(offsets, nodes, side="right") - 1
    local = nodes - offsets[views]
    conflicts = 0
    for view in np.unique(views):
        candidates = local[views == view]
        places = features[view].points[candidates]
        if np.abs(places - places[0]).max() > SAME_PLACE_PX:
            conflicts += 1
        else:
            column[view] = candidates[0]
    return column if 2 * conflicts <= len(np.unique(views)) else np.full_like(column, -1)


def _find(parent: NDArray[np.int64], node: int) -> int:
    while parent[node] != node:
        parent[node] = parent[parent[node]]
        node = int(parent[node])
    return node


def _union(parent: NDArray[np.int64], a: int, b: int) -> None:
    root_a, root_b = _find(parent, a), _find(parent, b)
    if root_a != root_b:
        parent[max(root_a, root_b)] = min(root_a, root_b)
