# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
from itertools import combinations

import numpy as np
import pytest
from numpy.typing import NDArray

from cv_active_handeye.tracking import TrackingConfig
from cv_active_handeye.tracking.features import Features
from cv_active_handeye.tracking.matching import match_pair, nearest_copy, select_pairs
from cv_active_handeye.tracking.merging import merge_matches


def features(descriptors: NDArray[np.float32], seed: int = 0) -> Features:
    points = np.random.default_rng(seed).uniform(0, 600, (len(descriptors), 2))
    return Features(points, descriptors / np.linalg.norm(descriptors, axis=1, keepdims=True))


def random_descriptors(count: int, seed: int = 0) -> NDArray[np.float32]:
    return np.random.default_rng(seed).uniform(0, 1, (count, 128)).astype(np.float32) ** 4


def matched(a: Features, b: Features) -> set[tuple[int, int]]:
    found = match_pair(a, b, nearest_copy(a), nearest_copy(b), TrackingConfig())
    return {(int(i), int(j)) for i, j in found}


def test_match_pair_finds_permuted_features_and_no_others() -> None:
    shared = random_descriptors(40)
    order = np.random.default_rng(1).permutation(40)
    a = features(np.vstack([shared, random_descriptors(30, 2)]))
    b = features(np.vstack([shared[order], random_descriptors(30, 3)]), seed=5)
    assert matched(a, b) == {(int(order[j]), j) for j in range(40)}


def test_match_pair_leaves_out_a_feature_with_a_copy_in_its_own_image_only() -> None:
    shared = random_descriptors(20)
    noise = 0.01 * random_descriptors(1, 9)
    a = features(np.vstack([shared, shared[4:5] + noise]))
    b = features(shared, seed=5)
    assert matched(a, b) == {(i, i) for i in range(20) if i != 4}
    assert matched(b, a) == {(i, i) for i in range(20) if i != 4}


def test_nearest_copy_ignores_features_at_the_same_place() -> None:
    descriptors = random_descriptors(3)
    descriptors[1] = descriptors[0]
    points = np.array([[10.0, 10.0], [10.5, 10.0], [300.0, 40.0]])
    together = Features(points, descriptors / np.linalg.norm(descriptors, axis=1, keepdims=True))
    apart = Features(points + np.array([[0, 0], [50, 0], [0, 0]]), together.descriptors)
    assert nearest_copy(together).min() > 0.3
    np.testing.assert_allclose(nearest_copy(apart)[:2], 0.0, atol=1e-3)


def test_match_pair_of_images_without_features_is_empty() -> None:
    empty = Features(np.empty((0, 2)), np.empty((0, 128), np.float32))
    assert matched(empty, features(random_descriptors(5))) == set()


def test_select_pairs_takes_all_of_few_views() -> None:
    assert select_pairs(np.array([0, 0, 1, 2]), TrackingConfig()) == list(combinations(range(4), 2))


def test_select_pairs_of_many_views_connects_all_of_them_with_far_fewer_pairs() -> None:
    groups = np.repeat(np.arange(8), 5)
    pairs = select_pairs(groups, TrackingConfig())
    assert len(pairs) < 0.4 * 40 * 39 / 2
    same = [(a, b) for a, b in combinations(range(40), 2) if groups[a] == groups[b]]
    assert set(same) <= set(pairs)
    assert {(0, 5), (0, 35), (15, 30)} <= set(pairs)


def chain(*edges: tuple[int, int]) -> NDArray[np.int64]:
    return np.array(edges, np.int64).reshape(-1, 2)


def test_merge_matches_joins_chains_over_views() -> None:
    views = [features(random_descriptors(4), seed) for seed in range(3)]
    tracks = merge_matches(views, {(0, 1): chain((0, 3), (1, 1)), (1, 2): chain((3, 2))}, min_views=2)
    assert sorted(map(tuple, tracks.T.tolist())) == [(0, 3, 2), (1, 1, -1)]


def test_merge_matches_drops_the_view_in_which_a_track_holds_two_features() -> None:
    views = [features(random_descriptors(4), seed) for seed in range(4)]
    matches = {(0, 1): chain((0, 0)), (1, 2): chain((0, 0)), (0, 2): chain((0, 1)), (2, 3): chain((0, 2))}
    tracks = merge_matches(views, matches, min_views=2)
    assert tracks.T.tolist() == [[0, 0, -1, 2]]


def test_merge_matches_leaves_out_a_track_ambiguous_in_most_views() -> None:
    views = [features(random_descriptors(4), seed) for seed in range(5)]
    twice = {(0, 1): chain((0, 0), (1, 1), (0, 1)), (1, 2): chain((0, 0), (1, 1))}
    once = {(2, 3): chain((0, 0)), (3, 4): chain((0, 0))}
    assert merge_matches(views, twice | once, min_views=2).shape == (5, 0)
    assert merge_matches(views, once, min_views=2).T.tolist() == [[-1, -1, 0, 0, 0]]


def test_merge_matches_takes_features_at_one_place_as_one() -> None:
    views = [features(random_descriptors(4), seed) for seed in range(2)]
    views[1].points[1] = views[1].points[0] + 0.2
    tracks = merge_matches(views, {(0, 1): chain((0, 0), (0, 1))}, min_views=2)
    assert tracks.T.tolist() == [[0, 0]]


@pytest.mark.parametrize("settings", [{"ratoi": 0.7}, {"ratio": 1.2}, {"max_features": 3}, {"min_views": 1}])
def test_tracking_config_refuses_unknown_keys_and_impossible_values(settings: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=next(iter(settings))):
        TrackingConfig.model_validate(settings)
