# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Figures of an experiment from points that are written down here; points that too few views show are told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from support.calibrations import refined
from support.recordings import Notes

from cv_active_handeye.dataset import Dataset
from cv_active_handeye.dataset_format import CameraInfo, LaserInfo
from cv_active_handeye.simulation import CellConfig, SimulatedCell
from cv_active_handeye.workflow.experiment import TOUCH_SIGMA, ExperimentPoint, ExperimentResult, _measured
from cv_active_handeye.workflow.measure import MeasuredPoint
from cv_active_handeye.workflow.reporter import InsufficientDataError

Array = NDArray[np.float64]


def point(name: str, difference: Array, sigma: float) -> ExperimentPoint:
    true = np.array([0.3, 0.01, -0.3])
    return ExperimentPoint(MeasuredPoint(name, (0, 1), true + difference, sigma**2 * np.eye(3)), true, true)


def test_result_counts_the_touch_and_compares_distances_with_their_prediction() -> None:
    sigma = 3e-5
    points = (point("S1", np.array([3e-5, 4e-5, 0]), sigma), point("S2", np.array([0, 0, -9e-5]), sigma))
    result = ExperimentResult(Path(), refined(), points)
    np.testing.assert_allclose(result.distances, [5e-5, 9e-5])
    assert result.rms == pytest.approx(np.sqrt((25 + 81) / 2) * 1e-5)
    assert result.predicted_rms == pytest.approx(np.sqrt(3 * (sigma**2 + TOUCH_SIGMA**2)))
    assert points[0].half_widths == pytest.approx(1.959964 * np.sqrt(13) * 1e-5)
    assert result.inside == [True] * 5 + [False]


def test_experiment_without_a_stripe_names_the_point_and_how_many_views_show_it(tmp_path: Path) -> None:
    cell = SimulatedCell(CellConfig(scene="experiment", motion="experiment"))
    camera = CameraInfo(width=640, height=480, pixel_format="mono8")
    dark = Dataset.create(tmp_path / "dark", camera=camera, laser=LaserInfo())
    grey = np.full((480, 640), 60, np.uint8)
    cell._recorded = cell.plan()
    for pose in cell.plan():
        dark.add_view(pose[:3, :3], pose[:3, 3], image=grey, laser_image=grey)
    calibration = refined(image_width=640, image_height=480, light_plane=cell.truth.light_plane)
    notes = Notes()
    with pytest.raises(InsufficientDataError, match="point S1: needs 2 views, found in 0"):
        _measured(tmp_path, cell, dark, calibration, notes)
    assert "point S1: left out in view 0" in "\n".join(notes.notes)
