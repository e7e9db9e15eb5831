# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The controller stops the arm by itself when it hears nothing of us any more, and never because we are merely busy."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from support.ur_emulator import UrEmulatorProcess

from cv_active_handeye.robots.base import RobotStoppedError, Speed, StopReason
from cv_active_handeye.robots.ur import UrConfig, connect
from cv_active_handeye.robots.workspace import step_size
from cv_active_handeye.simulation.emulators import moves_after_stop

pytestmark = [pytest.mark.timeout(180), pytest.mark.skipif(os.name == "nt", reason="pauses and kills are POSIX")]
WAY_MM, SLOW = 80, 0.02  # 4 s; the link is cut after 40 %
LIMIT_S, LEFT_MM = 0.7, 10
"""Of the 48 mm that are left when the link is cut, the watchdog's time takes 14; the rest is for a busy machine."""


@pytest.fixture
def emulator(tmp_path: Path) -> Iterator[UrEmulatorProcess]:
    with UrEmulatorProcess(tmp_path, 3) as process:
        yield process


def flange(emulator: UrEmulatorProcess) -> NDArray[np.float64]:
    return emulator.link.state().T_reported


def target_of(pose: NDArray[np.float64]) -> NDArray[np.float64]:
    out = pose.copy()
    out[2, 3] += WAY_MM / 1000 if pose[2, 3] < 0.5 else -WAY_MM / 1000
    return out


def stop_conditions(emulator: UrEmulatorProcess) -> list[str]:
    return [event["reason"] for event in emulator.events() if event["kind"] == "stop_condition"]


def standing(emulator: UrEmulatorProcess) -> list[dict[str, Any]]:
    """Waits until the first motion is over; returns the ends of all."""
    deadline = time.monotonic() + 30
    while not (ends := [event for event in emulator.events() if event["kind"] == "motion_end"]):
        assert time.monotonic() < deadline
        time.sleep(0.02)
    return ends


def moving_program(emulator: UrEmulatorProcess, **settings: object) -> tuple[subprocess.Popen[str], int]:
    """A program in another process whose arm is on its way; the number of the process that ur_rtde runs in."""
    code = (
        "from cv_active_handeye.robots.ur import *\n"
        f"robot = connect(UrConfig(host={emulator.host!r}, **{settings!r}), live=True)\n"
        "target = robot.pose().T_gripper2base\n"
        f"target[2, 3] += {WAY_MM / 1000} if target[2, 3] < 0.5 else -{WAY_MM / 1000}\n"
        "print(robot._process._process.pid, flush=True)\n"
        f"robot.move_linear(target, Speed(metres_per_second={SLOW}))\n"
        "robot.close()"
    )
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    child = int(process.stdout.readline())
    while not emulator.link.state().moving:
        time.sleep(0.01)
    return process, child


@pytest.mark.parametrize("upper", [False, True])
def test_link_that_is_cut_for_good_in_a_move_leaves_an_arm_that_stands_short_of_its_target(
    emulator: UrEmulatorProcess, upper: bool
) -> None:
    emulator.link.plan_fault("silent_port@move1")
    target = target_of(flange(emulator))
    robot = connect(UrConfig(host=emulator.host, watchdog_s=LIMIT_S, upper_registers=upper), live=True)
    with pytest.raises(RobotStoppedError, match="COULD NOT BE TOLD TO STOP: press the emergency stop") as caught:
        robot.move_linear(target, Speed(metres_per_second=SLOW))
    assert caught.value.reason in (StopReason.STALE_POSE, StopReason.LINK_LOST)
    assert [end["arrived"] for end in standing(emulator)] == [False]
    assert 1000 * step_size(flange(emulator), target)[0] > LEFT_MM
    assert stop_conditions(emulator) == ["link lost", "watchdog"]
    assert "stop" not in emulator.commands()
    assert not moves_after_stop(emulator.events())
    emulator.link.clear()
    robot.close()


def test_program_killed_with_the_process_beside_it_leaves_an_arm_that_stands_short_of_its_target(
    emulator: UrEmulatorProcess,
) -> None:
    target = target_of(flange(emulator))
    process, child = moving_program(emulator, watchdog_s=LIMIT_S)
    os.kill(process.pid, signal.SIGSTOP)  # so that it cannot stop the arm in another way
    for killed in (child, process.pid):
        os.kill(killed, signal.SIGKILL)
    process.communicate()
    assert [end["arrived"] for end in standing(emulator)] == [False]
    assert 1000 * step_size(flange(emulator), target)[0] > LEFT_MM
    assert stop_conditions(emulator) == ["watchdog"]
    assert not {"stop", "stopL", "stopScript"} & set(emulator.commands())


def test_pauses_of_both_processes_within_the_limits_stop_nothing(emulator: UrEmulatorProcess) -> None:
    """Pauses of 1.3 s: longer than a clock may stand (1 s), shorter than the watchdog's time (4 s)."""
    target = target_of(flange(emulator))
    process, child = moving_program(emulator, freshness_s=1.0, watchdog_s=4.0)
    for number, paused in enumerate(((child,), (process.pid,), (process.pid, child))):
        for one in paused:
            os.kill(one, signal.SIGSTOP)
        time.sleep(1.3)
        for one in paused[:: -1 if number % 2 else 1]:
            os.kill(one, signal.SIGCONT)
        time.sleep(0.1)
    _, errors = process.communicate(timeout=60)
    assert (process.returncode, errors) == (0, "")
    assert [end["arrived"] for end in standing(emulator)] == [True]
    assert 1000 * step_size(flange(emulator), target)[0] < 0.1
    assert stop_conditions(emulator) == []


def test_pause_beyond_the_watchdogs_time_stops_the_arm_and_is_named(emulator: UrEmulatorProcess) -> None:
    process, child = moving_program(emulator, freshness_s=1.0, watchdog_s=LIMIT_S)
    for one in (process.pid, child):
        os.kill(one, signal.SIGSTOP)
    assert [end["arrived"] for end in standing(emulator)] == [False]
    for one in (process.pid, child):
        os.kill(one, signal.SIGCONT)
    _, errors = process.communicate(timeout=60)
    assert "program stopped: " in errors
    assert "heard nothing of this computer" in errors
    assert stop_conditions(emulator) == ["watchdog"]


def test_watchdog_is_set_before_every_move_and_can_be_left_out(emulator: UrEmulatorProcess) -> None:
    start = flange(emulator)
    near = start.copy()
    near[2, 3] += 0.005
    for watchdog_s in (2.5, None):
        with connect(UrConfig(host=emulator.host, freshness_s=1.0, watchdog_s=watchdog_s), live=True) as robot:
            for target in (near, start):
                robot.move_linear(target, Speed(metres_per_second=0.25, metres_per_second2=1.0))
    named = [e for e in emulator.events() if e["kind"] == "command" and e["name"] in ("setWatchdog", "moveL")]
    assert [event["name"] for event in named] == ["setWatchdog", "moveL"] * 2 + ["moveL"] * 2
    assert [event["args"] for event in named if event["name"] == "setWatchdog"] == [[0.4], [0.4]]
