# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The workflow carries data to the C++ functions and back without losing or inventing anything."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.exact_recording import exact_recording
from support.recordings import exact_dataset

import cv_active_handeye as cah
from cv_active_handeye.config import CalibrationOptions
from cv_active_handeye.dataset import CameraInfo, Dataset
from cv_active_handeye.workflow import InsufficientDataError, calibrate, calibrate_with_evidence


class Notes:
    """A reporter that remembers."""

    def __init__(self) -> None:
        self.steps: list[str] = []
        self.notes: list[str] = []

    def step(self, name: str):  # type: ignore[no-untyped-def]
        self.steps.append(name)
        return lambda done, total: None

    def note(self, text: str) -> None:
        self.notes.append(text)


def known_distortion(**changes: object) -> CalibrationOptions:
    return CalibrationOptions.model_validate({"distortion_coefficients": exact_recording().distCoeffs, **changes})


def test_exact_points_give_the_exact_calibration(tmp_path: Path) -> None:
    truth = exact_recording()
    result = calibrate(exact_dataset(tmp_path / "set"), known_distortion())
    assert result.camera_matrix == pytest.approx(truth.cameraMatrix, rel=1e-6)
    assert result.R_cam2gripper == pytest.approx(truth.R_cam2gripper, abs=1e-8)
    assert result.t_cam2gripper == pytest.approx(truth.t_cam2gripper, abs=1e-8)
    assert result.light_plane is None
    assert (result.views, result.points, result.observations) == (14, 60, 14 * 60)
    assert result.parameter_names == ("fx", "fy", "cx", "cy", "skew", "rx", "ry", "rz", "tx", "ty", "tz")
    assert result.rms.translations_px < 1e-4


def test_known_camera_is_returned_unchanged_without_variance(tmp_path: Path) -> None:
    truth = exact_recording()
    result = calibrate(exact_dataset(tmp_path / "set"), known_distortion(camera_matrix=truth.cameraMatrix))
    assert np.array_equal(result.camera_matrix, truth.cameraMatrix)
    assert [result.standard_deviation(name) for name in ("fx", "fy", "cx", "cy", "skew")] == [0] * 5
    assert result.constraints == ("known_camera_matrix", "known_distortion")
    assert result.t_cam2gripper == pytest.approx(truth.t_cam2gripper, abs=1e-8)


def test_square_pixels_are_kept_square(tmp_path: Path) -> None:
    result = calibrate(exact_dataset(tmp_path / "set"), known_distortion(square_pixels=True))
    assert result.camera_matrix[0, 0] == result.camera_matrix[1, 1]
    assert result.constraints == ("zero_skew", "square_pixels", "known_distortion")


def test_two_calls_give_the_same_file(tmp_path: Path) -> None:
    dataset = exact_dataset(tmp_path / "set")
    assert calibrate(dataset).to_yaml() == calibrate(tmp_path / "set").to_yaml()


def test_steps_are_told_in_the_order_they_run(tmp_path: Path) -> None:
    reporter = Notes()
    calibrate(exact_dataset(tmp_path / "set"), known_distortion(), reporter)
    assert [step.split(",")[0] for step in reporter.steps] == [
        "reading 60 image points",
        "camera matrix and rotation",
        "camera position",
    ]
    assert reporter.notes == ["no light plane: the data set has no laser image that shows a stripe"]


def test_recording_without_translations_is_refused_with_the_nearest_views(tmp_path: Path) -> None:
    dataset = exact_dataset(tmp_path / "set", [0, 5, 10, 12])
    with pytest.raises(cah.error, match=r"views .* come nearest"):
        calibrate(dataset, known_distortion())


def test_recording_without_turns_is_refused(tmp_path: Path) -> None:
    dataset = exact_dataset(tmp_path / "set", [0, 1, 2, 3, 4])
    with pytest.raises(cah.error, match="orientation"):
        calibrate(dataset, known_distortion())


def test_data_set_without_images_and_points_is_refused(tmp_path: Path) -> None:
    dataset = Dataset.create(tmp_path / "set", camera=CameraInfo(width=640, height=480))
    dataset.add_view(np.eye(3), [0, 0, 0])
    with pytest.raises(InsufficientDataError, match="needs two views with an image taken with the laser off, has 0"):
        calibrate(dataset)


def test_images_without_texture_are_refused(tmp_path: Path) -> None:
    dataset = Dataset.create(tmp_path / "set", camera=CameraInfo(width=64, height=48))
    for i in range(4):
        dataset.add_view(np.eye(3), [0.01 * i, 0, 0], image=np.full((48, 64), 100, np.uint8))
    with pytest.raises(InsufficientDataError, match="no point was found"):
        calibrate(dataset)


def test_missing_views_are_noted_and_the_rest_is_used(tmp_path: Path) -> None:
    truth = exact_recording()
    dataset = Dataset.create(tmp_path / "set", camera=CameraInfo(width=640, height=480), planned_views=16)
    for R, t in zip(truth.R_gripper2base, truth.t_gripper2base, strict=True):
        dataset.add_view(R, t)
    dataset.set_image_points(truth.imagePoints)
    reporter = Notes()
    result, evidence = calibrate_with_evidence(dataset, known_distortion(), reporter)
    assert reporter.notes[0] == "data set: 2 of 16 planned views are missing (views 14 to 15)"
    assert result.views == 14
    assert np.array_equal(evidence.image_points, truth.imagePoints)


def test_poses_that_do_not_fit_the_images_are_noted(tmp_path: Path) -> None:
    truth = exact_recording()
    reporter = Notes()
    dataset = Dataset.create(tmp_path / "set", camera=CameraInfo(width=640, height=480))
    shift = np.random.default_rng(2).normal(0, 0.002, (14, 3))
    for R, t in zip(truth.R_gripper2base, truth.t_gripper2base + shift, strict=True):
        dataset.add_view(R, t)
    dataset.set_image_points(truth.imagePoints)
    calibrate(dataset, known_distortion(camera_matrix=truth.cameraMatrix), reporter)
    assert any("are more than image noise" in note for note in reporter.notes)
    exact = Notes()
    calibrate(exact_dataset(tmp_path / "exact"), known_distortion(), exact)
    assert not any("image noise" in note for note in exact.notes)


def test_options_refuse_a_known_camera_with_square_pixels() -> None:
    with pytest.raises(ValueError, match="square_pixels: needs an unknown camera matrix"):
        known_distortion(square_pixels=True, camera_matrix=np.eye(3))
