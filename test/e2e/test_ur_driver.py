# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The UR driver with the unmodified ur_rtde against the emulated controller in another process."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from support.ur_emulator import UrEmulatorProcess

from cv_active_handeye.robots.base import (
    MoveRefusedError,
    Robot,
    RobotError,
    RobotStoppedError,
    RobotUnavailableError,
    Speed,
    StopReason,
)
from cv_active_handeye.robots.straight_move import ARRIVED_M
from cv_active_handeye.robots.ur import UrConfig, UrRobot, connect
from cv_active_handeye.robots.ur_pose import pose_vector
from cv_active_handeye.robots.workspace import step_size
from cv_active_handeye.simulation.emulators import moves_after_stop, read_events

Array = NDArray[np.float64]
pytestmark = [pytest.mark.timeout(120), pytest.mark.usefixtures("_cleared")]
FAST = Speed(metres_per_second=0.25, metres_per_second2=1.0)
SPEEDUP = 4.0
TOOL = [0.0, 0.0, 0.1, 0.0, 0.0, 0.0]


@pytest.fixture(scope="module")
def emulator(tmp_path_factory: pytest.TempPathFactory) -> Iterator[UrEmulatorProcess]:
    with UrEmulatorProcess(tmp_path_factory.mktemp("ur"), 1, "--speedup", str(SPEEDUP)) as process:
        yield process
        assert process.end().endswith("ended\n")
        assert process.process.returncode == 0


@pytest.fixture
def _cleared(emulator: UrEmulatorProcess) -> None:
    emulator.begin()


def patient(emulator: UrEmulatorProcess, **options: object) -> UrConfig:
    """The machine of the tests is a busy one."""
    return UrConfig.model_validate({"host": emulator.host, "freshness_s": 1.0, "watchdog_s": 3.0, **options})


def live(emulator: UrEmulatorProcess) -> UrRobot:
    return connect(patient(emulator), live=True)


def raised(pose: Array, mm: float) -> Array:
    """A little nearer to the middle of the arm's range of heights, again and again."""
    out = pose.copy()
    out[2, 3] += mm / 1000 if pose[2, 3] < 0.5 else -mm / 1000
    return out


def through_pi(R: Array) -> Array:
    """The rotation on the other side of the angle pi about the same axis, 3 deg beyond it."""
    vector = Rotation.from_matrix(R).as_rotvec()
    return Rotation.from_rotvec(vector / np.linalg.norm(vector) * np.radians(183)).as_matrix()


def tool_of(emulator: UrEmulatorProcess) -> list[float]:
    """The tool centre point that was set last, by the log."""
    found = [e["args"] for e in emulator.events() if e["kind"] == "command" and e["name"] == "setTcp"]
    return list(found[-1])


def test_pose_without_live_is_the_flange_and_starts_no_program(emulator: UrEmulatorProcess) -> None:
    with connect(UrConfig(host=emulator.host, freshness_s=1.0), live=False) as robot:
        assert isinstance(robot, Robot)
        assert (robot.model, robot.live) == ("ur5e", False)
        pose = robot.pose()
        np.testing.assert_allclose(pose.T_gripper2base, emulator.link.state().T_reported, atol=1e-12)
        np.testing.assert_allclose(pose.joints, emulator.link.state().joints, atol=1e-12)
        assert robot.pose().controller_time > pose.controller_time
        assert robot.is_steady()
        with pytest.raises(MoveRefusedError, match="not opened to be moved"):
            robot.move_linear(pose.T_gripper2base, FAST)
    assert emulator.commands() == []


def test_three_moves_arrive_and_the_tool_is_given_back(emulator: UrEmulatorProcess) -> None:
    with live(emulator) as robot:
        start = robot.pose().T_gripper2base
        turned = start.copy()
        turned[:3, :3] = through_pi(start[:3, :3])
        assert np.dot(pose_vector(start)[3:], pose_vector(turned)[3:]) < 0  # the vector changes its sign on the way
        for target in (raised(start, 20), raised(turned, 10), raised(start, 30)):
            robot.check_reachable(target)
            robot.move_linear(target, FAST)
            assert step_size(robot.pose().T_gripper2base, target)[0] < ARRIVED_M
            deadline = time.monotonic() + 5
            while not robot.is_steady():
                assert time.monotonic() < deadline
        robot.set_output(5, True)
        assert emulator.link.state().outputs[5]
        with pytest.raises(RobotError, match="pin: needs 0 to 7, given 8"):
            robot.set_output(8, True)
        with pytest.raises(MoveRefusedError, match="controller says"):
            robot.check_reachable(raised(robot.pose().T_gripper2base, 2000))
    assert [e["arrived"] for e in emulator.events() if e["kind"] == "motion_end"] == [True] * 3
    assert [e["args"] for e in emulator.events() if e["kind"] == "command" and e["name"] == "setTcp"] == [
        [0.0] * 6,
        TOOL,
    ]
    assert emulator.commands()[-1] == "stopScript"
    assert not [e for e in emulator.events() if e["kind"] == "violation"]


def test_tool_is_given_back_after_an_exception_of_the_caller(emulator: UrEmulatorProcess) -> None:
    with pytest.raises(ZeroDivisionError), live(emulator):
        raise ZeroDivisionError
    assert tool_of(emulator) == TOOL


STOPS = {
    "protective_stop": {StopReason.PROTECTIVE_STOP},
    "program_stopped": {StopReason.PROGRAM_STOPPED},
    "drop_link": {StopReason.LINK_LOST},
    "silent_port": {StopReason.STALE_POSE, StopReason.LINK_LOST},
    "frozen_timestamp": {StopReason.STALE_POSE},
    "pose_noise": {StopReason.NOT_ARRIVED, StopReason.OFF_PATH},
    "nan_pose": {StopReason.CONTROLLER_ERROR},
    "slow_motion=0.002": {StopReason.DEADLINE},
}


@pytest.mark.parametrize("fault", STOPS)
def test_fault_in_a_move_is_named_and_nothing_moves_after_it(
    emulator: UrEmulatorProcess, fault: str, caplog: pytest.LogCaptureFixture
) -> None:
    robot = live(emulator)
    slow = fault.startswith("slow_motion")
    target = raised(robot.pose().T_gripper2base, 5 if slow else 60)
    if slow:
        emulator.link.fault("slow_motion", 0.002)
    else:
        emulator.link.plan_fault(f"{fault}@move{1 + moved_so_far(emulator)}")
    began = time.monotonic()
    with pytest.raises(RobotStoppedError) as caught:
        robot.move_linear(target, Speed(metres_per_second=0.05, metres_per_second2=1.0))
    assert caught.value.reason in STOPS[fault]
    assert time.monotonic() - began < 8
    with pytest.raises(RobotStoppedError, match=caught.value.reason.value):
        robot.move_linear(target, FAST)
    if fault in ("protective_stop", "silent_port"):
        assert not moves_after_stop(emulator.events())
        emulator.link.clear()
    began = time.monotonic()
    robot.close()
    assert time.monotonic() - began < 12
    events = emulator.events()
    assert len([e for e in events if e["kind"] == "motion_begin"]) == 1
    assert not moves_after_stop(events)
    assert "unlock protective stop" not in emulator.commands()
    assert tool_of(emulator) == TOOL
    assert caplog.text == ""
    assert not emulator.link.state().moving


def test_target_that_the_controller_cannot_reach_stops_the_program_and_nothing_moves(
    emulator: UrEmulatorProcess,
) -> None:
    with live(emulator) as robot:
        emulator.link.fault("unreachable")
        with pytest.raises(RobotStoppedError, match=r"program stopped: .* a motion was not possible"):
            robot.move_linear(raised(robot.pose().T_gripper2base, 30), FAST)
    assert not [e for e in emulator.events() if e["kind"] == "motion_begin"]
    assert tool_of(emulator) == TOOL


@pytest.mark.parametrize("fault", ["program_stopped", "drop_link"])
def test_question_to_a_program_that_has_ended_is_a_stop_and_no_answer(emulator: UrEmulatorProcess, fault: str) -> None:
    with live(emulator) as robot:
        here = robot.pose().T_gripper2base
        emulator.link.fault(fault)
        with pytest.raises(RobotStoppedError):
            robot.is_steady() if fault == "drop_link" else robot.check_reachable(here)
    assert tool_of(emulator) == TOOL


def test_connect_without_ur_rtde_names_the_extra(
    emulator: UrEmulatorProcess, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "rtde_receive.py").write_text("raise ModuleNotFoundError('no such module', name='rtde_receive')")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    with pytest.raises(RobotUnavailableError, match=r"pip install 'cv_active_handeye\[ur\]'"):
        connect(UrConfig(host=emulator.host), live=False)


def moved_so_far(emulator: UrEmulatorProcess) -> int:
    return sum(event["kind"] == "motion_begin" for event in read_events(emulator.log))


def test_emergency_stop_that_nobody_clears_tells_which_tool_to_set(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    with UrEmulatorProcess(tmp_path, 2, "--fault", "emergency_stop@move1", "--speedup", "4") as emulator:
        robot = live(emulator)
        with pytest.raises(RobotStoppedError, match="emergency stop: release the button"):
            robot.move_linear(raised(robot.pose().T_gripper2base, 60), FAST)
        robot.close()
        assert "it was p[0.0, 0.0, 0.1, 0.0, 0.0, 0.0]" in caplog.text
        assert tool_of(emulator) == [0.0] * 6
        assert not moves_after_stop(emulator.events())


def test_stop_from_another_thread_ends_a_move_and_latches(emulator: UrEmulatorProcess) -> None:
    with live(emulator) as robot:
        start = robot.pose().T_gripper2base
        threading.Timer(0.15, robot.stop).start()
        with pytest.raises(RobotStoppedError) as caught:
            robot.move_linear(raised(start, 90), Speed(metres_per_second=0.05))
        assert caught.value.reason is StopReason.OPERATOR
        assert step_size(start, robot.pose().T_gripper2base)[0] < 0.085
        with pytest.raises(RobotStoppedError):
            robot.move_linear(start, FAST)
    assert tool_of(emulator) == TOOL


def test_ctrl_c_in_a_move_stops_the_arm_and_gives_the_tool_back(emulator: UrEmulatorProcess) -> None:
    with live(emulator) as robot:
        target = raised(robot.pose().T_gripper2base, 90)
        threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
        with pytest.raises(KeyboardInterrupt):
            robot.move_linear(target, Speed(metres_per_second=0.03))
    assert [e["arrived"] for e in emulator.events() if e["kind"] == "motion_end"] == [False]
    assert tool_of(emulator) == TOOL


def test_ur_rtde_that_hangs_is_given_up_within_the_deadline_and_the_tool_comes_back(
    emulator: UrEmulatorProcess,
) -> None:
    robot = live(emulator)
    os.kill(robot._process._process.pid, signal.SIGSTOP)
    began = time.monotonic()
    with pytest.raises(RobotStoppedError, match=r"link lost: .*no answer within 1 s"):
        robot.pose()
    assert time.monotonic() - began < 3.0
    robot.close()
    assert time.monotonic() - began < 10.0
    assert tool_of(emulator) == TOOL


def test_killed_program_leaves_an_arm_that_was_stopped_and_has_its_tool(emulator: UrEmulatorProcess) -> None:
    code = (
        "import sys; from cv_active_handeye.robots.ur import *\n"
        f"robot = connect(UrConfig(host={emulator.host!r}, freshness_s=1.0), live=True)\n"
        "target = robot.pose().T_gripper2base; target[2, 3] += 0.08 if target[2, 3] < 0.5 else -0.08\n"
        "print('moving', flush=True); robot.move_linear(target, Speed(metres_per_second=0.02))"
    )
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "moving\n"
    while not emulator.link.state().moving:
        time.sleep(0.01)
    os.kill(process.pid, signal.SIGKILL)
    process.communicate()
    deadline = time.monotonic() + 10
    while emulator.commands()[-1] != "stopScript":
        assert time.monotonic() < deadline
        time.sleep(0.05)
    assert [e["arrived"] for e in emulator.events() if e["kind"] == "motion_end"] == [False]
    assert tool_of(emulator) == TOOL


@pytest.mark.parametrize(
    ("fault", "text"),
    [
        ("silent_port", "does not answer"),
        ("not_remote", "local control.*Remote"),
        ("register_conflict", "upper_registers"),
        ("protective_stop", "protective stop: find what"),
        ("emergency_stop", "emergency stop: release the button"),
    ],
)
def test_connect_names_what_is_in_the_way(emulator: UrEmulatorProcess, fault: str, text: str) -> None:
    emulator.link.fault(fault)
    began = time.monotonic()
    with pytest.raises(RobotUnavailableError, match=text):
        live(emulator)
    assert time.monotonic() - began < 12
    assert "moveL" not in emulator.commands()


def test_upper_registers_go_round_a_fieldbus(emulator: UrEmulatorProcess) -> None:
    emulator.link.fault("register_conflict")
    with connect(patient(emulator, upper_registers=True), live=True) as robot:
        robot.move_linear(raised(robot.pose().T_gripper2base, 5), FAST)
    assert tool_of(emulator) == TOOL


def test_connect_refuses_while_another_program_runs(emulator: UrEmulatorProcess) -> None:
    with live(emulator), pytest.raises(RobotUnavailableError, match="a program runs on the controller"):
        live(emulator)


@pytest.mark.parametrize("version", ["3.15", "10.11"])
def test_other_versions_move_and_give_the_tool_back(tmp_path: Path, version: str) -> None:
    with UrEmulatorProcess(tmp_path, 2, "--version", version, "--speedup", "20") as emulator:
        with live(emulator) as robot:
            target = raised(robot.pose().T_gripper2base, 20)
            robot.move_linear(target, FAST)
            assert step_size(robot.pose().T_gripper2base, target)[0] < ARRIVED_M
        assert tool_of(emulator) == TOOL
