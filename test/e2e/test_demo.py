# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The demo end to end: simulated images, tracks, stripes, refinement, report, pictures. One run, many questions."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
import trimesh
from support.command_line import run
from support.recordings import REPOSITORY

from cv_active_handeye.calibration import Calibration
from cv_active_handeye.cli.console import Exit
from cv_active_handeye.dataset import Dataset
from cv_active_handeye.files import FloatArray
from cv_active_handeye.measured_points import read_point_rows
from cv_active_handeye.simulation import CellConfig, SimulatedCell, SimulatedView, StripeTruth, Truth
from cv_active_handeye.workflow import calibrate
from cv_active_handeye.workflow.demo import MARKER, DemoResult, demo, prepare_folder
from cv_active_handeye.workflow.measure import measure
from cv_active_handeye.workflow.scan import scan
from cv_active_handeye.workflow.simulate import simulate


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> DemoResult:
    return demo(tmp_path_factory.mktemp("demo") / "out", CellConfig(seed=4))


def test_every_error_is_within_its_limit(result: DemoResult) -> None:
    assert result.beyond_limits() == []


def test_an_error_beyond_its_limit_or_missing_is_named(result: DemoResult) -> None:
    tight = replace(result.limits, **dict.fromkeys(vars(result.limits), 0.0))
    assert replace(result, limits=tight).beyond_limits() == list(vars(tight))
    missing = replace(result.errors, plane_offset_mm=None)
    assert replace(result, errors=missing).beyond_limits() == ["plane_offset_mm"]


def test_the_estimate_is_not_the_truth(result: DemoResult) -> None:
    assert result.errors.translation_mm > 1e-3
    assert result.errors.rotation_deg > 1e-4
    assert result.errors.plane_offset_mm is not None
    assert result.errors.plane_offset_mm > 1e-4


def test_files_of_the_demo_can_be_read_and_belong_together(result: DemoResult) -> None:
    dataset = Dataset.open(result.folder / "dataset")
    saved = Calibration.load(result.folder / "calibration.yaml")
    truth = Truth.load(result.folder / "truth.yaml")
    assert dataset.problems() == []
    assert len(dataset) == 14
    assert saved.dataset_sha256 == dataset.sha256()
    assert saved.to_yaml() == result.calibration.to_yaml()
    assert np.array_equal(truth.camera_matrix, result.truth.camera_matrix)


def test_no_true_parameter_is_written_into_the_data_set(result: DemoResult) -> None:
    truth = result.truth
    values = np.concatenate(
        [np.ravel(x) for x in (truth.camera_matrix, truth.R_cam2gripper, truth.t_cam2gripper, truth.light_plane)]
    )
    text = (result.folder / "dataset/dataset.yaml").read_text()
    told = [repr(float(x)) for x in values if abs(x) not in (0.0, 1.0) and repr(float(x)) in text]
    assert told == []
    assert not list((result.folder / "dataset").rglob("*truth*"))


def test_pictures_are_images_with_something_on_them(result: DemoResult) -> None:
    assert {path.name for path in result.pictures} == {"tracks.png", "motion.png", "stripe.png", "weld_seam.png"}
    for path in result.pictures:
        picture = cv2.imread(str(path))
        assert picture is not None
        assert min(picture.shape[:2]) > 600
        assert picture.std() > 10


def test_recording_has_what_the_demo_promises(result: DemoResult) -> None:
    rms = result.calibration.rms
    assert result.calibration.points >= 1000
    assert result.calibration.stripe_segments >= 30
    assert rms.points_px is not None
    assert rms.points_px < 0.1
    assert rms.stripes_px is not None
    assert rms.stripes_px < 0.1


def test_result_is_refined_usable_and_knows_the_noise_of_the_cell(result: DemoResult) -> None:
    found, cell = result.calibration, CellConfig()
    assert found.method == "refined"
    assert found.verdict is not None
    assert found.verdict.usable
    assert found.lens is not None
    assert (found.lens.model, found.lens.chosen) == ("none", True)
    levels = found.noise_levels
    assert levels is not None
    assert levels.robot_translation.level == pytest.approx(cell.repeatability_mm / 1000, rel=0.5)
    assert levels.robot_rotation.level == pytest.approx(np.radians(cell.repeatability_deg), rel=0.5)
    assert levels.image_points.level < 0.05
    assert levels.stated_points_px is not None


def test_weld_joint_is_measured_from_end_to_end_near_its_true_root(result: DemoResult) -> None:
    """The joint is 170 mm long, the stops 10 mm apart."""
    joint = result.joint
    assert joint.seam.length > 0.14
    assert len(joint.seam.views) + len(joint.seam.without_groove) == 20
    np.testing.assert_allclose(joint.seam.opening_angles, 59, atol=4)
    assert joint.rms_mm < joint.limit_mm
    assert joint.distances.max() < 1e-3
    cloud = trimesh.load(result.folder / "seam.ply")
    assert isinstance(cloud, trimesh.PointCloud)
    np.testing.assert_array_equal(cloud.vertices, joint.seam.points)
    scanned = trimesh.load(result.folder / "scan.ply")
    assert isinstance(scanned, trimesh.PointCloud)
    assert len(scanned.vertices) > 9000


def test_samples_find_the_seam_of_the_command(result: DemoResult) -> None:
    """The sample in Python and the one in C++, which `make test` builds where OpenCV's imgcodecs and yaml-cpp are."""
    files = [str(result.folder / "scan"), str(result.folder / "calibration.yaml")]
    samples = [[sys.executable, str(REPOSITORY / "samples/python/05_weld_seam.py")]]
    compiled = REPOSITORY / "build/python/bin/weld_seam"
    if compiled.exists():
        samples.append([str(compiled)])
    for sample in samples:
        printed = subprocess.run([*sample, *files], capture_output=True, text=True, check=True).stdout
        table = np.genfromtxt(printed.splitlines()[1:], delimiter=",")
        np.testing.assert_array_equal(table[:, 0], result.joint.seam.views)
        np.testing.assert_allclose(table[:, 1:4], 1000 * result.joint.seam.points, atol=6e-4)
        sigmas = np.sqrt(np.diagonal(result.joint.seam.covariances, axis1=1, axis2=2))
        np.testing.assert_allclose(table[:, 4:], 1000 * sigmas, atol=6e-4)


def test_intervals_are_narrow_and_few_miss_the_truth(result: DemoResult) -> None:
    """One of twenty is meant to miss; those that go together (nx and d, fx and fy) miss together."""
    inside = result.inside()
    assert len(inside) == 14
    assert sum(inside.values()) >= 11
    intervals = np.array([result.calibration.interval(name) for name in ("tx", "ty", "tz", "d")], np.float64)
    assert np.ptp(intervals, axis=1).max() < 5e-4


def test_report_is_one_page_that_says_usable(result: DemoResult) -> None:
    page = result.report.read_text(encoding="utf-8")
    assert result.report == result.folder / "report.html"
    assert "<title>Usable" in page
    assert 4e6 < len(page) < 8e6


def test_command_shows_estimate_truth_interval_and_report(result: DemoResult, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cv_active_handeye.workflow.demo.demo", lambda *arguments: result)
    shown = run("demo", "--seed", "4")
    assert shown.exit_code == Exit.USABLE
    rows = [line.split() for line in shown.output.splitlines() if line.split()[-2:-1] in (["yes"], ["no"])]
    unit_free = [line.split() for line in shown.output.splitlines() if line.split()[-1:] in (["yes"], ["no"])]
    assert len(rows) + len(unit_free) == 14
    held = sum(result.inside().values())
    assert sum("yes" in row for row in rows + unit_free) == held
    assert f"{held} of 14 intervals hold the truth" in shown.output
    assert f"{result.truth.camera_matrix[0, 0]:.2f}" in shown.output
    assert str(result.report) in shown.output.replace("\n", "")


def test_command_exits_5_beyond_its_limits(result: DemoResult, monkeypatch: pytest.MonkeyPatch) -> None:
    tight = replace(result, limits=replace(result.limits, fx_percent=0.0))
    monkeypatch.setattr("cv_active_handeye.workflow.demo.demo", lambda *arguments: tight)
    shown = run("demo")
    assert shown.exit_code == Exit.BEYOND_LIMITS
    assert "beyond the limits: fx_percent" in shown.output


def test_calibrate_again_gives_the_file_of_the_demo(result: DemoResult) -> None:
    assert calibrate(result.folder / "dataset").to_yaml() == result.calibration.to_yaml()


@pytest.mark.parametrize(("bump_mm", "status"), [(0.0, Exit.USABLE), (0.5, Exit.BEYOND_LIMITS)])
def test_verify_believes_the_cell_as_it_is_and_not_a_bumped_one(
    result: DemoResult, tmp_path: Path, bump_mm: float, status: Exit
) -> None:
    simulate(tmp_path / "check", tmp_path / "truth.yaml", CellConfig(seed=4, motion="check", bump_mm=bump_mm))
    shown = run("verify", tmp_path / "check", "--calibration", result.folder / "calibration.yaml")
    assert shown.exit_code == status
    assert "alid: " in shown.output


def test_prepare_folder_replaces_what_a_demo_wrote_and_nothing_else(tmp_path: Path) -> None:
    folder = tmp_path / "demo"
    prepare_folder(folder)
    (folder / "dataset").mkdir()
    (folder / "dataset/dataset.yaml").write_text("old")
    (folder / "truth.yaml").write_text("old")
    (folder / "notes.txt").write_text("mine")
    prepare_folder(folder)
    assert sorted(path.name for path in folder.iterdir()) == [MARKER, "notes.txt"]


def test_prepare_folder_refuses_a_folder_of_someone_else_and_a_file(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(FileExistsError, match="was not written by the demo"):
        prepare_folder(tmp_path)
    with pytest.raises(FileExistsError, match="was not written by the demo"):
        prepare_folder(tmp_path / "notes.txt")
    assert (tmp_path / "notes.txt").read_text() == "mine"


@pytest.fixture(scope="module")
def scanned(result: DemoResult) -> tuple[SimulatedCell, Dataset]:
    """Four stops of a scan of the same cell."""
    cell = SimulatedCell(CellConfig(seed=4, motion="scan"))
    return cell, cell.record(result.folder.parent / "scan", poses=cell.plan()[5::9])


def true_stripe(cell: SimulatedCell, view: int) -> tuple[StripeTruth, FloatArray]:
    """The exact stripe of a recorded view, and its points (N, 3) in the base frame, m."""
    pose, truth = np.eye(4), cell.truth
    pose[:3, :3], pose[:3, 3] = truth.views[view].R_gripper2base, truth.views[view].t_gripper2base
    stripe = cell.stripe(SimulatedView(pose, np.zeros((1, 1), np.uint8), None, pose, view))
    in_gripper = stripe.points_3d @ truth.R_cam2gripper.T + truth.t_cam2gripper
    return stripe, np.asarray(in_gripper @ pose[:3, :3].T + pose[:3, 3])


def test_scan_lies_on_the_surfaces_of_the_cell(result: DemoResult, scanned: tuple[SimulatedCell, Dataset]) -> None:
    cell, dataset = scanned
    cloud = scan(dataset, result.calibration)
    assert len(cloud.points) > 1500
    distances = []
    for view in range(4):
        _, true = true_stripe(cell, view)
        apart = cloud.points[cloud.views == view][:, None] - true
        distances.append(np.linalg.norm(apart, axis=2).min(axis=1))
    ratios = np.concatenate(distances) / cloud.sigmas
    assert np.median(np.concatenate(distances)) < 2e-4
    assert np.mean(ratios < 2.5) > 0.9


def test_points_of_the_cell_are_measured_within_their_intervals(
    result: DemoResult, scanned: tuple[SimulatedCell, Dataset]
) -> None:
    """Columns far from the ends of plane surfaces; the truth stands in the file as a touched point would."""
    cell, dataset = scanned
    lines = ["name,view,u,v,x,y,z"]
    for view in range(4):
        stripe, true = true_stripe(cell, view)
        for k in range(20, len(true) - 20, 40):
            around = slice(k - 16, k + 17)
            plane = (stripe.surface_ids[around] == stripe.surface_ids[k]).all() and stripe.surface_ids[k] >= 0
            if plane and np.ptp(stripe.points[around, 0]) == 32:
                numbers = [*stripe.points[k], *(1000 * true[k])]
                lines.append(f"S{len(lines)},{view}," + ",".join(f"{x:.5f}" for x in numbers))
    points = result.folder.parent / "points.csv"
    points.write_text("\n".join(lines) + "\n")
    found = measure(dataset, result.calibration, read_point_rows(points))
    assert len(found) > 15
    errors = np.array([point.difference for point in found])
    assert np.sqrt(np.mean(np.sum(errors**2, axis=1))) < 2.5e-4
    assert np.mean(np.abs(errors) < [point.half_widths for point in found]) > 0.85
