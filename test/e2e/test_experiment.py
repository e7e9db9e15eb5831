# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The paper's experiment of one cell, from images to the table; and that its files do the same by the command line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.command_line import run

from cv_active_handeye.workflow.experiment import TOUCH_SIGMA, ExperimentResult, experiment


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> ExperimentResult:
    return experiment(tmp_path_factory.mktemp("experiment"), seed=3)


def test_fifteen_points_are_measured_to_a_tenth_of_a_millimetre(result: ExperimentResult) -> None:
    assert [point.measured.name for point in result.points] == [f"S{i}" for i in range(1, 16)]
    heights = np.array([point.true[2] for point in result.points])
    assert np.ptp(heights[:10]) < 1e-3
    np.testing.assert_allclose(heights[10:] - heights[:10].mean(), [0.0467, 0.0334, 0.0232, 0.012, 0.0019], atol=1e-3)
    assert result.rms < 0.00016
    assert result.distances.max() < 0.0003
    assert result.rms < 1.5 * result.predicted_rms
    assert np.mean(result.inside) > 0.85


def test_touched_points_are_as_far_from_the_true_ones_as_the_robot_touches(result: ExperimentResult) -> None:
    touches = np.array([point.touched - point.true for point in result.points])
    assert np.sqrt(np.mean(touches**2)) == pytest.approx(TOUCH_SIGMA, rel=0.35)
    stated = np.array([np.diag(point.measured.covariance) for point in result.points])
    np.testing.assert_allclose([point.variances for point in result.points], stated + TOUCH_SIGMA**2)


def test_command_measure_gives_the_same_points(result: ExperimentResult, tmp_path: Path) -> None:
    folder, output = result.folder, tmp_path / "measured.csv"
    arguments = ["--calibration", str(folder / "calibration.yaml"), "--points", str(folder / "points.csv")]
    outcome = run("measure", str(folder / "measuring_views"), *arguments, "-o", str(output))
    assert outcome.exit_code == 0, outcome.output
    lines = [line.split(",") for line in output.read_text(encoding="utf-8").splitlines()[1:]]
    assert [line[0] for line in lines] == [point.measured.name for point in result.points]
    measured = np.array([[float(value) for value in line[2:5]] for line in lines]) / 1000
    np.testing.assert_allclose(measured, [point.measured.position for point in result.points], atol=2e-9)
