# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""calibrateLightPlane over random scenes: as accurate as the bound allows, and neither more nor less sure of itself."""

from __future__ import annotations

import numpy as np
import pytest

from benchmark.light_plane import PlaneTrial, trial

TRIALS, SURFACES, SEED = 120, 2, 11


@pytest.fixture(scope="module")
def trials() -> list[PlaneTrial]:
    return [trial(SURFACES, SEED, number) for number in range(TRIALS)]


def test_errors_of_calibrateLightPlane_are_those_of_the_bound(trials: list[PlaneTrial]) -> None:
    for at in (slice(0, 3), slice(3, 4)):
        rmse = np.sqrt(np.mean([np.sum(t.error[at] ** 2) for t in trials]))
        bound = np.sqrt(np.mean([np.sum(t.bound[at]) for t in trials]))
        assert 0.8 < rmse / bound < 1.25  # 120 trials scatter by 6.5 %


def test_covariance_of_calibrateLightPlane_follows_the_misfit_both_ways(trials: list[PlaneTrial]) -> None:
    stated = np.sqrt(np.mean([np.sum(t.stated) for t in trials]))
    bound = np.sqrt(np.mean([np.sum(t.bound) for t in trials]))
    assert 0.93 < stated / bound < 1.08  # 1.14 with the floor of the lines' sigmas alone
