# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Laser images of a data set become a light plane: stripes are found, keep their surfaces, and give the true plane."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.exact_recording import exact_recording
from support.stripe_recording import stripe_image

import cv_active_handeye as cah
from cv_active_handeye.calibration import Calibration
from cv_active_handeye.config import CalibrationOptions
from cv_active_handeye.dataset import CameraInfo, Dataset, LaserInfo
from cv_active_handeye.report.errors import angle_between_deg
from cv_active_handeye.workflow import Silent, calibrate, calibrate_with_evidence
from cv_active_handeye.workflow.evidence import find_stripes

POINT_NOISE_PX = 0.02


def recording_with_stripes(folder: Path, surface: int, turned: bool = False) -> Dataset:
    """The recording with laser images that cross one surface; `turned` swaps the axes of image and laser."""
    truth, rng = exact_recording(), np.random.default_rng(4)
    laser = LaserInfo(stripe="vertical" if turned else "horizontal")
    camera = CameraInfo(width=480, height=640) if turned else CameraInfo(width=640, height=480)
    dataset = Dataset.create(folder, camera=camera, laser=laser)
    for view in range(len(truth.R_gripper2base)):
        points = truth.stripePoints[3 * view + surface]
        image = stripe_image(points)
        dataset.add_view(
            truth.R_gripper2base[view],
            truth.t_gripper2base[view],
            laser_image=np.ascontiguousarray(image.T) if turned else image,
            surface_id=surface,
        )
    points = truth.imagePoints + POINT_NOISE_PX * rng.normal(size=truth.imagePoints.shape)
    dataset.set_image_points(points[:, :, ::-1] if turned else points)
    return dataset


def known_camera() -> CalibrationOptions:
    truth = exact_recording()
    return CalibrationOptions(camera_matrix=truth.cameraMatrix, distortion_coefficients=truth.distCoeffs)


def check_light_plane(result: Calibration) -> None:
    truth = exact_recording().lightPlane
    assert result.light_plane is not None
    assert angle_between_deg(result.light_plane[:3], truth[:3]) < 0.05
    assert result.light_plane[3] == pytest.approx(truth[3], abs=3e-4)
    assert result.rms.stripes_px is not None
    assert result.rms.stripes_px < 0.1
    assert result.stripe_segments == 14
    for i, name in enumerate(("nx", "ny", "nz", "d")):
        sigma = result.standard_deviation(name)
        assert 0 < sigma < 1e-3, name
        assert abs(result.light_plane[i] - truth[i]) < 4 * sigma, name
    assert result.noise_levels is not None
    assert result.noise_levels.stripes is not None
    assert result.noise_levels.stripes.lower <= result.noise_levels.stripes.level <= result.noise_levels.stripes.upper


def test_stripes_on_a_named_surface_give_the_light_plane(tmp_path: Path) -> None:
    check_light_plane(calibrate(recording_with_stripes(tmp_path / "set", 0), known_camera()))


def test_stripes_are_left_out_when_asked(tmp_path: Path) -> None:
    options = known_camera().model_copy(update={"use_laser": False})
    result, evidence = calibrate_with_evidence(recording_with_stripes(tmp_path / "set", 0), options)
    assert result.light_plane is None
    assert evidence.segments == ()
    assert [result.standard_deviation(name) for name in ("nx", "ny", "nz", "d")] == [0, 0, 0, 0]
    assert result.noise_levels is not None
    assert result.noise_levels.stripes is None
    assert result.rms.stripes_px is None


def test_vertical_stripes_are_found_like_horizontal_ones(tmp_path: Path) -> None:
    truth = exact_recording()
    K, D = truth.cameraMatrix, truth.distCoeffs
    mirrored_K, mirrored_D = K[[1, 0, 2]][:, [1, 0, 2]], D[[0, 1, 3, 2, 4]]
    mirrored = find_stripes(recording_with_stripes(tmp_path / "a", 0, turned=True), mirrored_K, mirrored_D, Silent())
    straight = find_stripes(recording_with_stripes(tmp_path / "b", 0), K, D, Silent())
    assert len(mirrored) == len(straight) == 14
    for a, b in zip(mirrored, straight, strict=True):
        assert np.array_equal(a.points[:, ::-1], b.points)


def test_each_segment_keeps_the_surface_the_data_set_names(tmp_path: Path) -> None:
    evidence = calibrate_with_evidence(recording_with_stripes(tmp_path / "set", 1), known_camera())[1]
    assert {segment.surface for segment in evidence.segments} == {1}
    assert [segment.view for segment in evidence.segments] == list(range(14))


def test_one_view_with_a_stripe_is_refused_with_what_is_needed(tmp_path: Path) -> None:
    dataset = recording_with_stripes(tmp_path / "all", 0)
    alone = Dataset.create(tmp_path / "one", camera=dataset.camera, laser=dataset.laser)
    for view in dataset.views:
        image = dataset.laser_image(0) if view.index == 0 else None
        alone.add_view(
            view.R_gripper2base, view.t_gripper2base, laser_image=image, surface_id=0 if not view.index else None
        )
    points = dataset.image_points()
    assert points is not None
    alone.set_image_points(points)
    with pytest.raises(
        cah.error, match="surfaceIds: no surface has its stripe in enough views; needed at least 3 views"
    ):
        calibrate(alone, known_camera())
