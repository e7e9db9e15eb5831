# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The command line: what it prints, what it writes, and its exit status."""

from __future__ import annotations

import re
from pathlib import Path

import cv2
import numpy as np
import pytest
from support.command_line import run
from support.exact_recording import exact_recording
from support.recordings import exact_dataset, noisy_dataset

import cv_active_handeye as cah
from cv_active_handeye.calibration import Calibration
from cv_active_handeye.cli.console import Exit

COMMANDS = ("demo", "simulate", "calibrate", "verify", "compare", "show")


@pytest.fixture(autouse=True)
def _own_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)


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
    assert result.output.count(f"Example: cv-active-handeye {command}") >= 2
    assert "3 the data cannot answer" in result.output


@pytest.mark.parametrize("command", COMMANDS)
def test_examples_of_the_help_are_commands_with_options_that_exist(command: str) -> None:
    told = run(command, "--help").output
    examples = re.findall(r"Example: cv-active-handeye (.*?)\s*$", told, re.MULTILINE)
    for example in examples:
        words = example.split()
        assert words[0] == command
        assert all(option in told for option in words if option.startswith("-"))


def test_paragraphs_of_the_help_have_no_broken_lines() -> None:
    words = "Needs pure translations (stops of equal orientation; for an unknown camera four directions, no three in a"
    assert words in run("calibrate", "--help").output


def test_help_lists_all_commands_and_version_is_the_library_s() -> None:
    assert all(command in run("--help").output for command in COMMANDS)
    assert run("--version").output.strip() == cah.__version__


def test_calibrate_writes_the_result_and_prints_it(tmp_path: Path) -> None:
    noisy_dataset(tmp_path / "set")
    result = run("calibrate", "set", "--distortion", distortion_file(tmp_path), "-o", "result.yaml")
    assert result.exit_code == Exit.USABLE
    found = Calibration.load("result.yaml")
    assert found.verdict is not None
    assert found.verdict.usable
    assert found.t_cam2gripper == pytest.approx(exact_recording().t_cam2gripper, abs=1e-3)
    assert "Usable: a point at the working distance of" in result.output
    assert "robot 0.0" in result.output
    assert "no light plane" in result.output


def test_table_shows_every_parameter_with_its_interval(tmp_path: Path) -> None:
    noisy_dataset(tmp_path / "set")
    lines = run("calibrate", "set", "--distortion", distortion_file(tmp_path)).output.splitlines()
    found = Calibration.load("calibration.yaml")
    rows = {" ".join(line.split()).partition(" ")[0]: line.split() for line in lines}
    for name in ("fx", "fy", "cx", "cy"):
        lower, to, upper, unit = rows[name][2:]
        assert (to, unit) == ("to", "px")
        assert (float(lower), float(upper)) == pytest.approx(found.interval(name), rel=1e-3, abs=0.06)
    tz = next(line.split() for line in lines if "t_cam2gripper z" in line)
    assert 1000 * np.array(found.interval("tz")) == pytest.approx([float(tz[3]), float(tz[5])], abs=0.06)
    rx = next(line.split() for line in lines if "R_cam2gripper rx" in line)
    ends = found.interval("rx")
    assert ends is not None
    assert rx[3] == "±"
    assert np.radians(float(rx[4])) == pytest.approx((ends[1] - ends[0]) / 2, rel=0.06)
    assert any("k1" in line and "kept" in line for line in lines)


@pytest.mark.parametrize(
    ("options", "page"),
    [((), "out/report.html"), (("--report", "pages/page.html"), "pages/page.html"), (("--no-report",), None)],
)
def test_calibrate_writes_the_report_where_it_is_wanted(
    tmp_path: Path, options: tuple[str, ...], page: str | None
) -> None:
    noisy_dataset(tmp_path / "set")
    result = run("calibrate", "set", "-o", "out/calibration.yaml", *options)
    assert result.exit_code == Exit.USABLE
    assert [str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*.html")] == ([page] if page else [])
    assert ("Report:" in result.output) == (page is not None)
    if page:
        assert page in result.output
        assert "<title>Usable" in Path(page).read_text(encoding="utf-8")


def test_result_that_contradicts_its_data_is_saved_marked_and_exits_5(tmp_path: Path) -> None:
    noisy_dataset(tmp_path / "set")
    result = run("calibrate", "set", "--robot-mm", "0.001", "--robot-deg", "0.0002")
    assert result.exit_code == Exit.BEYOND_LIMITS
    assert "calibration.yaml: NOT USABLE" in result.output
    assert "Traceback" not in result.output
    found = Calibration.load("calibration.yaml")
    assert found.verdict is not None
    assert not found.verdict.usable
    assert "<title>Do not use" in Path("report.html").read_text(encoding="utf-8")
    shown = run("show", "calibration.yaml")
    assert shown.exit_code == Exit.USABLE
    assert "NOT USABLE" in shown.output


def test_calibrate_with_known_camera_keeps_it(tmp_path: Path) -> None:
    noisy_dataset(tmp_path / "set")
    assert run("calibrate", "set", "--camera", distortion_file(tmp_path)).exit_code == Exit.USABLE
    found = Calibration.load("calibration.yaml")
    assert np.array_equal(found.camera_matrix, exact_recording().cameraMatrix)
    assert found.constraints == ("known_camera_matrix", "known_distortion")


def test_calibrate_draws_the_motion_without_images(tmp_path: Path) -> None:
    noisy_dataset(tmp_path / "set")
    assert run("calibrate", "set", "--pictures", "pictures").exit_code == Exit.USABLE
    assert [path.name for path in (tmp_path / "pictures").iterdir()] == ["motion.png"]


def test_calibrate_without_translations_exits_3_with_the_text_of_the_library(tmp_path: Path) -> None:
    exact_dataset(tmp_path / "set", [0, 5, 10, 12])
    result = run("calibrate", "set", "-o", "result.yaml")
    assert result.exit_code == Exit.INSUFFICIENT_DATA
    assert "equal orientation" in result.output
    assert "while: refining camera and hand-eye transform" in result.output
    assert "Traceback" not in result.output
    assert not (tmp_path / "result.yaml").exists()


def test_calibrate_without_turns_exits_3_and_names_the_option_that_would_do(tmp_path: Path) -> None:
    exact_dataset(tmp_path / "set", [0, 1, 2, 3, 4])
    result = run("calibrate", "set", "-o", "result.yaml")
    assert result.exit_code == Exit.INSUFFICIENT_DATA
    text = " ".join(result.output.split())
    assert "add rotations about two axes that are not parallel, or set --allow-partial" in text
    assert "REFINE_" not in text


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
    noisy_dataset(tmp_path / "set")
    (tmp_path / "settings.yaml").write_text("lens_model: none\nzero_skew: true\n")
    assert run("calibrate", "set", "--config", "settings.yaml", "--lens", "k3", "--skew").exit_code == Exit.USABLE
    found = Calibration.load("calibration.yaml")
    assert found.constraints == ()
    assert found.lens is not None
    assert found.lens.model == "k3"


def test_options_that_contradict_each_other_exit_2(tmp_path: Path) -> None:
    noisy_dataset(tmp_path / "set")
    result = run("calibrate", "set", "--camera", distortion_file(tmp_path), "--square-pixels")
    assert result.exit_code == Exit.USAGE
    assert "square_pixels: needs an unknown camera matrix" in result.output
    assert run("calibrate", "set", "--robot-mm", "0").exit_code == Exit.USAGE
    assert not (tmp_path / "calibration.yaml").exists()


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


def test_simulate_refuses_a_truth_inside_of_the_data_set(tmp_path: Path) -> None:
    result = run("simulate", "set", "--truth", "set/truth.yaml")
    assert result.exit_code == Exit.USAGE
    assert "outside" in result.output
    assert not (tmp_path / "set").exists()


def test_show_prints_a_result_and_a_data_set(tmp_path: Path) -> None:
    noisy_dataset(tmp_path / "set")
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
