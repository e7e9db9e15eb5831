# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The simulated cell: seeds, robot errors, motion plan, recording, truth kept apart, exact correspondences."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from pydantic import ValidationError
from scipy.spatial.transform import Rotation

import cv_active_handeye as cah
from cv_active_handeye.dataset import Dataset
from cv_active_handeye.files import FileFormatError
from cv_active_handeye.robots.kinematics import UnreachableError
from cv_active_handeye.simulation import CellConfig, SimulatedCell, SimulatedView, Truth
from cv_active_handeye.simulation.robot_errors import RobotErrors

Array = NDArray[np.float64]

SMALL = {"width": 160, "height": 120, "focal_px": 353.0, "texel_mm": 0.8}
PERFECT_ROBOT = {"repeatability_mm": 0.0, "repeatability_deg": 0.0, "servo_mm": 0.0, "servo_deg": 0.0}


def small_cell(**settings: object) -> SimulatedCell:
    return SimulatedCell(CellConfig.model_validate({**SMALL, **settings}))


@pytest.fixture(scope="module")
def cell() -> SimulatedCell:
    return small_cell(seed=5)


@pytest.fixture(scope="module")
def views(cell: SimulatedCell) -> list[SimulatedView]:
    return [cell.capture(pose, i) for i, pose in enumerate(cell.plan())]


def test_capture_with_the_same_seed_gives_the_same_bytes(cell: SimulatedCell, views: list[SimulatedView]) -> None:
    again = small_cell(seed=5)
    for index in (9, 0):
        view = again.capture(again.plan()[index], index)
        assert view.image.tobytes() == views[index].image.tobytes()
        assert view.laser_image is not None
        assert view.laser_image.tobytes() == views[index].laser_image.tobytes()  # type: ignore[union-attr]
        np.testing.assert_array_equal(view.T_reported, views[index].T_reported)
        np.testing.assert_array_equal(view.T_true, views[index].T_true)


def test_another_seed_is_another_experiment(cell: SimulatedCell, views: list[SimulatedView]) -> None:
    other = small_cell(seed=6)
    a, b = cell.truth, other.truth
    assert 0.1 < np.degrees(Rotation.from_matrix(a.R_cam2gripper.T @ b.R_cam2gripper).magnitude()) < 3.5
    assert 1e-4 < np.abs(a.t_cam2gripper - b.t_cam2gripper).max() < 0.007
    assert 0.1 < abs(a.camera_matrix[0, 0] - b.camera_matrix[0, 0]) < 3
    assert 1e-5 < abs(a.light_plane[3] - b.light_plane[3]) < 0.006
    view = other.capture(other.plan()[0], 0)
    correlation = np.corrcoef(view.image.ravel(), views[0].image.ravel())[0, 1]
    assert correlation < 0.9
    noise = [v.T_true[:3, 3] - v.T_reported[:3, 3] for v in (view, views[0])]
    assert np.abs(noise[0] - noise[1]).max() > 1e-6


def test_capture_draws_new_noise_for_every_stop_and_the_same_for_the_same_stop(cell: SimulatedCell) -> None:
    pose = cell.plan()[0]
    first, again, next_stop = (cell.capture(pose, i) for i in (3, 3, 4))
    assert first.image.tobytes() == again.image.tobytes()
    assert (first.image != next_stop.image).mean() > 0.3
    counted = [cell.capture(pose).index for _ in range(2)]
    assert counted[1] == counted[0] + 1


def test_image_noise_of_two_captures_is_that_of_the_sensor() -> None:
    cell = small_cell(lamp=False, bit_depth=16, laser=False, **PERFECT_ROBOT)
    pose, config = cell.plan()[0], cell.config
    a, b = (cell.capture(pose, i).image / 65535 for i in (0, 1))
    mean, variance = (a + b) / 2, (a - b) ** 2 / 2
    expected = mean / config.full_well_electrons + (config.read_noise_electrons / config.full_well_electrons) ** 2
    for low, high in ((0.1, 0.3), (0.3, 0.5)):
        chosen = (mean > low) & (mean < high)
        assert chosen.sum() > 1000
        assert (variance / expected)[chosen].mean() == pytest.approx(1, abs=0.12)


def test_robot_errors_have_the_configured_sigmas() -> None:
    config = CellConfig(repeatability_mm=0.05, repeatability_deg=0.02, servo_mm=0.01, servo_deg=0.004)
    errors = RobotErrors(config, 2)
    command = np.eye(4)
    command[:3, :3] = Rotation.from_rotvec([0.3, -2, 1]).as_matrix()
    reported = [errors.reported(command, i) for i in range(1500)]
    true = [errors.true(pose, i) for i, pose in enumerate(reported)]
    for poses, origin, mm, deg in ((reported, [command] * 1500, 0.01, 0.004), (true, reported, 0.05, 0.02)):
        shift = np.array([p[:3, 3] - o[:3, 3] for p, o in zip(poses, origin, strict=True)])
        turn = np.array(
            [Rotation.from_matrix(p[:3, :3] @ o[:3, :3].T).as_rotvec() for p, o in zip(poses, origin, strict=True)]
        )
        np.testing.assert_allclose(1000 * shift.std(axis=0), mm, rtol=0.07)
        np.testing.assert_allclose(np.degrees(turn.std(axis=0)), deg, rtol=0.07)
        assert np.abs(shift.mean(axis=0)).max() < 0.1 * mm / 1000


def test_absolute_error_is_smooth_has_the_configured_size_and_is_zero_by_default() -> None:
    np.testing.assert_array_equal(RobotErrors(CellConfig(), 2).absolute(np.ones(3)), 0)
    rng = np.random.default_rng(1)
    rms, slopes = [], []
    for seed in range(30):
        errors = RobotErrors(CellConfig(seed=seed, absolute_error_mm=0.5, absolute_error_deg=0.05), 2)
        positions = rng.uniform(-2, 2, (60, 3))
        shift = np.array([errors.absolute(p)[0] for p in positions])
        rms.append((shift**2).sum(axis=1).mean())
        step = np.array([errors.absolute(p + np.array([0.05, 0, 0]))[0] for p in positions]) - shift
        slopes.append(np.linalg.norm(step, axis=1).max())
    assert 1000 * np.sqrt(np.mean(rms)) == pytest.approx(0.5, rel=0.1)
    assert 1e-5 < max(slopes) < 0.0005  # a move of 50 mm sees less than the error itself


@pytest.mark.parametrize("robot", ["denso_vp6242", "ur5e"])
@pytest.mark.parametrize("seed", range(4))
def test_plan_is_two_groups_of_four_translations_and_two_more_orientations(robot: str, seed: int) -> None:
    cell = small_cell(robot=robot, seed=seed)
    poses = np.array(cell.plan())  # reachable, or it would raise
    groups = cah.groupViews(list(poses[:, :3, :3])).ravel()
    assert groups.tolist() == [0] * 5 + [1] * 5 + [2] * 2 + [3] * 2
    for group in (0, 1):
        R = poses[groups == group][0, :3, :3]
        moves = (poses[groups == group][1:, :3, 3] - poses[groups == group][0, :3, 3]) @ R
        assert np.linalg.norm(moves, axis=1).min() > 0.04
        volumes = [abs(np.linalg.det(np.delete(moves, i, axis=0))) for i in range(4)]
        assert min(volumes) > 0.04**3  # no three directions near a plane
    turns = [Rotation.from_matrix(poses[0, :3, :3].T @ poses[i, :3, :3]).as_rotvec() for i in (5, 10, 12)]
    assert np.degrees([np.linalg.norm(t) for t in turns]).min() > 20
    assert abs(np.linalg.det([t / np.linalg.norm(t) for t in turns])) > 0.2


def test_plan_keeps_the_bench_in_view_at_working_distance(cell: SimulatedCell, views: list[SimulatedView]) -> None:
    for view in views:
        stripe = cell.stripe(view)
        assert len(stripe.points) > 0.7 * cell.camera.width
        assert 0.42 < np.median(stripe.points_3d[:, 2]) < 0.68
        assert np.abs(stripe.points[:, 1] - 60).max() < 50
    together = cell.correspond(views[1], views[2], pixel_grid())
    assert np.isfinite(together).all(axis=1).mean() > 0.25


def pixel_grid() -> Array:
    return np.stack(np.meshgrid(np.arange(4.5, 160, 8), np.arange(4.5, 120, 8)), axis=-1).reshape(-1, 2)


def test_reported_poses_are_rotations_to_machine_precision(views: list[SimulatedView]) -> None:
    for view in views:
        R = view.T_reported[:3, :3]
        np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-14)
        np.testing.assert_array_equal(view.T_reported[3], [0, 0, 0, 1])


def test_capture_out_of_reach_says_why(cell: SimulatedCell) -> None:
    pose = cell.plan()[0].copy()
    pose[0, 3] += 0.5
    with pytest.raises(UnreachableError, match=r"DENSO VP-6242: .* reach is 432 mm"):
        cell.capture(pose)


def test_record_out_of_reach_names_the_stop_and_writes_nothing(cell: SimulatedCell, tmp_path: Path) -> None:
    poses = cell.plan()[:3]
    poses[2] = poses[2].copy()
    poses[2][2, 3] += 0.6
    with pytest.raises(UnreachableError, match="stop 2 of 3: "):
        cell.record(tmp_path / "set", poses=poses)
    assert not (tmp_path / "set").exists()


def test_record_writes_what_capture_returns_and_tells_progress(
    cell: SimulatedCell, views: list[SimulatedView], tmp_path: Path
) -> None:
    seen: list[tuple[int, int]] = []
    cell.record(tmp_path / "set", progress=lambda done, total: seen.append((done, total)))
    assert seen == [(i + 1, 14) for i in range(14)]
    dataset = Dataset.open(tmp_path / "set")
    assert dataset.problems() == []
    assert dataset.laser is not None
    for i, view in enumerate(views):
        np.testing.assert_array_equal(dataset.image(i), view.image)
        np.testing.assert_array_equal(dataset.laser_image(i), view.laser_image)
        np.testing.assert_array_equal(dataset.R_gripper2base[i], view.T_reported[:3, :3])
        np.testing.assert_array_equal(dataset.t_gripper2base[i], view.T_reported[:3, 3])
        np.testing.assert_array_equal(cell.truth.views[i].t_gripper2base, view.T_true[:3, 3])


def test_record_leaves_no_truth_in_the_data_set(tmp_path: Path) -> None:
    cell = small_cell(seed=8, lamp=False)
    cell.record(tmp_path / "set", poses=cell.plan()[:2])
    truth = cell.truth
    files = [p for p in (tmp_path / "set").rglob("*") if p.is_file()]
    assert sorted(p.suffix for p in files) == [".png"] * 4 + [".yaml"]
    text = (tmp_path / "set" / "dataset.yaml").read_text()
    numbers = [
        truth.camera_matrix[[0, 1, 0, 1], [0, 1, 2, 2]],
        truth.R_cam2gripper.ravel(),
        truth.t_cam2gripper,
        truth.light_plane,
        *[v.t_gripper2base for v in truth.views],
    ]
    for number in np.concatenate(numbers):
        assert f"{number:.6g}"[:8].rstrip("0") not in text


def test_truth_survives_its_file(cell: SimulatedCell, tmp_path: Path) -> None:
    cell.truth.save(tmp_path / "truth.yaml")
    loaded = Truth.load(tmp_path / "truth.yaml")
    assert loaded.model_dump() == cell.truth.model_dump()


def test_truth_save_inside_a_data_set_is_refused(cell: SimulatedCell, tmp_path: Path) -> None:
    small_cell(laser=False).record(tmp_path / "set", poses=[])
    for path in (tmp_path / "set" / "truth.yaml", tmp_path / "set" / "images" / "truth.yaml"):
        with pytest.raises(ValueError, match="truth must stay outside data sets"):
            cell.truth.save(path)
        assert not path.exists()


def test_truth_load_refuses_unknown_keys_and_versions(cell: SimulatedCell, tmp_path: Path) -> None:
    cell.truth.save(tmp_path / "truth.yaml")
    text = (tmp_path / "truth.yaml").read_text()
    (tmp_path / "more.yaml").write_text(text + "colour: red\n")
    with pytest.raises(FileFormatError, match="key 'colour' is unknown"):
        Truth.load(tmp_path / "more.yaml")
    (tmp_path / "newer.yaml").write_text(text.replace("schema_version: 1", "schema_version: 2"))
    with pytest.raises(FileFormatError, match="schema_version"):
        Truth.load(tmp_path / "newer.yaml")


def test_config_refuses_unknown_keys_and_impossible_values() -> None:
    with pytest.raises(ValidationError, match="colour"):
        CellConfig.model_validate({"colour": "red"})
    with pytest.raises(ValidationError, match="robot"):
        CellConfig.model_validate({"robot": "kuka"})
    with pytest.raises(ValidationError, match="repeat_mm: needs at least 20 texels"):
        CellConfig(texture="repeated", repeat_mm=5, texel_mm=0.5)


def test_cell_without_laser_has_no_laser_images(tmp_path: Path) -> None:
    cell = small_cell(laser=False, lamp=False)
    dataset = cell.record(tmp_path / "set", poses=cell.plan()[:1])
    assert dataset.laser is None
    assert dataset.laser_image(0) is None


def test_correspond_there_and_back_returns_the_same_pixels(cell: SimulatedCell, views: list[SimulatedView]) -> None:
    there = cell.correspond(views[0], views[12], pixel_grid())
    back = cell.correspond(views[12], views[0], there)
    seen = np.isfinite(there).all(axis=1)
    assert 0.3 < seen.mean() < 1.0
    np.testing.assert_array_equal(np.isnan(back), np.isnan(there))
    np.testing.assert_allclose(back[seen], pixel_grid()[seen], atol=1e-7)


def test_correspond_finds_the_same_grey_value(cell: SimulatedCell, views: list[SimulatedView]) -> None:
    points = np.stack(np.meshgrid(np.arange(160.0), np.arange(120.0)), axis=-1).reshape(-1, 2)
    other = cell.correspond(views[0], views[1], points)
    seen = np.isfinite(other).all(axis=1)
    a = views[0].image.ravel()[seen].astype(np.float64)
    u, v = np.rint(other[seen]).astype(int).T
    b = views[1].image[np.clip(v, 0, 119), np.clip(u, 0, 159)].astype(np.float64)
    shuffled = np.random.default_rng(0).permutation(b)
    assert np.corrcoef(a, b)[0, 1] > 0.8
    assert abs(np.corrcoef(a, shuffled)[0, 1]) < 0.05


def test_correspond_refuses_points_of_wrong_shape(cell: SimulatedCell, views: list[SimulatedView]) -> None:
    with pytest.raises(ValueError, match=r"points: needs shape \(N, 2\), got \(3,\)"):
        cell.correspond(views[0], views[1], np.zeros(3))


def test_closed_forms_recover_the_truth_from_exact_correspondences() -> None:
    cell = small_cell(seed=11, lamp=False, distortion=(-0.1, 0.05, 0.001, -0.001, 0.0), **PERFECT_ROBOT)
    views = [cell.capture(pose, i) for i, pose in enumerate(cell.plan())]
    points = [cell.correspond(views[0], view, pixel_grid()) for view in views]
    R, t = [v.T_reported[:3, :3] for v in views], [v.T_reported[:3, 3] for v in views]
    truth = cell.truth
    D = truth.distortion_coefficients
    # A camera matrix is needed to undo distortion, so K is given and R_cam2gripper is asked for.
    _, K, R_cam2gripper, _ = cah.calibrateHandEyeTranslations(
        R, t, points, truth.camera_matrix, D, flags=cah.TRANSLATIONS_FIX_K
    )
    _, t_cam2gripper, _ = cah.calibrateHandEyeRotation(R, t, points, K, D, R_cam2gripper)
    np.testing.assert_allclose(R_cam2gripper, truth.R_cam2gripper, atol=1e-8)
    np.testing.assert_allclose(t_cam2gripper.ravel(), truth.t_cam2gripper, atol=1e-8)


def test_weld_seam_is_the_line_in_which_the_bevels_would_meet(cell: SimulatedCell) -> None:
    """170 mm long; from its ends, in the bench's frame, both bevels rise under 60 degrees at both sides."""
    assert cell.weld_seam is not None
    ends = (cell.weld_seam - cell._T_bench2base[:3, 3]) @ cell._T_bench2base[:3, :3]
    assert np.linalg.norm(ends[1] - ends[0]) == pytest.approx(0.170, abs=1e-9)
    for side in ("left", "right"):
        faces = [patch for patch in cell.scene.patches if patch.name.startswith(f"weld {side}/")]
        [bevel] = [face for face in faces if abs(face.normal[2] - 0.5) < 1e-9]
        np.testing.assert_allclose((ends - bevel.origin) @ bevel.normal, 0, atol=1e-12)
