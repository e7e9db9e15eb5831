# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from cv_active_handeye.tracking import TrackingConfig
from cv_active_handeye.tracking.rejection import (
    NoEpipolarGeometryError,
    consistent_observations,
    epipolar_distance,
    epipolar_geometry,
)

Array = NDArray[np.float64]
K = np.array([[1413.0, 0, 319.5], [0, 1413.0, 239.5], [0, 0, 1]])
MOTIONS = [(0, (0, 0, 0)), (0, (0.05, 0, 0.01)), (0, (0, 0.05, 0.02)), (1, (0.02, 0.01, 0)), (1, (-0.03, 0.02, 0.01))]
GROUPS = np.array([group for group, _ in MOTIONS])


def recording(count: int = 120, noise: float = 0.05) -> Array:
    """Positions (5, N, 2) of points with relief, in two groups of orientation."""
    rng = np.random.default_rng(11)
    scene = rng.uniform([-0.1, -0.07, 0.5], [0.1, 0.07, 0.62], (count, 3))
    turned = cv2.Rodrigues(np.radians([15.0, -10.0, 40.0]))[0]
    views = []
    for group, motion in MOTIONS:
        centred = (scene - [0, 0, 0.55]) @ (turned.T if group else np.eye(3)) + [0, 0, 0.55] - motion
        pixels = centred @ K.T
        views.append(pixels[:, :2] / pixels[:, 2:] + noise * rng.standard_normal((count, 2)))
    return np.array(views)


@pytest.mark.parametrize(("a", "b"), [(0, 1), (0, 3)])
def test_epipolar_geometry_separates_wrong_matches(a: int, b: int) -> None:
    views = recording()
    moved = views[b].copy()
    moved[:40] += np.random.default_rng(1).uniform(-80, 80, (40, 2))
    geometry = epipolar_geometry(views[a], moved, bool(GROUPS[a] == GROUPS[b]), 1.0)
    distance = epipolar_distance(geometry, views[a], moved)
    assert distance[40:].max() < 0.5
    assert np.mean(distance[:40] > 1.0) > 0.85


def test_epipolar_distance_is_opencv_s_sampson_distance() -> None:
    views = recording(noise=1.0)
    geometry = epipolar_geometry(views[0], views[3], False, 3.0)
    homogeneous = [np.column_stack([view, np.ones(len(view))]) for view in (views[0], views[3])]
    expected = [np.sqrt(cv2.sampsonDistance(a, b, geometry)) for a, b in zip(*homogeneous, strict=True)]
    np.testing.assert_allclose(epipolar_distance(geometry, views[0], views[3]), expected, rtol=1e-9)


def test_epipolar_geometry_says_why_there_is_none_for_equal_images() -> None:
    points = recording()[0]
    with pytest.raises(NoEpipolarGeometryError, match="parallax"):
        epipolar_geometry(points, points, True, 1.0)


def test_consistent_observations_keeps_right_tracks_whole() -> None:
    points = recording()
    points[4, ::3] = np.nan
    good = consistent_observations(points, GROUPS, np.zeros(120, np.int64), TrackingConfig())
    np.testing.assert_array_equal(good, np.isfinite(points[:, :, 0]))


def test_consistent_observations_drops_a_wrong_view_even_along_an_epipolar_line() -> None:
    points = recording()
    along = points[1, :10] - points[0, :10]
    points[1, :10] += 12.0 * along / np.linalg.norm(along, axis=1, keepdims=True)
    points[3, 10:20] += [6.0, -7.0]
    good = consistent_observations(points, GROUPS, np.zeros(120, np.int64), TrackingConfig())
    expected = np.ones((5, 120), bool)
    expected[1, :10] = expected[3, 10:20] = False
    assert np.count_nonzero(good != expected) <= 2


def test_consistent_observations_drops_a_track_whose_reference_is_wrong() -> None:
    points = recording()
    points[0, :8] += [9.0, 9.0]
    good = consistent_observations(points, GROUPS, np.zeros(120, np.int64), TrackingConfig())
    assert np.count_nonzero(good[:, :8]) <= 3
    assert good[:, 8:].all()
