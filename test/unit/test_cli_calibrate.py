# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The command line: what it prints, what it writes, and its exit status."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
import pytest
from support.exact_recording import exact_recording
from support.recordings import exact_dataset
from typer.testing import CliRunner

import cv_active_handeye as cah
from cv_active_handeye.calibration import Calibration
from cv_active_handeye.cli.commands import app
from cv_active_handeye.cli.console import Exit

COMMANDS = ("demo", "simulate", "calibrate", "compare", "show")


@pytest.fixture(autouse=True)
def _wide_terminal(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    monkeypatch.chdir(tmp_path)


class Outcome(NamedTuple):
    exit_code: int
    output: str
    exception: BaseException | None


def run(*arguments: str | Path) -> Outcome:
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    return Outcome(result.exit_code, result.output, result.exception)


def distortion_file(folder: Path) -> Path:
    storage = cv2.FileStorage(str(folder / "camera.yaml"), cv2.FILE_STORAGE_WRITE)
    storage.write("camera_matrix", exact_recording().cameraMatrix)
    storage.write("distortion_coefficients", exact_recording().distCoeffs)
    storage.release()
    return folder / "camera.yaml"


@pytest.mark.parametrize("command", COMMANDS)
def test_help_of_every_command_has_an_example_and_the_exit_statuses(command: str) -> None:
    result = run(command, "--help")
    assert result.exit_code == 0
    assert f"Example: cv-active-handeye {command}" in result.output
    assert "3 the data cannot answer" in result.output


def test_help_lists_all_commands_and_version_is_the_library_s() -> None:
    assert all(command in run("--help").output for command in COMMANDS)
    assert run("--version").output.strip() == cah.__version__


def test_calibrate_writes_the_result_and_prints_it(tmp_path: Path) -> None:
    exact_dataset(tmp_path / "set")
    result = run("calibrate", "set", "--distortion", distortion_file(tmp_path), "-o", "result.yaml")
    assert result.exit_code == Exit.USABLE
    found = Calibration.load("result.yaml")
    assert found.t_cam2gripper == pytest.approx(exact_recording().t_cam2gripper, abs=1e-6)
    assert f"{found.camera_matrix[0, 0]:.2f}" in result.output
    assert "no light plane" in result.output


def test_calibrate_with_known_camera_keeps_it(tmp_path: Path) -> None:
    exact_dataset(tmp_path / "set")
    assert run("calibrate", "set", "--camera", distortion_file(tmp_path)).exit_code == Exit.USABLE
    found = Calibration.load("calibration.yaml")
    assert np.array_equal(found.camera_matrix, exact_recording().cameraMatrix)
    assert found.constraints == ("known_camera_matrix", "known_distortion")


def test_calibrate_draws_the_motion_without_images(tmp_path: Path) -> None:
    exact_dataset(tmp_path / "set")
    assert run("calibrate", "set", "--pictures", "pictures").exit_code == Exit.USABLE
    assert [path.name for path in (tmp_path / "pictures").iterdir()] == ["motion.png"]


def test_calibrate_without_translations_exits_3_with_the_text_of_the_library(tmp_path: Path) -> None:
    exact_dataset(tmp_path / "set", [0, 5, 10, 12])
    result = run("calibrate", "set", "-o", "result.yaml")
    assert result.exit_code == Exit.INSUFFICIENT_DATA
    assert "equal orientation" in result.output
    assert "while: camera matrix and rotation" in result.output
    assert "Traceback" not in result.output
    assert not (tmp_path / "result.yaml").exists()


def test_debug_passes_the_exception_on(tmp_path: Path) -> None:
    exact_dataset(tmp_path / "set", [0, 5, 10, 12])
    assert isinstance(run("--debug", "calibrate", "set").exception, cah.error)


def test_damaged_data_set_exits_4_with_the_key(tmp_path: Path) -> None:
    exact_dataset(tmp_path / "set")
    with (tmp_path / "set/dataset.yaml").open("a") as stream:
        stream.write("gain: 3\n")
    result = run("calibrate", "set")
    assert result.exit_code == Exit.BAD_FILE
    assert "key 'gain' is unknown" in result.output


def test_settings_file_with_unknown_key_exits_4_with_the_key(tmp_path: Path) -> None:
    exact_dataset(tmp_path / "set")
    (tmp_path / "settings.yaml").write_text("square: true\n")
    result = run("calibrate", "set", "--config", "settings.yaml")
    assert result.exit_code == Exit.BAD_FILE
    assert "key 'square' is unknown" in result.output


def test_settings_file_is_overridden_by_the_command_line(tmp_path: Path) -> None:
    exact_dataset(tmp_path / "set")
    (tmp_path / "settings.yaml").write_text("square_pixels: true\nzero_skew: true\n")
    assert run("calibrate", "set", "--config", "settings.yaml", "--skew").exit_code == Exit.USABLE
    assert Calibration.load("calibration.yaml").constraints == ("square_pixels", "no_distortion")


@pytest.mark.parametrize(
    "arguments",
    [("calibrate",), ("calibrate", "set", "--methode", "foe"), ("compare", "set", "--board", "chess:1"), ("simulate",)],
)
def test_wrong_usage_exits_2(arguments: tuple[str, ...]) -> None:
    assert run(*arguments).exit_code == Exit.USAGE


def test_simulate_refuses_an_unknown_robot(tmp_path: Path) -> None:
    result = run("simulate", "set", "--robot", "r2d2")
    assert result.exit_code == Exit.USAGE
    assert not (tmp_path / "set").exists()


def test_show_prints_a_result_and_a_data_set(tmp_path: Path) -> None:
    exact_dataset(tmp_path / "set")
    run("calibrate", "set")
    result = run("show", "calibration.yaml")
    assert result.exit_code == Exit.USABLE
    assert "t_cam2gripper z" in result.output
    shown = run("show", "set")
    assert shown.exit_code == Exit.USABLE
    assert len([line for line in shown.output.splitlines() if line.strip()[:1].isdigit()]) == 14


def test_show_of_an_incomplete_data_set_exits_4_and_says_what_is_missing(tmp_path: Path) -> None:
    exact_dataset(tmp_path / "set")
    (tmp_path / "set/image_points.csv").unlink()
    result = run("show", "set")
    assert result.exit_code == Exit.BAD_FILE
    assert "image_points.csv: the file is missing" in result.output


def test_show_of_nothing_exits_4() -> None:
    result = run("show", "absent.yaml")
    assert result.exit_code == Exit.BAD_FILE
    assert "absent.yaml" in result.output


def test_demo_refuses_a_folder_it_did_not_write(tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/thesis.txt").write_text("years of work")
    result = run("demo", "--output", "mine")
    assert result.exit_code == Exit.USAGE
    assert "was not written by the demo" in result.output
    assert (tmp_path / "mine/thesis.txt").read_text() == "years of work"
    assert [path.name for path in (tmp_path / "mine").iterdir()] == ["thesis.txt"]
