# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""New views confirm a calibration that holds, and find a camera that was pushed, a slipped view, and files that do not
belong together."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from support.calibrations import closed_form
from support.exact_recording import exact_recording
from support.recordings import NOISE_PX, Notes, known_distortion, noisy_dataset

import cv_active_handeye as cah
from cv_active_handeye.calibration import Calibration
from cv_active_handeye.dataset import CameraInfo, Dataset
from cv_active_handeye.files import FileFormatError
from cv_active_handeye.workflow import ImagePoints, InsufficientDataError, calibrate
from cv_active_handeye.workflow.verify import verify

VIEWS = (0, 2, 6, 10, 13)
"""Stops of four orientations."""


@pytest.fixture(scope="module")
def calibration(tmp_path_factory: pytest.TempPathFactory) -> Calibration:
    return calibrate(noisy_dataset(tmp_path_factory.mktemp("first") / "set", seed=100), known_distortion())


def test_valid_calibration_is_confirmed_with_p_values_of_all_sizes(tmp_path: Path) -> None:
    """Twelve pairs of a calibration and a check: under the hypothesis, p-values are uniform between 0 and 1."""
    drift, fit = [], []
    for seed in range(12):
        found = calibrate(noisy_dataset(tmp_path / f"a{seed}", seed=seed), known_distortion())
        result = verify(noisy_dataset(tmp_path / f"b{seed}", seed=50 + seed, views=VIEWS), found)
        drift.append(result.summary.driftPValue)
        fit.append(result.summary.fitPValue)
        assert result.valid == result.summary.valid
    for p in (drift, fit):
        assert min(p) > 1e-3
        assert 0.25 < np.mean(p) < 0.75
        assert max(p) > 0.6


def test_expected_errors_of_the_views_are_of_the_size_of_the_errors(tmp_path: Path, calibration: Calibration) -> None:
    result = verify(noisy_dataset(tmp_path / "set", seed=7, views=VIEWS), calibration)
    assert [view.view for view in result.views] == list(range(len(VIEWS)))
    for view in result.views:
        assert not view.contradicts
        assert NOISE_PX < view.expected_px < 10 * NOISE_PX
        assert 0.3 * view.expected_px < view.error_px < 2 * view.expected_px
        assert 0.3 * view.expected_mm < view.error_mm < 2 * view.expected_mm
        # a pixel is 0.5 m / 1411 px wide
        assert view.error_mm == pytest.approx(view.error_px * 500 / 1411, rel=0.5)
    assert result.rms_px == pytest.approx(np.sqrt(np.mean([view.error_px**2 for view in result.views])), rel=0.05)


@pytest.mark.parametrize("bump_mm", [(0.5, 0, 0), (0, 0.5, 0), (0, 0, 0.5), (-0.3, 0.3, -0.27)])
def test_push_of_half_a_millimetre_is_found(
    tmp_path: Path, calibration: Calibration, bump_mm: tuple[float, float, float]
) -> None:
    result = verify(noisy_dataset(tmp_path / "set", seed=8, views=VIEWS, bump_mm=bump_mm), calibration)
    assert not result.valid
    assert result.summary.driftPValue < 1e-3
    assert result.summary.fitPValue > 1e-3
    assert result.summary.message.startswith("not valid")


@pytest.mark.parametrize(("bump_mm", "name"), [((0.5, 0, 0), "tx"), ((0, 0.5, 0), "ty")])
def test_shift_says_where_the_camera_went(
    tmp_path: Path, calibration: Calibration, bump_mm: tuple[float, float, float], name: str
) -> None:
    summary = verify(noisy_dataset(tmp_path / "set", seed=8, views=VIEWS, bump_mm=bump_mm), calibration).summary
    deviations = np.where(summary.shiftDeviations > 0, summary.shiftDeviations, np.inf)
    ratio = np.asarray(summary.shift / deviations).reshape(-1)
    assert calibration.parameter_names[int(np.argmax(np.abs(ratio)))] == name
    assert ratio.max() > 4
    assert float(summary.shift.ravel()[calibration.parameter_names.index(name)]) == pytest.approx(0.5e-3, rel=0.3)


@pytest.mark.parametrize("views", [VIEWS, range(14)], ids=["5 views", "14 views"])
def test_view_whose_pose_is_wrong_is_named(tmp_path: Path, calibration: Calibration, views: Sequence[int]) -> None:
    reported = exact_recording().t_gripper2base.copy()
    reported[6, 0] += 0.004
    dataset = noisy_dataset(tmp_path / "set", seed=9, views=views, t_gripper2base=reported)
    result = verify(dataset, calibration)
    wrong = list(views).index(6)
    assert result.views[wrong].contradicts
    assert wrong in result.summary.contradictingViews
    assert max(result.views, key=lambda view: view.error_mm / view.expected_mm).view == wrong


@pytest.mark.parametrize(("stated", "fits"), [(2.0, True), (1.0, False)])
def test_darker_images_are_allowed_the_noise_that_the_tracker_states(
    tmp_path: Path, calibration: Calibration, monkeypatch: pytest.MonkeyPatch, stated: float, fits: bool
) -> None:
    """Twice the noise fits if the tracker says that it is twice the noise; else the test allows for it, and says so."""
    levels = calibration.noise_levels
    assert levels is not None
    first = calibration.model_copy(update={"noise_levels": levels.model_copy(update={"stated_points_px": 0.02})})
    dataset = noisy_dataset(tmp_path / "set", seed=11, views=VIEWS)
    exact = exact_recording().imagePoints[list(VIEWS)]
    points = exact + 2 * NOISE_PX * np.random.default_rng(12).normal(size=exact.shape)
    found = ImagePoints(points, np.full(points.shape[:2], 0.02 * stated))
    monkeypatch.setattr("cv_active_handeye.workflow.verify.find_points", lambda *_: found)
    result = verify(dataset, first)
    assert result.valid
    assert (result.summary.fitPValue > 1e-3) == fits
    assert ("times what the noise levels say" in result.summary.message) != fits


def test_same_question_has_the_same_answer_and_steps_are_told(tmp_path: Path, calibration: Calibration) -> None:
    noisy_dataset(tmp_path / "set", seed=7, views=VIEWS)
    reporter = Notes()
    first, again = verify(tmp_path / "set", calibration, reporter=reporter), verify(tmp_path / "set", calibration)
    assert reporter.steps == ["reading 60 image points", "predicting 5 views from each other"]
    assert first.summary.driftChiSquare == again.summary.driftChiSquare
    assert first.views == again.views


def test_calibration_that_was_not_usable_is_noted(tmp_path: Path, calibration: Calibration) -> None:
    assert calibration.verdict is not None
    verdict = calibration.verdict.model_copy(update={"usable": False, "message": "not usable: for a test"})
    reporter = Notes()
    marked = calibration.model_copy(update={"verdict": verdict})
    assert verify(noisy_dataset(tmp_path / "set", seed=7, views=VIEWS), marked, reporter=reporter).valid
    assert reporter.notes == ["the calibration itself was not usable: for a test"]


def test_calibration_of_version_1_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileFormatError, match=r"covariance and noise levels \(schema_version 2\), given version 1"):
        verify(noisy_dataset(tmp_path / "set", views=VIEWS), closed_form())


def test_images_of_another_size_are_refused(tmp_path: Path, calibration: Calibration) -> None:
    dataset = Dataset.create(tmp_path / "set", camera=CameraInfo(width=320, height=240))
    with pytest.raises(FileFormatError, match="needs images of 640 x 480 as calibrated, has 320 x 240"):
        verify(dataset, calibration)


def test_two_views_are_not_enough(tmp_path: Path, calibration: Calibration) -> None:
    with pytest.raises(InsufficientDataError, match="needs 3 views, has 2"):
        verify(noisy_dataset(tmp_path / "set", views=[0, 1]), calibration)


def test_views_that_share_no_points_cannot_answer(tmp_path: Path, calibration: Calibration) -> None:
    dataset = noisy_dataset(tmp_path / "set", views=VIEWS)
    points = dataset.image_points()
    assert points is not None
    alone = np.full_like(points, np.nan)
    for view in range(len(VIEWS)):
        alone[view, 12 * view : 12 * view + 12] = points[view, 12 * view : 12 * view + 12]
    dataset.set_image_points(alone)
    with pytest.raises(cah.error, match="two views"):
        verify(dataset, calibration)
