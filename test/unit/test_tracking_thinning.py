# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Tracks that overlap are left out, the better one of two stays, and nothing else is lost."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from cv_active_handeye.tracking.thinning import independent_tracks

SIZE = (200, 150)
Array = NDArray[np.float64]


def random_tracks(seed: int, count: int = 300, views: int = 4) -> tuple[Array, Array]:
    """Points (V, N, 2) all over the image and sigmas (V, N), a third of them not seen."""
    rng = np.random.default_rng(seed)
    points = rng.uniform([0, 0], [SIZE[0] - 1, SIZE[1] - 1], (views, count, 2))
    sigmas = rng.uniform(0.02, 0.2, (views, count))
    hidden = rng.random((views, count)) < 1 / 3
    hidden[0, hidden.all(axis=0)] = False
    points[hidden], sigmas[hidden] = np.nan, np.nan
    return points, sigmas


def distances(points: Array) -> Array:
    """Smallest distance of any two tracks (N, N) over the views that see both; inf on the diagonal."""
    between = np.linalg.norm(points[:, :, None] - points[:, None, :], axis=3)
    nearest = np.where(np.isnan(between), np.inf, between).min(axis=0)
    np.fill_diagonal(nearest, np.inf)
    return np.asarray(nearest, np.float64)


@pytest.mark.parametrize("distance", [3.0, 7.0, 15.0])
@pytest.mark.parametrize("seed", range(3))
def test_kept_tracks_are_apart_and_every_other_had_a_better_neighbour(seed: int, distance: float) -> None:
    points, sigmas = random_tracks(seed)
    keep = independent_tracks(points, sigmas, SIZE, distance)
    assert 5 < keep.sum() < len(keep)
    apart = distances(points)
    # positions are rounded to pixels: each end is off by up to 0.71 px
    assert apart[np.ix_(keep, keep)].min() > distance - 1.5
    information = np.nansum(sigmas**-2, axis=0)
    better = keep[None, :] & (information[None, :] > information[:, None])
    assert (np.where(better, apart, np.inf).min(axis=1) < distance + 2)[~keep].all()


def test_distance_zero_keeps_all() -> None:
    points, sigmas = random_tracks(1)
    assert independent_tracks(points, sigmas, SIZE, 0).all()


def test_one_view_in_common_that_is_near_is_enough() -> None:
    points = np.array([[[10.0, 10], [50, 50]], [[80, 80], [82, 80]]])
    sigmas = np.array([[0.1, 0.05], [0.1, 0.05]])
    assert independent_tracks(points, sigmas, SIZE, 7).tolist() == [False, True]


def test_tracks_that_are_near_in_no_view_that_sees_both_stay() -> None:
    points = np.array([[[10.0, 10], [np.nan, np.nan]], [[np.nan, np.nan], [10, 10]], [[80, 80], [90, 80]]])
    sigmas = np.where(np.isnan(points[:, :, 0]), np.nan, 0.1)
    assert independent_tracks(points, sigmas, SIZE, 7).all()


def test_the_track_that_is_seen_more_often_stays() -> None:
    points = np.array([[[10.0, 10], [12, 10]], [[np.nan, np.nan], [60, 60]]])
    sigmas = np.array([[0.1, 0.12], [np.nan, 0.12]])
    assert independent_tracks(points, sigmas, SIZE, 7).tolist() == [False, True]


def test_points_on_the_border_are_taken() -> None:
    points = np.array([[[199.4, 149.4], [-0.4, -0.4], [199.4, 145.0]]])
    assert independent_tracks(points, np.array([[0.1, 0.1, 0.2]]), SIZE, 7).tolist() == [True, True, False]


def test_input_is_left_alone() -> None:
    points, sigmas = random_tracks(2)
    before = points.copy(), sigmas.copy()
    independent_tracks(points, sigmas, SIZE, 7)
    assert np.array_equal(points, before[0], equal_nan=True)
    assert np.array_equal(sigmas, before[1], equal_nan=True)
