# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What the refinement is asked (options become flags and sigmas), and how its answer becomes the result file."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from support.exact_recording import exact_recording
from support.recordings import known_distortion, noisy_dataset

import cv_active_handeye as cah
from cv_active_handeye.calibration import Calibration
from cv_active_handeye.config import CalibrationOptions
from cv_active_handeye.dataset import Dataset
from cv_active_handeye.workflow import ImagePoints, StripeSegment
from cv_active_handeye.workflow.refinement import Refined, Start, refine
from cv_active_handeye.workflow.result import calibration_of

K = exact_recording().cameraMatrix


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return noisy_dataset(tmp_path_factory.mktemp("recorded") / "set")


def points_of(dataset: Dataset) -> ImagePoints:
    points = dataset.image_points()
    assert points is not None
    return ImagePoints(points)


class Asked(Exception):  # noqa: N818 - it carries what was asked, nothing is wrong
    """Raised instead of refining."""

    def __init__(self, arguments: tuple[Any, ...], keywords: dict[str, Any]) -> None:
        self.arguments, self.keywords = arguments, keywords


def asked(
    monkeypatch: pytest.MonkeyPatch, dataset: Dataset, options: CalibrationOptions, *more: Any, points: Any = None
) -> Asked:
    """What `refine` passes on."""

    def instead(*arguments: Any, **keywords: Any) -> None:
        raise Asked(arguments, keywords)

    monkeypatch.setattr(cah, "refineHandEye", instead)
    with pytest.raises(Asked) as caught:
        refine(dataset, points or points_of(dataset), options, *(more or (Start(),)))
    return caught.value


@pytest.mark.parametrize(
    ("changes", "flags", "lens"),
    [
        ({}, 0, "LENS_AUTO"),
        ({"lens_model": "none"}, 0, "LENS_FIXED"),
        ({"lens_model": "tangential"}, 0, "LENS_TANGENTIAL"),
        ({"zero_skew": False}, cah.REFINE_SKEW, "LENS_AUTO"),
        ({"square_pixels": True}, cah.REFINE_FIX_ASPECT, "LENS_AUTO"),
        ({"camera_matrix": K}, cah.REFINE_FIX_K, "LENS_AUTO"),
        ({"camera_matrix": K, "zero_skew": False, "lens_model": "k1"}, cah.REFINE_FIX_K, "LENS_K1"),
        ({"allow_partial": True}, cah.REFINE_ALLOW_PARTIAL, "LENS_AUTO"),
        ({"distortion_coefficients": np.zeros(5)}, 0, "LENS_FIXED"),
    ],
)
def test_options_become_flags_and_lens_model(
    monkeypatch: pytest.MonkeyPatch, dataset: Dataset, changes: dict[str, Any], flags: int, lens: str
) -> None:
    params = asked(monkeypatch, dataset, CalibrationOptions.model_validate(changes)).keywords["params"]
    assert (params.flags, params.lensModel) == (int(flags), int(getattr(cah, lens)))


def test_noise_of_the_robot_is_passed_in_metres_and_radians(monkeypatch: pytest.MonkeyPatch, dataset: Dataset) -> None:
    options = CalibrationOptions(robot_translation_mm=0.02, robot_rotation_deg=0.005, orientation_tolerance_deg=0.3)
    params = asked(monkeypatch, dataset, options).keywords["params"]
    assert params.robotTranslationSigma == pytest.approx(2e-5)
    assert params.robotRotationSigma == pytest.approx(np.radians(0.005))
    assert params.orientationTolerance == 0.3
    params = asked(monkeypatch, dataset, CalibrationOptions()).keywords["params"]
    assert params.robotTranslationSigma < 0
    assert params.robotRotationSigma < 0


def test_start_segments_and_relative_sigmas_are_passed_on(monkeypatch: pytest.MonkeyPatch, dataset: Dataset) -> None:
    sigmas = np.array([[0.02, 0.04, np.nan], [0.08, 0.04, 0.04]])
    found = ImagePoints(np.zeros((2, 3, 2)), sigmas)
    segments = [StripeSegment(1, np.ones((3, 2)), 4), StripeSegment(0, np.zeros((2, 2)))]
    start = Start(K, np.eye(3), np.ones(3))
    call = asked(monkeypatch, dataset, CalibrationOptions(), start, segments, points=found)
    assert np.array_equal(call.keywords["pointSigmas"], sigmas / 0.04, equal_nan=True)
    assert (call.keywords["stripeViews"], call.keywords["surfaceIds"]) == ([1, 0], [4, -1])
    assert call.arguments[3] is K
    assert call.arguments[4] is None
    assert call.arguments[5].tolist() == np.eye(3).tolist()


def test_known_camera_comes_before_the_start(monkeypatch: pytest.MonkeyPatch, dataset: Dataset) -> None:
    other = K + np.diag([1, 1, 0])
    call = asked(monkeypatch, dataset, CalibrationOptions(camera_matrix=K), Start(other))
    assert np.array_equal(call.arguments[3], K)
    assert call.keywords["stripePoints"] is None


@pytest.fixture(scope="module")
def refined(dataset: Dataset) -> Refined:
    return refine(dataset, points_of(dataset), known_distortion(), Start())


class Changed:
    """A summary of which some values are others."""

    def __init__(self, summary: cah.RefineSummary, values: dict[str, Any]) -> None:
        self._summary, self._values = summary, values

    def __getattr__(self, name: str) -> Any:
        return self._values[name] if name in self._values else getattr(self._summary, name)


def changed(refined: Refined, **values: Any) -> Refined:
    summary: Any = Changed(refined.summary, values)
    return refined._replace(summary=summary)


def result(refined: Refined, dataset: Dataset, **options: Any) -> Calibration:
    return calibration_of(refined, dataset, points_of(dataset), [], known_distortion(**options))


def test_result_holds_what_the_summary_says(refined: Refined, dataset: Dataset) -> None:
    found, summary = result(refined, dataset), refined.summary
    assert np.array_equal(found.camera_matrix, refined.camera_matrix)
    assert np.array_equal(found.t_cam2gripper, refined.t_cam2gripper.reshape(-1))
    assert np.array_equal(found.covariance, summary.covariance)
    assert np.array_equal(found.intervals_95, summary.intervals95)  # type: ignore[arg-type]
    assert found.parameter_names == tuple(summary.parameterNames)
    assert found.rms.points_px == summary.rms
    assert found.dataset_sha256 == dataset.sha256()
    assert found.verdict is not None
    assert (found.verdict.usable, found.verdict.message) == (True, summary.message)
    assert found.tool is not None
    assert found.tool.working_distance == summary.workingDistance
    assert Calibration.model_validate(found.model_dump()).to_yaml() == found.to_yaml()


def test_accuracy_at_the_tool_is_the_worst_direction_widened_as_the_intervals(
    refined: Refined, dataset: Dataset
) -> None:
    tool = result(refined, dataset).tool
    assert tool is not None
    normal = 1.959963984540054 * np.sqrt(np.linalg.eigvalsh(tool.covariance)[-1])
    assert normal <= tool.accuracy < 2 * normal
    told = re.search(r"known to (\S+) ", refined.summary.message)
    assert told is not None
    assert float(told[1]) == pytest.approx(tool.accuracy, rel=0.06)


def test_points_that_were_left_out_are_counted(refined: Refined, dataset: Dataset) -> None:
    rejected = np.zeros((14, 60), np.uint8)
    rejected[3, :7] = 1
    values = {"rejectedObservations": rejected, "rejectedViews": [3], "culprits": ["view 3: moved"]}
    found = result(changed(refined, **values), dataset)
    assert found.verdict is not None
    assert (found.observations, found.verdict.rejected_observations) == (14 * 60 - 7, 7)
    assert (found.verdict.rejected_views, found.verdict.culprits) == ((3,), ("view 3: moved",))


def test_points_that_no_view_shows_do_not_count(refined: Refined, dataset: Dataset) -> None:
    points = points_of(dataset).points.copy()
    points[:, 5], points[2, 6] = np.nan, np.nan
    found = calibration_of(refined, dataset, ImagePoints(points), [], known_distortion())
    assert (found.points, found.observations) == (59, 59 * 14 - 1)


def test_noise_levels_tell_given_from_estimated_and_leave_out_what_was_not_there(
    refined: Refined, dataset: Dataset
) -> None:
    nan = np.nan
    rows = [[0.1, 0.09, 0.11, 1], [0.05, 0.04, 0.06, 1], [2e-5, nan, nan, 0], [nan, nan, nan, 0]]
    levels = result(changed(refined, noiseLevels=np.array(rows)), dataset).noise_levels
    assert levels is not None
    assert levels.image_points.model_dump() == {"level": 0.1, "lower": 0.09, "upper": 0.11, "estimated": True}
    assert levels.stripes is not None
    assert levels.stripes.upper == 0.06
    assert levels.robot_translation.model_dump() == {"level": 2e-5, "lower": 2e-5, "upper": 2e-5, "estimated": False}
    assert levels.robot_rotation.level == 0


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({}, False),
        ({"robot_translation_mm": 0.02}, True),
        ({"robot_rotation_deg": 0.005}, True),
        ({"robot_translation_mm": 0, "robot_rotation_deg": 0}, False),
    ],
)
def test_chi_square_is_told_where_noise_levels_were_given(
    refined: Refined, dataset: Dataset, changes: dict[str, Any], told: bool
) -> None:
    assert (result(refined, dataset, **changes).chi_square is not None) == told


def test_stripe_residuals_are_summed_without_those_not_used(refined: Refined, dataset: Dataset) -> None:
    ends = np.array([[0.3, -0.4], [np.nan, np.nan]])
    assert result(changed(refined, stripeResiduals=ends), dataset).rms.stripes_px == pytest.approx(np.sqrt(0.125))


def test_accuracy_is_infinite_where_the_covariance_is(refined: Refined, dataset: Dataset) -> None:
    found = result(changed(refined, toolCovariance=np.diag([1e-10, np.inf, 1e-10])), dataset)
    assert found.tool is not None
    assert found.tool.accuracy == np.inf
