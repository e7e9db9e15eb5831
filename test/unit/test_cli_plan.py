# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The command `plan`: files, table, and one exit status per kind of answer."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation
from support.command_line import run
from support.planning_cell import JOINTS, flange, settings

from cv_active_handeye.cli.console import Exit
from cv_active_handeye.cli.planning import millimetres, start_from
from cv_active_handeye.plan_file import Plan
from cv_active_handeye.simulation import CellConfig, SimulatedCell


def pose_text() -> str:
    T = flange(JOINTS)
    turn = np.degrees(Rotation.from_matrix(T[:3, :3]).as_rotvec())
    return ",".join(repr(float(x)) for x in (*(1000 * T[:3, 3]), *turn))


@pytest.fixture
def cell(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "cell.yaml"
    file.write_text(yaml.safe_dump(settings(stops=10).model_dump(mode="json")))
    return file


def test_plan_writes_file_picture_and_predictions(cell: Path) -> None:
    outcome = run("plan", cell, f"--start-pose={pose_text()}", "-o", "made/plan.yaml")
    assert outcome.exit_code == Exit.USABLE, outcome.output
    made = Plan.load(Path("made/plan.yaml"))
    assert len(made.stops) == 10
    np.testing.assert_allclose(made.start.T_gripper2base, flange(JOINTS), atol=1e-9)
    picture = cv2.imread("made/plan.png")
    assert picture is not None
    assert picture.std() > 5
    last = made.predictions[-1]
    assert f"{last.t_cam2gripper_mm:.3g}" in outcome.output
    assert "10 stops at" in outcome.output


def test_plan_starts_where_the_robot_of_the_station_stands(tmp_path: Path) -> None:
    file = tmp_path / "plan.yaml"
    outcome = run("plan", "--robot", "sim", "--camera", "sim", "--stops", "10", "-o", file)
    assert outcome.exit_code == Exit.USABLE, outcome.output
    made = Plan.load(file)
    assert (made.robot, made.model, len(made.stops)) == ("simulated DENSO VP-6242", "denso_vp6242", 10)
    np.testing.assert_allclose(made.start.T_gripper2base, SimulatedCell(CellConfig()).start(), atol=2e-5)
    twice = run("plan", "--robot", "sim", "--camera", "sim", "--start-pose", "1,2,3,4,5,6", "-o", file)
    assert twice.exit_code == Exit.USAGE
    assert "the station's robot says where it stands" in twice.output


def test_too_few_stops_are_called_that(tmp_path: Path) -> None:
    outcome = run("plan", "--robot", "sim", "--camera", "sim", "--stops", "8", "-o", tmp_path / "plan.yaml")
    assert outcome.exit_code == Exit.INSUFFICIENT_DATA
    assert "8 stops do not suffice: " in outcome.output
    assert "more stops may" in outcome.output
    assert not (tmp_path / "plan.yaml").exists()


def test_stops_on_the_command_line_replace_those_of_the_file(cell: Path) -> None:
    outcome = run("plan", cell, f"--start-pose={pose_text()}", "--stops", "9", "--picture", "other.png")
    assert outcome.exit_code == Exit.USABLE, outcome.output
    assert len(Plan.load(Path("plan.yaml")).stops) == 9
    assert Path("other.png").is_file()


def test_target_out_of_reach_is_an_answer_that_data_cannot_give(cell: Path) -> None:
    content = yaml.safe_load(cell.read_text()) | {"most_stops": 10}
    cell.write_text(yaml.safe_dump(content))
    outcome = run("plan", cell, f"--start-pose={pose_text()}", "--target-sigma", "0.01mm")
    assert outcome.exit_code == Exit.INSUFFICIENT_DATA
    assert "10 stops (most_stops) are predicted to reach" in outcome.output
    assert not Path("plan.yaml").exists()


def test_wrong_usage_is_told(cell: Path) -> None:
    pose = f"--start-pose={pose_text()}"
    for arguments, text in (
        ([], "one of --start-joints and --start-pose"),
        ([pose, "--model", "ur5e"], "an arm needs --start-joints"),
        ([pose, "--stops", "9", "--target-sigma", "1mm"], "one of --stops and --target-sigma"),
        ([pose, "--target-sigma", "2kg"], "such as 0.2mm, given '2kg'"),
        (["--start-pose=1,2,3"], "six numbers separated by commas, given '1,2,3'"),
        (["--start-joints=0,0,0,0,0,0"], "--start-joints need the arm"),
        (["--start-joints=0,0,0,0,0,0", "--model", "abc"], "ur5e, given 'abc'"),
    ):
        outcome = run("plan", cell, *arguments)
        assert outcome.exit_code == Exit.USAGE, outcome.output
        assert text in " ".join(outcome.output.replace("│", " ").split())


def test_settings_with_an_unknown_key_are_refused(cell: Path) -> None:
    cell.write_text(cell.read_text() + "stand_of_mm: 3\n")
    outcome = run("plan", cell, f"--start-pose={pose_text()}")
    assert outcome.exit_code == Exit.BAD_FILE
    assert "stand_of_mm" in outcome.output


def test_lengths_have_units() -> None:
    assert [millimetres(text) for text in ("0.2mm", "200um", "0.0002m", "0.2")] == pytest.approx([0.2] * 4)


def test_start_joints_are_those_of_the_arm() -> None:
    found = start_from("ur5e", ",".join(str(x) for x in np.degrees(JOINTS)), None)
    assert found.model == "ur5e"
    np.testing.assert_allclose(found.T_gripper2base, flange(JOINTS), atol=1e-12)
