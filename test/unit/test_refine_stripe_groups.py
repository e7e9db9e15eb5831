# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What each group of equal orientation contributes to the light plane: its sigmas without the stripes of that group."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest

import cv_active_handeye as cah
from benchmark.fisher import bound
from benchmark.refine_trials import Case, settings
from benchmark.stops import STOPS_12
from benchmark.world import Noise, Recording, World

CASE = Case("12 stops, stripes", stops=STOPS_12, stripes=True)


class Recorded(NamedTuple):
    world: World
    recording: Recording


@pytest.fixture(scope="module")
def recorded() -> Recorded:
    rng = np.random.default_rng(5)
    world = CASE.world(rng)
    return Recorded(world, world.record(rng, Noise()))


def summary_of(recording: Recording, flags: int = 0) -> cah.RefineSummary:
    *_, summary = cah.refineHandEye(
        recording.R_gripper2base,
        recording.t_gripper2base,
        recording.image_points,
        *[None] * 5,
        stripePoints=recording.stripe_points or None,
        stripeViews=recording.stripe_views or None,
        surfaceIds=recording.surface_ids or None,
        params=settings(CASE.lens_model, Noise(), flags),
    )
    return summary


def without(recording: Recording, views: range) -> Recording:
    """The recording without the stripes of some views."""
    kept = [i for i, view in enumerate(recording.stripe_views) if view not in views]
    return replace(
        recording,
        stripe_points=[recording.stripe_points[i] for i in kept],
        stripe_views=[recording.stripe_views[i] for i in kept],
        surface_ids=[recording.surface_ids[i] for i in kept],
    )


def plane_sigmas(covariance: np.ndarray) -> tuple[float, float]:
    """Of normal (rad) and offset (m)."""
    return float(np.sqrt(np.trace(covariance[16:19, 16:19]))), float(np.sqrt(covariance[19, 19]))


def test_every_group_with_stripes_has_a_row(recorded: Recorded) -> None:
    rows = summary_of(recorded.recording).stripeGroups
    assert rows[:, :4].tolist() == [[0, 5, 20, 4], [5, 5, 20, 4], [10, 1, 4, 4], [11, 1, 4, 4]]


def test_sigmas_are_those_of_a_refinement_without_the_stripes_of_the_group(recorded: Recorded) -> None:
    whole = summary_of(recorded.recording)
    for first, count, _, _, normal, offset in whole.stripeGroups:
        views = range(int(first), int(first + count))
        expected = plane_sigmas(summary_of(without(recorded.recording, views)).covariance)
        assert (normal, offset) == pytest.approx(expected, rel=0.05)
        everything = plane_sigmas(whole.covariance)
        assert normal >= everything[0]
        assert offset >= everything[1]
    assert whole.stripeGroups[0, 4] > 1.05 * plane_sigmas(whole.covariance)[0]


def test_sigmas_with_all_stripes_agree_with_the_bound(recorded: Recorded) -> None:
    expected = plane_sigmas(bound(recorded.world, Noise(), CASE.free))
    assert plane_sigmas(summary_of(recorded.recording).covariance) == pytest.approx(expected, rel=0.2)


def test_the_only_group_with_stripes_leaves_nothing_that_determines_the_plane(recorded: Recorded) -> None:
    rows = summary_of(without(recorded.recording, range(5, 12))).stripeGroups
    assert rows[:, :4].tolist() == [[0, 5, 20, 4]]
    assert np.isinf(rows[0, 4:]).all()


def test_recording_without_stripes_has_no_rows(recorded: Recorded) -> None:
    assert len(summary_of(without(recorded.recording, range(12))).stripeGroups) == 0
