# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Random trials of estimateFOE: errors as large as the covariance says, and half of OpenCV's (benchmark/foe.py)."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import null_space

import cv_active_handeye as cah
from benchmark.foe import CASES, Case, K, compare

TRIALS, SEED = 150, 7


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_least_squares_foe_knows_its_error(case: Case) -> None:
    squares = []
    for trial in range(TRIALS):
        first, second = case.matches(np.random.default_rng([SEED, trial]), outliers=0.0)
        _, foe, _, covariance = cah.estimateFOE(first, second, method=cah.FOE_LEAST_SQUARES)
        tangent = null_space(foe.T)
        truth = K @ np.array(case.motion)
        error = tangent.T @ (truth / (foe[:, 0] @ truth) - foe[:, 0])
        squares.append(error @ np.linalg.solve(tangent.T @ covariance @ tangent, error))
    assert np.sqrt(np.mean(squares) / 2) == pytest.approx(1, abs=0.2)


@pytest.mark.parametrize("outliers", [0.0, 0.3])
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_foe_is_twice_as_accurate_as_the_essential_matrix(case: Case, outliers: float) -> None:
    found = compare(case, outliers, TRIALS, SEED)
    ours, ours_at_default, *theirs = np.median(found.errors, axis=1)
    assert ours < 0.55 * min(theirs)
    assert ours_at_default < 0.6
