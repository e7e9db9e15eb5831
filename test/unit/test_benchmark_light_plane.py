# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The bound of the light plane alone against finite differences of the whole problem; counting of labels."""

from __future__ import annotations

import numpy as np
import pytest

from benchmark.light_plane_bound import light_plane_bound
from benchmark.light_plane_cells import count_labels
from benchmark.scene import Array
from benchmark.stops import active_stops
from benchmark.stripes import Stripes, random_stripes
from benchmark.world import World, random_world
from cv_active_handeye.workflow.evidence import StripeSegment

STOPS, SURFACES, SIGMA = (5, 5), 2, 0.1


def all_rows(world: World, stripes: Stripes, unknowns: Array) -> Array:
    """Rows of all stripes; unknowns: steps of nx, ny and d, then of the planes' x, y and offset, group by group."""
    light = stripes.light_plane + np.array([unknowns[0], unknowns[1], 0, unknowns[2]])
    light[2] = np.sqrt(1 - light[0] ** 2 - light[1] ** 2)
    rows = []
    for group in range(len(STOPS)):
        views = slice(5 * group, 5 * group + 5)
        steps = unknowns[3:].reshape(len(STOPS), SURFACES, 3)[group]
        surfaces = stripes.surfaces + np.insert(steps, 2, 0, axis=1)
        poses = world.R_gripper2base[views], world.t_gripper2base[views]
        rows.append(stripes.rows(world, world.parameters(), light, surfaces, *poses).ravel())
    return np.concatenate(rows)


def test_light_plane_bound_is_that_of_the_whole_problem() -> None:
    rng = np.random.default_rng(1)
    stripes = random_stripes(rng, SURFACES)
    world = random_world(rng, active_stops(rng, STOPS), points=4, stripes=stripes)
    steps = 1e-6 * np.eye(3 + 3 * SURFACES * len(STOPS))
    J = np.stack([(all_rows(world, stripes, s) - all_rows(world, stripes, -s)) / 2e-6 for s in steps], axis=1)
    covariance = SIGMA**2 * np.linalg.inv(J.T @ J)[:3, :3]
    bound = light_plane_bound(world, STOPS, SIGMA)[np.ix_([0, 1, 3], [0, 1, 3])]
    assert bound == pytest.approx(covariance, rel=1e-4)


def test_labels_are_counted_by_true_plane() -> None:
    views, labels, planes = [0, 1, 2, 0, 1, 2, 0], [0, 0, -1, 1, 1, 0, 2], [5, 5, 5, 6, 6, 6, -1]
    segments = [StripeSegment(view, np.zeros((2, 2)), label) for view, label in zip(views, labels, strict=True)]
    assert count_labels(segments, np.array(planes)) == (6, 5, 2)
