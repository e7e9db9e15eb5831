# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A tool centre point that a session could not give back: the next one on the same controller knows what it was."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from cv_active_handeye.robots.base import RobotStoppedError, RobotUnavailableError, Speed
from cv_active_handeye.robots.ur import UrConfig, UrRobot, connect
from cv_active_handeye.robots.ur_pose import pose_matrix, pose_vector
from cv_active_handeye.robots.ur_tool import ToolRecord, record_path
from cv_active_handeye.simulation import CellConfig
from cv_active_handeye.simulation.emulators import EmulatedArm, EventLog
from cv_active_handeye.simulation.emulators.ur import UrEmulator

pytestmark = [pytest.mark.timeout(120), pytest.mark.skipif(os.name == "nt", reason="addresses 127.x.y.z")]
TOOL = [0.0, 0.0, 0.1, 0.0, 0.0, 0.0]
OTHER = [0.01, -0.02, 0.15, 0.3, 0.0, -0.2]
ZEROS = [0.0] * 6


@pytest.fixture
def state(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where this test's sessions remember things; a file a controller."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    return tmp_path / "state" / "cv_active_handeye"


@pytest.fixture
def emulator(state: Path) -> Iterator[UrEmulator]:
    """In this process, for ur_rtde is in another one."""
    host = f"127.{1 + os.getpid() // 250 % 250}.{1 + os.getpid() % 250}.5"
    arm = EmulatedArm(CellConfig(robot="ur5e"), speedup=4, log=EventLog())
    with UrEmulator(arm, host) as emulator:
        yield emulator
    arm.close()


def live(emulator: UrEmulator) -> UrRobot:
    return connect(UrConfig(host=emulator.host, freshness_s=1.0, watchdog_s=5.0), live=True)


def tool(emulator: UrEmulator) -> list[float]:
    return pose_vector(emulator.controller.T_tcp2flange)


def leave_zeros(emulator: UrEmulator) -> None:
    """A session that ends in a stop which nobody clears before it is over."""
    robot = live(emulator)
    emulator.controller.arm.faults.set("emergency_stop")
    with pytest.raises(RobotStoppedError, match="emergency stop"):
        robot.move_linear(robot.pose().T_gripper2base, Speed())
    robot.close()
    assert tool(emulator) == ZEROS
    emulator.controller.arm.clear()


def test_session_that_ends_well_leaves_no_record(emulator: UrEmulator, state: Path) -> None:
    with live(emulator):
        assert tool(emulator) == ZEROS
        (file,) = state.iterdir()
        assert file.name == f"ur-{emulator.controller.serial}.json"
        record = ToolRecord.load(file)
        assert record is not None
        assert (record.controller, list(record.tool)) == (emulator.host, TOOL)
    assert tool(emulator) == TOOL
    assert list(state.iterdir()) == []


def test_next_session_gives_back_what_an_earlier_one_could_not(
    emulator: UrEmulator, state: Path, caplog: pytest.LogCaptureFixture
) -> None:
    leave_zeros(emulator)
    assert "The next session with moves gives it back" in caplog.text
    caplog.clear()
    with live(emulator) as robot:
        assert "still the flange, as a session of 2" in caplog.text
        assert "p[0.0, 0.0, 0.1, 0.0, 0.0, 0.0]" in caplog.text
        reported = emulator.controller.arm.reported_pose()
        np.testing.assert_allclose(robot.pose().T_gripper2base, reported, atol=1e-9)
    np.testing.assert_allclose(tool(emulator), TOOL, atol=1e-12)
    assert list(state.iterdir()) == []


def test_session_that_only_looks_says_that_the_tool_was_left(
    emulator: UrEmulator, state: Path, caplog: pytest.LogCaptureFixture
) -> None:
    leave_zeros(emulator)
    caplog.clear()
    with connect(UrConfig(host=emulator.host, freshness_s=1.0), live=False):
        pass
    assert "the tool centre point is still the flange; it was p[0.0, 0.0, 0.1," in caplog.text
    assert len(list(state.iterdir())) == 1
    assert tool(emulator) == ZEROS


def test_tool_that_somebody_set_since_wins(emulator: UrEmulator, state: Path, caplog: pytest.LogCaptureFixture) -> None:
    leave_zeros(emulator)
    caplog.clear()
    emulator.controller.T_tcp2flange = pose_matrix(OTHER)
    with live(emulator):
        (file,) = state.iterdir()
        record = ToolRecord.load(file)
        assert record is not None
        np.testing.assert_allclose(record.tool, OTHER, atol=1e-12)
    np.testing.assert_allclose(tool(emulator), OTHER, atol=1e-12)
    assert caplog.text == ""
    assert list(state.iterdir()) == []


def test_zeros_that_nobody_left_are_the_users_own(emulator: UrEmulator, state: Path) -> None:
    emulator.controller.T_tcp2flange = np.eye(4)
    with live(emulator):
        assert not state.exists()
    assert tool(emulator) == ZEROS


def test_tool_stays_where_it_cannot_be_written_down_or_its_record_is_damaged(emulator: UrEmulator, state: Path) -> None:
    state.parent.mkdir(parents=True)
    state.write_text("a file where the folder should be")
    with pytest.raises(RobotUnavailableError, match="cannot be written down before it is changed"):
        live(emulator)
    assert tool(emulator) == TOOL
    state.unlink()
    state.mkdir()
    record_path(emulator.host, emulator.controller.serial).write_text('{"tool": [1, 2]}')
    emulator.controller.T_tcp2flange = np.eye(4)
    with pytest.raises(RobotUnavailableError, match="set the tool centre point at the pendant, then delete this file"):
        live(emulator)
    assert not emulator.controller.playing


def test_records_are_named_by_serial_number_or_address(state: Path) -> None:
    assert record_path("192.0.2.7", "20235500123") == state / "ur-20235500123.json"
    assert record_path("robot/../2", None) == state / "ur-at-robot_.._2.json"
