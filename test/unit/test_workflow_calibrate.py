# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The workflow carries data to the C++ functions and back without losing or inventing anything."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray
from support.exact_recording import Recording, exact_recording
from support.recordings import NOISE_PX, ROBOT_DEG, ROBOT_MM, Notes, exact_dataset, known_distortion, noisy_dataset

import cv_active_handeye as cah
from cv_active_handeye.calibration import PARAMETERS
from cv_active_handeye.config import CalibrationOptions
from cv_active_handeye.dataset import CameraInfo, Dataset
from cv_active_handeye.report import inside_intervals
from cv_active_handeye.workflow import ImagePoints, InsufficientDataError, calibrate, calibrate_with_evidence


class TrueValuesOf(NamedTuple):
    """The truth of a recording as `inside_intervals` takes it."""

    recording: Recording

    @property
    def camera_matrix(self) -> NDArray[np.float64]:
        return self.recording.cameraMatrix

    @property
    def distortion_coefficients(self) -> NDArray[np.float64]:
        return self.recording.distCoeffs

    @property
    def R_cam2gripper(self) -> NDArray[np.float64]:
        return self.recording.R_cam2gripper

    @property
    def t_cam2gripper(self) -> NDArray[np.float64]:
        return self.recording.t_cam2gripper

    @property
    def light_plane(self) -> None:
        return None


def test_exact_points_give_the_exact_calibration(tmp_path: Path) -> None:
    truth = exact_recording()
    result = calibrate(exact_dataset(tmp_path / "set"), known_distortion())
    assert result.camera_matrix == pytest.approx(truth.cameraMatrix, rel=1e-6)
    assert result.R_cam2gripper == pytest.approx(truth.R_cam2gripper, abs=1e-8)
    assert result.t_cam2gripper == pytest.approx(truth.t_cam2gripper, abs=1e-8)
    assert result.light_plane is None
    assert (result.views, result.points, result.observations) == (14, 60, 14 * 60)
    assert result.parameter_names == PARAMETERS
    assert result.verdict is not None
    assert result.verdict.usable
    assert result.rms.points_px is not None
    assert result.rms.points_px < 1e-4


def test_known_camera_is_returned_unchanged_without_variance(tmp_path: Path) -> None:
    truth = exact_recording()
    result = calibrate(exact_dataset(tmp_path / "set"), known_distortion(camera_matrix=truth.cameraMatrix))
    assert np.array_equal(result.camera_matrix, truth.cameraMatrix)
    assert [result.standard_deviation(name) for name in ("fx", "fy", "cx", "cy", "skew")] == [0] * 5
    assert result.constraints == ("known_camera_matrix", "known_distortion")
    assert result.t_cam2gripper == pytest.approx(truth.t_cam2gripper, abs=1e-8)


def test_square_pixels_are_kept_square(tmp_path: Path) -> None:
    result = calibrate(noisy_dataset(tmp_path / "set"), known_distortion(square_pixels=True))
    assert result.camera_matrix[0, 0] == pytest.approx(result.camera_matrix[1, 1], rel=1e-12)
    assert result.constraints == ("zero_skew", "square_pixels", "known_distortion")


def test_intervals_hold_the_truth_and_noise_levels_come_out_in_their_units(tmp_path: Path) -> None:
    """Six recordings: 90 intervals of parameters, 18 of noise levels; 95 % of them are meant to hold the truth."""
    parameters: list[bool] = []
    levels: list[bool] = []
    ratios = []
    for seed in range(6):
        result = calibrate(noisy_dataset(tmp_path / f"set{seed}", seed=seed))
        assert result.lens is not None
        assert result.lens.chosen
        assert result.lens.model in ("tangential", "k3")
        inside = inside_intervals(result, TrueValuesOf(exact_recording()))
        assert len(inside) >= 14
        parameters += inside.values()
        assert result.noise_levels is not None
        n, radians = result.noise_levels, np.radians(ROBOT_DEG)
        pairs = ((n.image_points, NOISE_PX), (n.robot_translation, ROBOT_MM / 1000), (n.robot_rotation, radians))
        levels += [level.lower <= true <= level.upper for level, true in pairs]
        ratios.append([level.level / true for level, true in pairs])
        assert (n.stripes, n.stated_points_px) == (None, None)
    assert sum(parameters) >= 0.85 * len(parameters)
    assert sum(levels) >= 14
    assert np.mean(ratios, axis=0) == pytest.approx([1, 1, 1], abs=0.25)


def test_given_robot_noise_is_kept_and_tested(tmp_path: Path) -> None:
    options = known_distortion(robot_translation_mm=ROBOT_MM, robot_rotation_deg=ROBOT_DEG)
    result = calibrate(noisy_dataset(tmp_path / "set"), options)
    assert result.noise_levels is not None
    assert result.noise_levels.robot_translation.level == pytest.approx(ROBOT_MM / 1000)
    assert not result.noise_levels.robot_translation.estimated
    assert result.noise_levels.image_points.estimated
    assert result.chi_square is not None
    assert result.chi_square.p_value > 0.001
    assert result.constraints[-2:] == ("known_robot_translation_noise", "known_robot_rotation_noise")


def test_robot_noise_far_too_small_makes_the_result_not_usable_and_is_told(tmp_path: Path) -> None:
    reporter = Notes()
    options = known_distortion(robot_translation_mm=ROBOT_MM / 20, robot_rotation_deg=ROBOT_DEG / 20)
    result = calibrate(noisy_dataset(tmp_path / "set"), options, reporter)
    assert result.verdict is not None
    assert not result.verdict.usable
    assert "not usable" in reporter.notes[-1]


def test_exact_robot_has_no_noise_of_its_own(tmp_path: Path) -> None:
    options = known_distortion(robot_translation_mm=0, robot_rotation_deg=0)
    result = calibrate(noisy_dataset(tmp_path / "set", robot=False), options)
    assert result.noise_levels is not None
    assert result.noise_levels.robot_translation.level == 0
    assert "exact_robot" in result.constraints
    assert result.t_cam2gripper == pytest.approx(exact_recording().t_cam2gripper, abs=3e-4)


@pytest.mark.parametrize("model", ["none", "k1", "k1-k2", "tangential", "k3"])
def test_lens_model_that_is_asked_for_is_used(tmp_path: Path, model: str) -> None:
    result = calibrate(noisy_dataset(tmp_path / "set"), CalibrationOptions.model_validate({"lens_model": model}))
    assert result.lens is not None
    assert (result.lens.model, result.lens.chosen) == (model, False)
    count = {"none": 0, "k1": 1, "k1-k2": 2, "tangential": 4, "k3": 5}[model]
    estimated = [result.standard_deviation(name) > 0 for name in ("k1", "k2", "p1", "p2", "k3")]
    assert estimated == [True] * count + [False] * (5 - count)
    assert result.verdict is not None
    assert result.verdict.usable == (count >= 4)


def test_one_axis_of_turns_is_refused_unless_a_part_is_asked_for(tmp_path: Path) -> None:
    dataset = noisy_dataset(tmp_path / "set", views=[0, 1, 2, 3, 4, 10, 11])
    with pytest.raises(cah.error, match="axis"):
        calibrate(dataset, known_distortion())
    result = calibrate(dataset, known_distortion(allow_partial=True))
    assert max(result.standard_deviation(name) for name in ("tx", "ty", "tz")) == np.inf
    assert result.tool is not None
    assert result.tool.accuracy == np.inf


def test_two_calls_give_the_same_file(tmp_path: Path) -> None:
    dataset = exact_dataset(tmp_path / "set")
    assert calibrate(dataset).to_yaml() == calibrate(tmp_path / "set").to_yaml()


def test_steps_are_told_in_the_order_they_run(tmp_path: Path) -> None:
    reporter = Notes()
    calibrate(exact_dataset(tmp_path / "set"), known_distortion(), reporter)
    assert [step.split(",")[0] for step in reporter.steps] == [
        "reading 60 image points",
        "refining camera and hand-eye transform",
    ]
    assert reporter.notes == ["no light plane: the data set has no laser image that shows a stripe"]


def test_recording_without_translations_is_refused_with_the_nearest_views(tmp_path: Path) -> None:
    dataset = exact_dataset(tmp_path / "set", [0, 5, 10, 12])
    with pytest.raises(cah.error, match=r"views .* come nearest"):
        calibrate(dataset, known_distortion())


def test_recording_without_turns_is_refused(tmp_path: Path) -> None:
    dataset = exact_dataset(tmp_path / "set", [0, 1, 2, 3, 4])
    with pytest.raises(cah.error, match=r"turns do not determine t_cam2gripper.* add rotations about two axes"):
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
    assert evidence.point_sigmas is None
    assert evidence.summary is not None
    assert evidence.summary.residuals.shape == (14, 120)


def test_a_slipped_view_is_named(tmp_path: Path) -> None:
    """The robot stands 2 mm beside where it says, in one stop of the first group."""
    truth = exact_recording()
    t = truth.t_gripper2base.copy()
    t[3] += [0.002, 0, 0]
    dataset = noisy_dataset(tmp_path / "set", t_gripper2base=t)
    result = calibrate(dataset, known_distortion())
    assert result.verdict is not None
    assert result.verdict.rejected_views == (3,)
    assert "view 3" in " ".join(result.verdict.culprits)
    assert result.t_cam2gripper == pytest.approx(truth.t_cam2gripper, abs=1e-3)


def test_stated_sigmas_weigh_the_points_and_the_level_stays_in_pixels(tmp_path: Path) -> None:
    truth, rng = exact_recording(), np.random.default_rng(5)
    sigmas = 0.02 * np.exp(rng.uniform(-1.5, 1.5, truth.imagePoints.shape[:2]))
    points = ImagePoints(truth.imagePoints + 2 * sigmas[:, :, None] * rng.normal(size=truth.imagePoints.shape), sigmas)
    dataset = exact_dataset(tmp_path / "set")
    result, evidence = calibrate_with_evidence(dataset, known_distortion(), points=points)
    assert result.noise_levels is not None
    assert result.noise_levels.stated_points_px == pytest.approx(np.median(sigmas))
    assert result.noise_levels.image_points.level == pytest.approx(2 * np.median(sigmas), rel=0.1)
    assert evidence.point_sigmas is sigmas
    plain, _ = calibrate_with_evidence(dataset, known_distortion(), points=ImagePoints(points.points))
    assert result.standard_deviation("fx") < 0.8 * plain.standard_deviation("fx")
