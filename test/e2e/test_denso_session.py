# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The DENSO driver and the emulated controller in two processes: a whole session, and every fault during a move."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from support.denso_emulator import Running, denso_process, moved, start_of

from cv_active_handeye.robots.base import MoveRefusedError, RobotError, RobotStoppedError, RobotUnavailableError, Speed
from cv_active_handeye.robots.denso import connect
from cv_active_handeye.simulation.emulators import moves_after_stop

pytestmark = pytest.mark.timeout(60)
SPEED = Speed(metres_per_second=0.25, metres_per_second2=1.0)
GRACE_S = 0.05  # between a fault and the moment a client on a loaded machine can know of it

FAULTS = {
    "protective_stop": "controller error: .*protective stop",
    "emergency_stop": "emergency stop: release",
    "drop_link": "link lost",
    "frozen_timestamp": "stale pose: the controller's clock stands still",
    "silent_port": "link lost: .* MAY STILL MOVE",
    "not_remote": "program stopped: the controller is in manual mode",
    "pose_noise": "not arrived|off the path",
    "nan_pose": "controller error: .*finite numbers",
    "program_stopped": "controller error: .*all programs were stopped",
}
"""What the user is told of a fault in the middle of a move."""


@pytest.fixture(scope="module")
def emulated(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    with denso_process(tmp_path_factory.mktemp("emulator"), "--speedup", "10") as running:
        yield running


@pytest.fixture(autouse=True)
def _person_at_the_pendant(emulated: Running) -> Iterator[None]:
    yield
    emulated.link.clear()


def test_session_moves_switches_and_leaves_the_controller_as_it_was(emulated: Running) -> None:
    with connect(emulated.config(model="denso_vp6242"), live=True) as robot:
        start = start_of(robot)
        np.testing.assert_allclose(start, emulated.link.state().T_reported, atol=1e-12)
        for mm, turn in (((15, 0, 0), (0, 0, 0)), ((15, -10, 5), (0, 6, 0)), ((0, 0, 0), (0, 0, 0))):
            robot.move_linear(moved(start, mm, turn), SPEED)
            while not robot.is_steady():
                pass
            assert emulated.link.state().steady
        robot.set_output(2, True)
        assert emulated.link.state().outputs[2]
    state = emulated.link.state()
    assert state.stop_index == 3
    assert [event for event in emulated.events() if event["kind"] == "violation"] == []
    names = [event["name"] for event in emulated.events() if event["kind"] == "command"]
    assert names[-2:] == ["Motor", "GiveArm"]


@pytest.mark.parametrize("fault", FAULTS)
def test_fault_during_a_move_is_named_in_time_and_nothing_moves_afterwards(fault: str, emulated: Running) -> None:
    seen = len(emulated.events())
    with connect(emulated.config(freshness_s=0.3), live=True) as robot:
        start = start_of(robot)
        emulated.link.plan_fault(f"{fault}@move{motions(emulated) + 1}")
        began = time.monotonic()
        with pytest.raises(RobotStoppedError, match=FAULTS[fault]):
            robot.move_linear(moved(start, (0, 40 if start[1, 3] < 0.15 else -40, 0)), SPEED)
        assert time.monotonic() - began < 6.0
        for _ in range(2):
            with pytest.raises(RobotStoppedError):
                robot.move_linear(start, SPEED)
        began = time.monotonic()
    assert time.monotonic() - began < 5.0
    events = emulated.events()[seen:]
    assert any(event["kind"] == "fault" and event["name"] == fault for event in events)
    assert moves_after_stop(events, GRACE_S) == []
    assert sum(event["kind"] == "motion_begin" for event in events) == 1


def test_unreachable_target_is_refused_and_the_next_one_is_not(emulated: Running) -> None:
    with connect(emulated.config(), live=True) as robot:
        emulated.link.fault("unreachable")
        with pytest.raises(MoveRefusedError, match="out of range"):
            robot.move_linear(start_of(robot), SPEED)
        robot.move_linear(moved(start_of(robot), (0, 2, 0)), SPEED)


def test_emulator_that_is_killed_is_a_lost_link(tmp_path: Path) -> None:
    with denso_process(tmp_path, ends_well=False) as running:
        with connect(running.config(), live=True) as robot:
            start = start_of(robot)
            running.process.kill()
            running.process.wait()
            began = time.monotonic()
            with pytest.raises(RobotStoppedError, match="link lost"):
                robot.move_linear(moved(start, (0, 5, 0)), SPEED)
            with pytest.raises(RobotError):
                robot.pose()
        assert time.monotonic() - began < 5.0
        with pytest.raises(RobotUnavailableError, match="cannot be reached"):
            connect(running.config(), live=False)


def motions(emulated: Running) -> int:
    return sum(event["kind"] == "motion_begin" for event in emulated.events())
