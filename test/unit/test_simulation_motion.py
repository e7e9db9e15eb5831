# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Motions that check a calibration or scan the bench, and a camera that was pushed: options of the simulated cell."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.spatial.transform import Rotation

import cv_active_handeye as cah
from cv_active_handeye.simulation import CellConfig, SimulatedCell, Truth
from cv_active_handeye.workflow.simulate import simulate

SMALL = {"width": 160, "height": 120, "focal_px": 353.0, "texel_mm": 0.8, "lamp": False}


def small_cell(**settings: object) -> SimulatedCell:
    return SimulatedCell(CellConfig.model_validate({**SMALL, **settings}))


@pytest.mark.parametrize("robot", ["denso_vp6242", "ur5e"])
@pytest.mark.parametrize("seed", range(4))
def test_check_motion_is_five_other_stops_in_reach_that_turn_about_all_axes(robot: str, seed: int) -> None:
    poses = np.array(small_cell(robot=robot, seed=seed, motion="check").plan())  # reachable, or it would raise
    assert len(poses) == 5
    groups = cah.groupViews(list(poses[:, :3, :3])).ravel()
    assert groups.tolist() == [0, 0, 1, 2, 3]
    turns = [Rotation.from_matrix(poses[0, :3, :3].T @ poses[i, :3, :3]).as_rotvec() for i in (2, 3, 4)]
    assert np.degrees(np.linalg.norm(turns, axis=1)).min() > 10
    assert np.linalg.matrix_rank(turns, tol=0.05) == 3
    default = np.array(small_cell(robot=robot, seed=seed).plan())
    nearest = np.linalg.norm(poses[:, None, :3, 3] - default[None, :, :3, 3], axis=2).min(axis=1)
    assert nearest.min() > 0.005


def test_check_motion_looks_at_the_bench_from_working_distance() -> None:
    cell = small_cell(seed=1, motion="check", laser=False)
    views = [cell.capture(pose, i) for i, pose in enumerate(cell.plan())]
    grid = np.stack(np.meshgrid(np.arange(4.5, 160, 8), np.arange(4.5, 120, 8)), axis=-1).reshape(-1, 2)
    for view in views[1:]:
        assert np.isfinite(cell.correspond(views[0], view, grid)).all(axis=1).mean() > 0.2
        assert 0.45 < np.median(cell.stripe(view).points_3d[:, 2]) < 0.65


@pytest.mark.parametrize("robot", ["denso_vp6242", "ur5e"])
@pytest.mark.parametrize("seed", range(4))
def test_scan_motion_is_a_straight_line_of_even_steps_in_reach(robot: str, seed: int) -> None:
    cell = small_cell(robot=robot, seed=seed, motion="scan")
    poses = np.array(cell.plan())  # reachable, or it would raise
    assert len(poses) == 40
    np.testing.assert_allclose(poses[:, :3, :3], poses[:1, :3, :3].repeat(40, axis=0), atol=1e-12)
    steps = np.diff(poses[:, :3, 3], axis=0)
    np.testing.assert_allclose(steps, steps[:1].repeat(39, axis=0), atol=1e-12)
    assert np.linalg.norm(steps[0]) == pytest.approx(0.005)
    # the stripe lies along the image's rows, so the camera has to move along its columns
    R_cam2base = poses[0, :3, :3] @ cell.truth.R_cam2gripper
    np.testing.assert_allclose(np.abs(steps[0] @ R_cam2base), [0, 0.005, 0], atol=1e-12)


def test_scan_sees_the_stripe_at_every_stop() -> None:
    cell = small_cell(seed=1, motion="scan")
    for index, pose in list(enumerate(cell.plan()))[::13]:
        stripe = cell.stripe(cell.capture(pose, index))
        assert len(stripe.points) > 80
        assert 0.4 < np.median(stripe.points_3d[:, 2]) < 0.65


def test_check_recording_is_of_the_same_cell_at_another_time(tmp_path: Path) -> None:
    """Hardware is the same; robot and image noise are drawn anew."""
    default, check = small_cell(seed=3), small_cell(seed=3, motion="check")
    assert default.truth.model_dump(exclude={"views"}) == check.truth.model_dump(exclude={"views"})
    check.record(tmp_path / "check")
    default.record(tmp_path / "same stops", poses=check.plan())
    errors = []
    for cell in (default, check):
        commanded = check.plan()
        errors.append([v.t_gripper2base - c[:3, 3] for v, c in zip(cell.truth.views, commanded, strict=True)])
    assert np.abs(np.array(errors[0]) - np.array(errors[1])).min() > 0
    assert np.corrcoef(np.ravel(errors[0]), np.ravel(errors[1]))[0, 1] < 0.8


@pytest.mark.parametrize(("bump_mm", "bump_deg"), [(0.5, 0.0), (0.0, 0.1), (2.0, 1.0)])
def test_bump_moves_the_camera_by_what_is_asked_and_its_laser_with_it(bump_mm: float, bump_deg: float) -> None:
    before, after = small_cell(seed=4), small_cell(seed=4, bump_mm=bump_mm, bump_deg=bump_deg)
    a, b = before.truth, after.truth
    assert 1000 * np.linalg.norm(b.t_cam2gripper - a.t_cam2gripper) == pytest.approx(bump_mm, abs=1e-12)
    turn = Rotation.from_matrix(a.R_cam2gripper.T @ b.R_cam2gripper).magnitude()
    assert np.degrees(turn) == pytest.approx(bump_deg, abs=1e-9)
    assert np.array_equal(a.light_plane, b.light_plane)
    assert np.array_equal(a.camera_matrix, b.camera_matrix)
    for pose, same in zip(before.plan(), after.plan(), strict=True):
        np.testing.assert_array_equal(pose, same)


def test_bump_goes_where_the_seed_says() -> None:
    shifts = []
    for seed in range(12):
        a, b = small_cell(seed=seed).truth, small_cell(seed=seed, bump_mm=1.0).truth
        shifts.append(a.R_cam2gripper.T @ (b.t_cam2gripper - a.t_cam2gripper))
    assert np.linalg.matrix_rank(np.array(shifts), tol=1e-3) == 3
    assert np.linalg.norm(np.mean(shifts, axis=0)) < 7e-4


def test_bump_shows_in_the_image() -> None:
    before, after = small_cell(seed=5, laser=False), small_cell(seed=5, laser=False, bump_mm=5.0)
    pose = before.plan()[0]
    grid = np.array([[80.0, 60.0]])
    a, b = before.capture(pose, 0), after.capture(pose, 0)
    assert a.image.tobytes() != b.image.tobytes()
    np.testing.assert_array_equal(a.T_true, b.T_true)
    np.testing.assert_allclose(before.correspond(a, a, grid), grid, atol=1e-9)


@pytest.mark.parametrize("settings", [{"bump_mm": -1}, {"bump_mm": 51}, {"bump_deg": 21}, {"motion": "spiral"}])
def test_impossible_settings_are_refused_by_name(settings: dict[str, object]) -> None:
    with pytest.raises(ValidationError, match=next(iter(settings))):
        CellConfig.model_validate(settings)


def test_simulate_writes_the_check_motion_and_the_truth_of_the_bump(tmp_path: Path) -> None:
    config = CellConfig.model_validate({**SMALL, "seed": 6, "motion": "check", "bump_mm": 0.5, "laser": False})
    dataset, truth = simulate(tmp_path / "set", tmp_path / "deep" / "truth.yaml", config)
    assert len(dataset) == 5
    loaded = Truth.load(tmp_path / "deep" / "truth.yaml")
    assert loaded.model_dump() == truth.model_dump()
    moved = np.linalg.norm(loaded.t_cam2gripper - small_cell(seed=6).truth.t_cam2gripper)
    assert 1000 * moved == pytest.approx(0.5, abs=1e-9)


def test_simulate_refuses_to_put_the_truth_into_the_data_set(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="truth_file: needs a place outside"):
        simulate(tmp_path / "set", tmp_path / "set" / "truth.yaml", CellConfig.model_validate(SMALL))
    assert not (tmp_path / "set").exists()
