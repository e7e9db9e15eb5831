# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The command `verify`: one exit status per kind of answer, and a table of all views."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from support.command_line import run
from support.exact_recording import exact_recording
from support.recordings import REPOSITORY, known_distortion, noisy_dataset

from cv_active_handeye.calibration import Calibration
from cv_active_handeye.cli.console import Exit
from cv_active_handeye.workflow import calibrate

NEW_VIEWS = [1, 6, 8, 10, 13]
BUMP = np.array([0.002, 0.0, 0.0])


@pytest.fixture(scope="module")
def calibrated(tmp_path_factory: pytest.TempPathFactory) -> Calibration:
    return calibrate(noisy_dataset(tmp_path_factory.mktemp("calibrated") / "set"), known_distortion())


@pytest.fixture(autouse=True)
def _own_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, calibrated: Calibration) -> None:
    monkeypatch.chdir(tmp_path)
    calibrated.save("calibration.yaml")


def rows_of(output: str) -> list[list[str]]:
    """The lines of the table, one a view."""
    return [line.split() for line in output.splitlines() if line.strip()[:1].isdigit()]


def test_views_that_agree_exit_0_with_errors_of_the_size_expected(tmp_path: Path) -> None:
    noisy_dataset(tmp_path / "check", seed=8, views=NEW_VIEWS)
    result = run("verify", "check")
    assert result.exit_code == Exit.USABLE
    assert "Valid: " in result.output
    assert "p = " in result.output
    rows = rows_of(result.output)
    assert [row[0] for row in rows] == ["0", "1", "2", "3", "4"]
    assert {row[-1] for row in rows} == {"yes"}
    errors, expected = np.array([[float(x) for x in row[1:3]] for row in rows]).T
    assert 0.3 < np.sqrt(np.mean((errors / expected) ** 2)) < 2
    assert "300 image points" in result.output


def test_camera_that_was_pushed_exits_5_and_says_what_moved(tmp_path: Path) -> None:
    truth = exact_recording()
    pushed = truth.t_gripper2base - truth.R_gripper2base @ BUMP
    noisy_dataset(tmp_path / "check", seed=8, views=NEW_VIEWS, t_gripper2base=pushed)
    result = run("verify", "check", "--picture", "errors.png")
    assert result.exit_code == Exit.BEYOND_LIMITS
    assert "Not valid: " in result.output
    assert "The views ask for another t_cam2gripper" in result.output
    assert "calibrate again" in result.output
    assert "no" in {row[-1] for row in rows_of(result.output)}
    assert "Traceback" not in result.output
    picture = cv2.imread("errors.png")
    assert picture is not None
    assert picture.std() > 10


def test_too_few_views_exit_3_with_how_many_are_needed(tmp_path: Path) -> None:
    noisy_dataset(tmp_path / "check", views=NEW_VIEWS[:2])
    result = run("verify", "check")
    assert result.exit_code == Exit.INSUFFICIENT_DATA
    assert "needs 3 views, has 2" in result.output


def test_calibration_that_is_not_there_exits_4(tmp_path: Path) -> None:
    noisy_dataset(tmp_path / "check", views=NEW_VIEWS)
    result = run("verify", "check", "--calibration", "absent.yaml")
    assert result.exit_code == Exit.BAD_FILE
    assert "absent.yaml" in result.output


def test_calibration_of_version_1_exits_4_and_says_what_it_lacks(tmp_path: Path) -> None:
    noisy_dataset(tmp_path / "check", views=NEW_VIEWS)
    result = run("verify", "check", "--calibration", REPOSITORY / "test/data/calibration_v1.yaml")
    assert result.exit_code == Exit.BAD_FILE
    assert "needs covariance and noise levels (schema_version 2), given version 1" in result.output


def test_calibration_of_another_image_size_exits_4(tmp_path: Path, calibrated: Calibration) -> None:
    noisy_dataset(tmp_path / "check", views=NEW_VIEWS)
    calibrated.model_copy(update={"image_width": 1280, "image_height": 960}).save("large.yaml")
    result = run("verify", "check", "--calibration", "large.yaml")
    assert result.exit_code == Exit.BAD_FILE
    assert "needs images of 1280 x 960 as calibrated, has 640 x 480" in result.output


def test_damaged_data_set_exits_4(tmp_path: Path) -> None:
    noisy_dataset(tmp_path / "check", views=NEW_VIEWS)
    (tmp_path / "check/dataset.yaml").write_text("schema_version: 7\n")
    assert run("verify", "check").exit_code == Exit.BAD_FILE


@pytest.mark.parametrize("arguments", [("verify",), ("verify", "check", "--calibrations", "x.yaml")])
def test_wrong_usage_exits_2(arguments: tuple[str, ...]) -> None:
    assert run(*arguments).exit_code == Exit.USAGE
