# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Crossings of stripe and stroke, found in rendered images, are where the simulated cell knows them to be."""

from __future__ import annotations

import numpy as np
import pytest
from support.calibrations import true_calibration

from cv_active_handeye.dataset import Dataset
from cv_active_handeye.files import FileFormatError, FloatArray
from cv_active_handeye.simulation import CellConfig, SimulatedCell
from cv_active_handeye.simulation.marks import views_of
from cv_active_handeye.workflow.profiles import Profiler, profiler
from cv_active_handeye.workflow.reporter import InsufficientDataError, Silent
from cv_active_handeye.workflow.strokes import stroke_crossing

VIEWS = (0, 6, 13)
"""Of S1 to S4, of S5 to S7, and of S11 on the highest block."""


@pytest.fixture(scope="module")
def cell() -> SimulatedCell:
    return SimulatedCell(CellConfig(seed=1, scene="experiment", motion="experiment", exposure=0.7))


@pytest.fixture(scope="module")
def tool(cell: SimulatedCell, tmp_path_factory: pytest.TempPathFactory) -> Profiler:
    """Three of the measuring views, and a calibration that is true."""
    stops = cell.plan()
    dataset = cell.record(tmp_path_factory.mktemp("strokes") / "set", poses=[stops[view] for view in VIEWS])
    return profiler(dataset, true_calibration(cell.truth), Silent())


def true_pixels(cell: SimulatedCell, number: int) -> FloatArray:
    """Of all marks (15, 2) in the recorded view `number`."""
    pose, view = np.eye(4), cell.truth.views[number]
    pose[:3, :3], pose[:3, 3] = view.R_gripper2base, view.t_gripper2base
    return cell.crossings(pose)[1]


def test_crossings_of_letters_and_blocks_are_found_to_hundredths_of_a_pixel(
    cell: SimulatedCell, tool: Profiler
) -> None:
    errors, sigmas = [], []
    for number, stop in enumerate(VIEWS):
        profile = tool.profile(number)
        assert profile is not None
        for mark in (k for k in range(15) if stop in views_of(k)):
            exact = true_pixels(cell, number)[mark]
            found = stroke_crossing(tool, profile, np.rint(np.add(exact, (3, -3))))
            again = stroke_crossing(tool, profile, np.rint(np.add(exact, (-3, 3))))
            np.testing.assert_allclose(found.pixel, again.pixel, atol=0.02)
            errors.append(found.pixel - exact)
            sigmas.append(found.sigmas)
    assert len(errors) == 8
    assert np.sqrt(np.mean(np.square(errors), axis=0)).max() < 0.03
    assert np.abs(errors).max() < 0.08
    assert np.all((np.array(sigmas) > 0.01) & (np.array(sigmas) < 0.15))


def test_place_without_a_stroke_and_place_without_a_stripe_are_told(cell: SimulatedCell, tool: Profiler) -> None:
    profile = tool.profile(0)
    assert profile is not None
    stroke, after = true_pixels(cell, 0)[2:4]
    with pytest.raises(InsufficientDataError, match="in view 0"):
        stroke_crossing(tool, profile, (stroke + 3 * after) / 4 + [-4.0, 0])
    with pytest.raises(InsufficientDataError, match="needs a straight piece of the stripe within 10 px"):
        stroke_crossing(tool, profile, np.add(stroke, (0, 60)))


def test_view_without_a_laser_off_image_and_vertical_stripes_are_refused(cell: SimulatedCell, tool: Profiler) -> None:
    profile = tool.profile(0)
    assert profile is not None
    folder = tool.dataset.folder
    bare = folder.with_name("bare")
    if not bare.exists():
        copy = Dataset.create(bare, camera=tool.dataset.camera, laser=tool.dataset.laser)
        view = tool.dataset.views[0]
        copy.add_view(view.R_gripper2base, view.t_gripper2base, laser_image=tool.dataset.laser_image(0))
    calibration = true_calibration(cell.truth)
    with pytest.raises(InsufficientDataError, match="view 0: needs an image with the laser off"):
        stroke_crossing(profiler(Dataset.open(bare), calibration, Silent()), profile, np.array([300.0, 240.0]))
    assert tool.dataset.laser is not None
    vertical = tool.dataset.laser.model_copy(update={"stripe": "vertical"})
    other = Dataset.create(folder.with_name("vertical"), camera=tool.dataset.camera, laser=vertical)
    with pytest.raises(FileFormatError, match="needs a horizontal stripe across the strokes"):
        stroke_crossing(profiler(other, calibration, Silent()), profile, np.array([300.0, 240.0]))
