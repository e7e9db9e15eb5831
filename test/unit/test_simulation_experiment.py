# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The scene of the paper's experiment: print at its exact place, marks, and where the light crosses them."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from pydantic import ValidationError
from scipy.optimize import brentq

from cv_active_handeye.simulation import CellConfig, SimulatedCell
from cv_active_handeye.simulation.desk import BLOCK_HEIGHTS, desk
from cv_active_handeye.simulation.lettering import INK, letter, mark, print_on
from cv_active_handeye.simulation.marks import ROWS, views_of
from cv_active_handeye.simulation.parts import pose

Array = NDArray[np.float64]


def experiment_cell(seed: int = 1) -> SimulatedCell:
    return SimulatedCell(CellConfig(seed=seed, scene="experiment", motion="experiment"))


def test_print_on_is_symmetric_about_a_slanted_stroke_and_as_wide_as_told() -> None:
    start, end, width = np.array([20.3, 10.2]), np.array([31.7, 88.9]), 7.5
    paper = np.full((100, 60), 0.75, np.float32)
    printed = print_on(paper, np.array([[start, end]]), np.array([width]))
    ink = (0.75 - printed.astype(np.float64)) / (0.75 - INK)
    for row in (30, 50, 70):
        centre = (ink[row] * np.arange(60)).sum() / ink[row].sum()
        share = (row - start[1]) / (end[1] - start[1])
        assert centre == pytest.approx(start[0] + share * (end[0] - start[0]), abs=0.01)
        slant = np.linalg.norm(end - start) / (end[1] - start[1])
        assert ink[row].sum() == pytest.approx(width * slant, abs=0.02)
    assert ink.max() == pytest.approx(1, abs=1e-4)


def test_print_on_leaves_paper_away_from_strokes_and_adds_no_ink_where_strokes_cross() -> None:
    paper = np.full((40, 40), 0.5, np.float32)
    cross = np.array([[[5.0, 20.0], [35.0, 20.0]], [[20.0, 5.0], [20.0, 35.0]]])
    printed = print_on(paper, cross, np.array([4.0, 4.0]))
    np.testing.assert_array_equal(printed[:8, :8], 0.5)
    assert printed.min() == pytest.approx(INK, abs=0.01)


def test_letter_and_mark_lie_on_their_surface() -> None:
    where = pose(0.1, -0.2, 0.3, (20, -30, 50))
    strokes = letter("T", 0.014, where)
    made = mark("S1", strokes[0], 0.25, where)
    in_plane = np.linalg.inv(where) @ np.append(made.position, 1)
    np.testing.assert_allclose(in_plane[:3], [0.5 * 0.6 * 0.014, 0.25 * 0.014, 0], atol=1e-12)
    np.testing.assert_allclose(made.along, where[:3, 1], atol=1e-12)
    np.testing.assert_allclose(made.normal, where[:3, 2], atol=1e-12)


def test_desk_has_ten_marks_in_a_plane_and_five_at_the_papers_heights() -> None:
    patches, marks = desk(np.random.default_rng(3))
    assert [m.name for m in marks] == [f"S{i}" for i in range(1, 16)]
    heights = np.array([m.position[2] for m in marks])
    np.testing.assert_allclose(heights[:10], heights[0], atol=1e-12)
    np.testing.assert_allclose(heights[10:] - heights[0], BLOCK_HEIGHTS, atol=1e-12)
    planar = [p.surface_id for p in patches if p.relief is None]
    assert planar == list(range(len(planar)))
    printed = [p for p in patches if p.lettering is not None]
    assert len(printed) == 6
    for patch in printed:
        assert patch.lettering is not None
        assert np.abs((patch.lettering.ends - patch.origin) @ patch.normal).max() < 1e-12


def test_measuring_poses_lay_the_light_on_the_marks_of_their_row_and_the_arm_reaches_them() -> None:
    cell = experiment_cell()
    poses = cell.plan()
    assert len(poses) == 32
    for view, stop in enumerate(poses):
        points, pixels = cell.crossings(stop)
        own = [number for row in ROWS for number in row if view in views_of(number)]
        assert own
        base = [cell.in_base(cell.marks[number].position) for number in own]
        np.testing.assert_allclose(points[own], base, atol=1e-6)
        assert np.all((pixels[own] > 100) & (pixels[own] < [540, 380]))


def test_crossings_are_where_light_surface_and_stroke_meet() -> None:
    cell = experiment_cell(4)
    stop = cell.plan()[5]
    stop[:3, 3] += [0.0006, 0.0009, -0.0005]
    points, pixels = cell.crossings(stop)
    truth = cell.truth
    to_camera = np.linalg.inv(stop)
    for number in (4, 12):
        here = cell.marks[number]

        def height_over_light(along: float, number: int = number) -> float:
            m = cell.marks[number]
            point = to_camera @ np.append(cell.in_base(m.position + along * m.along), 1)
            in_camera = truth.R_cam2gripper.T @ (point[:3] - truth.t_cam2gripper)
            return float(truth.light_plane[:3] @ in_camera - truth.light_plane[3])

        along = brentq(height_over_light, -0.2, 0.2, xtol=1e-12)
        expected = cell.in_base(here.position + along * here.along)
        np.testing.assert_allclose(points[number], expected, atol=1e-9)
        in_camera = truth.R_cam2gripper.T @ ((to_camera @ np.append(expected, 1))[:3] - truth.t_cam2gripper)
        seen = truth.camera_matrix @ in_camera
        np.testing.assert_allclose(pixels[number], seen[:2] / seen[2], atol=1e-6)


def test_motion_of_the_experiment_needs_its_scene() -> None:
    with pytest.raises(ValidationError, match="motion: 'experiment' needs the scene 'experiment', got 'workbench'"):
        CellConfig(motion="experiment")
    assert SimulatedCell(CellConfig()).marks == []
