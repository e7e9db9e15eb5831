# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The tables and measures of benchmark/demo.py, from runs that are written down here."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmark.__main__ import HEADLINES
from benchmark.demo import coverage, measures, statistics, table
from benchmark.demo_cells import LOOKS_12, LOOKS_24, RECIPES, Run
from benchmark.report import Report
from cv_active_handeye.report import CalibrationErrors
from cv_active_handeye.simulation.motion import Look

ERRORS = CalibrationErrors(0.01, 0.01, 0.02, 0.02, 0.003, 0.04, 0.002, 0.02)
HELD = {"fx": True, "fy": True, "tx": True, "tz": False}


def runs(recipe: str) -> list[Run]:
    """Three good runs."""
    return [Run(recipe, seed, ERRORS, HELD, 1000, 0.04, "none", True, cpu_seconds=20) for seed in range(3)]


def test_coverage_counts_intervals_and_its_error_counts_runs() -> None:
    some = [*runs("12 stops")[:2], replace(runs("12 stops")[2], inside=dict.fromkeys(HELD, True))]
    share, error, count = coverage(some)
    assert share == pytest.approx(100 * 10 / 12)
    assert count == 12
    assert error == pytest.approx(np.std([75, 75, 100], ddof=1) / np.sqrt(3))


def test_a_run_that_failed_counts_as_infinitely_wrong_and_not_usable() -> None:
    failed = Run("12 stops", 3, CalibrationErrors(*[float("nan")] * 8), {}, problem="12 stops, seed 3: no points")
    median, largest = statistics([*runs("12 stops"), failed])
    assert median[0] == pytest.approx(0.01)
    assert largest == [np.inf] * 8
    found = {m.name: m for m in measures({"12 stops": [*runs("12 stops"), failed]})}
    assert not found["results that are not usable"].kept
    assert "seed 3: no points" in table("12 stops", [*runs("12 stops"), failed]).note


def test_intervals_that_miss_too_often_miss_the_measure() -> None:
    found = {m.name: m for m in measures({"24 stops": runs("24 stops")})}
    off = found["95 % intervals that hold the truth: off by [%]"]
    assert off.value == pytest.approx(20)
    assert not off.kept
    assert found["24 stops: median translation [mm]"].kept


def test_lines_of_the_readme_find_their_measures() -> None:
    report = Report("", "", (), measures({recipe: runs(recipe) for recipe in RECIPES}))
    lines = [line for line in HEADLINES if line.script == "demo"]
    assert lines
    assert all(line.row(report)[1] for line in lines)


@pytest.mark.parametrize(("looks", "stops"), [(LOOKS_24, 24), (LOOKS_12, 12)])
def test_recipes_have_as_many_stops_as_they_say(looks: list[Look], stops: int) -> None:
    assert sum(len(look.stops) for look in looks) == stops
