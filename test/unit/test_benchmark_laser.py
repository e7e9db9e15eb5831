# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The benchmarks of the weld seam and of reprojectStripe: what they make of their runs."""

from __future__ import annotations

import numpy as np
import pytest

from benchmark import reproject_speed, seam
from benchmark.__main__ import HEADLINES
from benchmark.cluster import Workers


def test_seam_reports_the_median_rms_and_how_far_the_coverage_is_off(monkeypatch: pytest.MonkeyPatch) -> None:
    made = {
        0: seam.Run(0, np.array([0.3, 0.4]), np.full(2, 0.1), 0.9, 160.0),
        1: seam.Run(1, np.array([0.1, 0.1]), np.full(2, 0.1), 0.9, 160.0),
        2: seam.Run(2, np.array([0.2, 0.2]), np.full(2, 0.1), 0.6, 160.0),
    }
    monkeypatch.setattr(seam, "run", lambda number, seeds: made[seeds[number]])
    report = seam.measure(range(3), Workers())
    rms, coverage = report.measures
    assert rms.value == pytest.approx(0.2)
    assert coverage.value == pytest.approx(15)
    assert rms.kept
    assert not coverage.kept
    assert len(report.tables[0].rows) == 3
    [line] = [headline for headline in HEADLINES if headline.script == "seam"]
    assert line.row(report)[1] == "0.2000"


def test_reproject_speed_measures_with_and_without_a_lens() -> None:
    report = reproject_speed.measure(points=2000, rounds=2)
    assert [measure.at_least for measure in report.measures] == [True, True]
    assert all(measure.value > 0 for measure in report.measures)
    assert len(report.tables[0].rows) == 4
