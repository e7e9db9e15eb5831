# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Closed forms on any mounting and motion: a few of the sets of benchmark/mountings.py."""

from __future__ import annotations

import pytest

from benchmark.mountings import EXACT, SETS, judge, trial

TRIALS, SEED = 40, 7


@pytest.mark.parametrize("name", SETS)
def test_closed_form_on_any_mounting_gives_the_truth_or_says_what_is_missing(name: str) -> None:
    verdict = judge(name, [trial(name, SEED, number) for number in range(TRIALS)])
    assert verdict.worst_exact < EXACT
    assert verdict.gross == 0
    assert verdict.refused <= TRIALS // 2
    assert verdict.ratio < 1.3  # 40 sets of three numbers scatter by 9 %
