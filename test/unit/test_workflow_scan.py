# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A scan's points lie on the true surfaces within their sigmas; views without a stripe and wrong files are told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.calibrations import closed_form, true_calibration
from support.exact_recording import exact_recording
from support.recordings import Notes, exact_dataset
from support.stripe_recording import Stop, calibration_of_truth, laser_dataset, record, true_plane

from cv_active_handeye.dataset import Dataset
from cv_active_handeye.files import FileFormatError, FloatArray
from cv_active_handeye.simulation import CellConfig, SimulatedCell, SimulatedView
from cv_active_handeye.workflow import InsufficientDataError
from cv_active_handeye.workflow.profiles import find_profiles, profiler
from cv_active_handeye.workflow.reporter import Silent
from cv_active_handeye.workflow.scan import Scan, scan, worst_sigma

SURFACES = (0, 1, 2, 0, 1, 2)


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return laser_dataset(tmp_path_factory.mktemp("scan") / "set", SURFACES)


def heights(cloud: Scan, surfaces: tuple[int, ...] = SURFACES) -> list[FloatArray]:
    """Distances of every view's points from the surface that its stripe crosses, m."""
    planes = [true_plane(surface) for surface in surfaces]
    found = []
    for view, plane in enumerate(planes):
        found.append(cloud.points[cloud.views == view] @ plane[:3] - plane[3])
    return found


def test_exact_calibration_puts_the_points_on_the_surfaces(recording: Dataset) -> None:
    cloud = scan(recording, calibration_of_truth())
    assert sorted(set(cloud.views.tolist())) == list(range(6))
    assert len(cloud.points) == len(cloud.sigmas) == len(cloud.intensity) > 1000
    for distances in heights(cloud):
        # 0.02 px at 0.55 m, and a light plane under 60 degrees: some hundredths of a millimetre
        assert np.abs(distances).mean() < 3e-5
    assert cloud.empty_views == ()
    assert 180 < np.median(cloud.intensity) <= 202


def test_points_are_within_their_sigmas_of_the_surfaces(tmp_path: Path) -> None:
    """Forty calibrations and robots, each off by what it says of itself. A sigma is that of the worst direction, so the
    distances from a surface are at most as large as it says. Points of one scan share their errors: one ratio each."""
    ratios = []
    for seed in range(40):
        surface = (seed % 3,)
        cloud = scan(laser_dataset(tmp_path / str(seed), surface, robot_seed=100 + seed), calibration_of_truth(seed))
        ratios.append(float(np.mean(heights(cloud, surface)[0] / cloud.sigmas)))
    assert 0.6 < np.sqrt(np.mean(np.square(ratios))) < 1.2
    assert np.mean(np.abs(ratios) < 1.96) >= 0.9


def test_simulated_cell_is_scanned_within_the_sigmas(tmp_path: Path) -> None:
    """The calibration is the truth; stripe and robot have errors. The sigmas follow the scatter of the columns."""
    small = {"width": 160, "height": 120, "focal_px": 353.0, "texel_mm": 0.8, "laser_sigma_mm": 2.6, "seed": 2}
    cell = SimulatedCell(CellConfig.model_validate({**small, "motion": "scan"}))
    dataset = cell.record(tmp_path / "set", poses=cell.plan()[8:40:8])
    calibration = true_calibration(cell.truth, image_width=160, image_height=120, covariance=np.zeros((20, 20)))
    cloud = scan(dataset, calibration)
    ratios = np.concatenate([true_distances(cell, cloud, i) / cloud.sigmas[cloud.views == i] for i in range(4)])
    assert len(ratios) > 300
    assert 0.2 < np.median(ratios) < 1.0
    assert np.mean(ratios < 2.5) > 0.9


def true_distances(cell: SimulatedCell, cloud: Scan, view: int) -> FloatArray:
    """How far each point of a view is from the nearest true point of its stripe, m."""
    true, camera = np.eye(4), cell.truth
    true[:3, :3], true[:3, 3] = camera.views[view].R_gripper2base, camera.views[view].t_gripper2base
    stripe = cell.stripe(SimulatedView(true, np.zeros((1, 1), np.uint8), None, true, view)).points_3d
    stripe = (stripe @ camera.R_cam2gripper.T + camera.t_cam2gripper) @ true[:3, :3].T + true[:3, 3]
    apart = cloud.points[cloud.views == view][:, None] - stripe
    return np.asarray(np.linalg.norm(apart, axis=2).min(axis=1))


def test_points_beyond_the_limit_are_left_out_and_counted(recording: Dataset) -> None:
    whole = scan(recording, calibration_of_truth())
    limit = float(np.median(whole.sigmas))
    part = scan(recording, calibration_of_truth(), max_sigma=limit)
    keep = whole.sigmas <= limit
    np.testing.assert_array_equal(part.points, whole.points[keep])
    np.testing.assert_array_equal(part.views, whole.views[keep])
    assert part.beyond_limit == (~keep).sum() > 0
    assert part.sigmas.max() <= limit
    with pytest.raises(InsufficientDataError, match=r"no point has a sigma of 0.0001 mm or less; the best of \d+ has"):
        scan(recording, calibration_of_truth(), max_sigma=1e-7)


def test_views_without_a_stripe_are_told_and_skipped(tmp_path: Path) -> None:
    reporter = Notes()
    cloud = scan(laser_dataset(tmp_path / "set", (0, None, 1, None)), calibration_of_truth(), reporter=reporter)
    assert sorted(set(cloud.views.tolist())) == [0, 2]
    assert cloud.empty_views == (1, 3)
    assert reporter.notes == [f"view {view}: skipped, no stripe was found" for view in (1, 3)]
    assert reporter.steps == ["finding the stripe in 4 images", "placing the points in the base frame"]


def test_poses_that_never_change_are_told(tmp_path: Path) -> None:
    truth = exact_recording()
    stops = [Stop(truth.R_gripper2base[0], truth.t_gripper2base[0], truth.stripePoints[k]) for k in range(3)]
    notes = Notes()
    scan(record(tmp_path / "still", stops), calibration_of_truth(), reporter=notes)
    assert [note for note in notes.notes if "same robot pose" in note] != []
    notes = Notes()
    scan(record(tmp_path / "two", stops[:2]), calibration_of_truth(), reporter=notes)
    assert [note for note in notes.notes if "same robot pose" in note] == []


def test_vertical_stripes_are_found_like_horizontal_ones(tmp_path: Path) -> None:
    calibration = calibration_of_truth()
    K, D, mirror = calibration.camera_matrix, calibration.distortion_coefficients, np.eye(3)[[1, 0, 2]]
    assert calibration.light_plane is not None
    changes = {
        "image_width": 480,
        "image_height": 640,
        "camera_matrix": mirror @ K @ mirror,
        "distortion_coefficients": D[[0, 1, 3, 2, 4]],
        "light_plane": np.append(mirror @ calibration.light_plane[:3], calibration.light_plane[3]),
    }
    mirrored = calibration.model_copy(update=changes)
    turned = profiler(laser_dataset(tmp_path / "a", (0,), turned=True), mirrored, Silent())
    straight = profiler(laser_dataset(tmp_path / "b", (0,)), calibration, Silent())
    a, b = find_profiles(turned, [0], Silent()), find_profiles(straight, [0], Silent())
    assert (turned.along, straight.along) == (1, 0)
    np.testing.assert_array_equal(a[0].pixels[:, ::-1], b[0].pixels)
    np.testing.assert_array_equal(a[0].intensity, b[0].intensity)
    np.testing.assert_allclose(a[0].sigmas, b[0].sigmas, rtol=1e-12)


def test_no_stripe_at_all_cannot_answer(tmp_path: Path) -> None:
    with pytest.raises(InsufficientDataError, match="needs a stripe in a laser image, found none in 2; is the"):
        scan(laser_dataset(tmp_path / "set", (None, None)), calibration_of_truth())


def test_data_set_without_laser_images_cannot_answer(tmp_path: Path) -> None:
    with pytest.raises(InsufficientDataError, match="needs views with an image taken with the laser on, has 0"):
        scan(exact_dataset(tmp_path / "set"), calibration_of_truth())


def test_calibration_without_light_plane_is_refused(recording: Dataset) -> None:
    with pytest.raises(FileFormatError, match="needs a light plane, has none; record laser images"):
        scan(recording, calibration_of_truth(light_plane=None))


def test_calibration_of_version_1_is_refused(recording: Dataset) -> None:
    with pytest.raises(FileFormatError, match=r"\(schema_version 2\), given version 1"):
        scan(recording, closed_form())


def test_images_of_another_size_are_refused(recording: Dataset) -> None:
    with pytest.raises(FileFormatError, match="needs images of 1280 x 480 as calibrated, has 640 x 480"):
        scan(recording, calibration_of_truth(image_width=1280))


def test_stripe_points_that_miss_the_light_plane_are_told_and_left_out(recording: Dataset) -> None:
    """A light plane beside the camera, from which the left of the image looks away."""
    reporter = Notes()
    whole = scan(recording, calibration_of_truth())
    cloud = scan(recording, calibration_of_truth(light_plane=[1.0, 0.0, 0.0, 0.1]), reporter=reporter)
    assert 0 < len(cloud.points) < len(whole.points)
    assert np.isfinite(cloud.points).all()
    seen = {view: int((whole.views == view).sum()) for view in range(6)}
    missed = {view: count - int((cloud.views == view).sum()) for view, count in seen.items()}
    expected = [f"view {view}: {missed[view]} of {seen[view]} stripe points" for view in range(6) if missed[view]]
    assert [note.split(" do not see the light plane")[0] for note in reporter.notes] == expected
    with pytest.raises(InsufficientDataError, match="needs a stripe in a laser image"):
        scan(recording, calibration_of_truth(light_plane=[0.0, 0.0, -1.0, 0.5]))  # behind the camera


def test_parameter_that_was_not_observed_makes_sigmas_infinite(recording: Dataset) -> None:
    covariance = calibration_of_truth().covariance.copy()
    covariance[13, 13] = np.inf
    cloud = scan(recording, calibration_of_truth(covariance=covariance))
    assert np.isinf(cloud.sigmas).all()
    assert np.isfinite(cloud.points).all()


def test_worst_sigma_is_that_of_the_longest_axis() -> None:
    Q = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    C = np.array([Q @ np.diag([1.0, 9.0, 4.0]) @ Q.T, np.diag([np.inf, 1.0, 1.0])])
    np.testing.assert_allclose(worst_sigma(C), [3.0, np.inf])
