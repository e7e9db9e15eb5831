# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The table and measures of benchmark/experiment.py, from runs that are drawn here."""

from __future__ import annotations

import numpy as np
import pytest

from benchmark.__main__ import HEADLINES
from benchmark.experiment import Run, coverage, measures, ratio, table
from benchmark.report import Report


def runs(error: float = 1.0, count: int = 40) -> list[Run]:
    """Errors of `error` times the stated 0.04 mm per axis."""
    rng = np.random.default_rng(3)
    sigmas = np.full((15, 3), 0.04)
    made = []
    for seed in range(count):
        differences = error * sigmas * rng.standard_normal((15, 3))
        inside = (np.abs(differences) < 1.96 * sigmas).ravel().tolist()
        made.append(Run(seed, differences, sigmas, inside, 60))
    return made


def test_honest_runs_keep_all_measures() -> None:
    found = measures(runs())
    assert [m.kept for m in found] == [True] * 4
    assert found[0].value == pytest.approx(0.04 * np.sqrt(3), rel=0.03)
    assert ratio(runs()) == pytest.approx(1, abs=0.05)
    assert coverage(runs())[0] == pytest.approx(95, abs=1.5)


@pytest.mark.parametrize(("error", "missed"), [(4.0, [True] * 4), (1.3, [False, False, True, True])])
def test_larger_errors_than_stated_miss(error: float, missed: list[bool]) -> None:
    assert [not m.kept for m in measures(runs(error))] == missed


def test_intervals_that_are_far_too_wide_miss_too() -> None:
    assert [m.kept for m in measures(runs(0.5))] == [True, True, True, False]


def test_table_ends_with_medians_limits_and_the_paper() -> None:
    made = table(runs(count=3))
    assert [row[0] for row in made.rows[3:]] == ["median", "limit of the median", "the paper's Table 1, recomputed"]
    assert made.rows[3][1] == pytest.approx(np.median([r.rms for r in runs(count=3)]))
    assert "RMSE / predicted" in made.note


def test_lines_of_the_readme_find_their_measures() -> None:
    report = Report("", "", (), measures(runs()))
    lines = [line for line in HEADLINES if line.script == "experiment"]
    assert len(lines) == 4
    assert all(line.row(report)[1] for line in lines)
