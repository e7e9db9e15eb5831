# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What the driver concludes from the packages of a UR controller."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from cv_active_handeye.robots.base import RobotStoppedError, Speed, StopReason
from cv_active_handeye.robots.straight_move import StraightMove
from cv_active_handeye.robots.ur_watch import Freshness, MoveWatch, UrState, check_state, safety_stop

Array = NDArray[np.float64]
SPEED = Speed()


def pose(x_mm: float = 0.0, y_mm: float = 0.0, turn_deg: float = 0.0) -> Array:
    T = np.eye(4)
    T[:3, :3] = Rotation.from_euler("z", turn_deg, degrees=True).as_matrix()
    T[:3, 3] = x_mm / 1000, y_mm / 1000, 0.5
    return T


GOOD = UrState(1.0, pose(), np.zeros(6), 1, 2, 7, 0, 1.0, True, True)


def watch() -> MoveWatch:
    return MoveWatch(StraightMove(pose(), pose(50)), SPEED, began=100.0, fresh_s=0.2)


def reason_of(state: UrState, now: float = 100.1, using: MoveWatch | None = None) -> StopReason:
    with pytest.raises(RobotStoppedError) as caught:
        (using or watch()).arrived(state, now)
    return caught.value.reason


@pytest.mark.parametrize("what", ["pose", "joints"])
def test_package_without_numbers_is_an_error_of_the_controller(what: str) -> None:
    said = {**vars(GOOD), "pose": [0.1, 0.2, 0.3, 0.0, 0.0, 0.0], "joints": [0.0] * 6}
    assert UrState.of(said).pose[0, 3] == 0.1
    with pytest.raises(RobotStoppedError, match=f"controller error: {what}: needs six finite numbers, .*nan"):
        UrState.of({**said, what: [float("nan")] * 6})


@pytest.mark.parametrize(
    ("bit", "reason"),
    [
        (2, StopReason.PROTECTIVE_STOP),
        (3, StopReason.CONTROLLER_ERROR),
        (4, StopReason.SAFEGUARD_STOP),
        (5, StopReason.EMERGENCY_STOP),
        (6, StopReason.EMERGENCY_STOP),
        (7, StopReason.EMERGENCY_STOP),
        (8, StopReason.CONTROLLER_ERROR),
        (9, StopReason.CONTROLLER_ERROR),
        (10, StopReason.CONTROLLER_ERROR),
    ],
)
def test_safety_bit_stops_a_move_with_its_reason(bit: int, reason: StopReason) -> None:
    assert reason_of(replace(GOOD, safety_bits=1 | 1 << bit)) is reason


def test_normal_and_reduced_mode_are_no_reason_to_stop() -> None:
    assert safety_stop(1) is None
    assert safety_stop(3) is None
    check_state(replace(GOOD, safety_bits=2), live=True)


def test_emergency_stop_is_named_before_the_protective_stop_that_comes_with_it() -> None:
    assert reason_of(replace(GOOD, safety_bits=1 << 2 | 1 << 7 | 1 << 10)) is StopReason.EMERGENCY_STOP


def test_lost_link_wrong_mode_and_ended_program_stop_a_move() -> None:
    assert reason_of(replace(GOOD, connected=False)) is StopReason.LINK_LOST
    assert reason_of(replace(GOOD, robot_mode=5)) is StopReason.CONTROLLER_ERROR
    assert reason_of(replace(GOOD, runtime_state=1)) is StopReason.PROGRAM_STOPPED
    check_state(replace(GOOD, runtime_state=1), live=False)


def test_clock_may_stand_for_0_2_s_and_no_longer() -> None:
    fresh = Freshness(0.2)
    for i in range(21):
        fresh.check(GOOD, 10 + 0.01 * i)
    with pytest.raises(RobotStoppedError, match=r"stale pose: the controller's clock has stood still for 0\.21 s"):
        fresh.check(GOOD, 10.21)
    fresh.check(replace(GOOD, time=1.008), 10.3)
    for i in range(20):
        fresh.check(replace(GOOD, time=1.008), 10.3 + 0.01 * i)


def test_pause_of_this_process_is_no_proof_that_the_clock_stands() -> None:
    fresh = Freshness(0.2)
    fresh.check(GOOD, 10.0)
    fresh.check(GOOD, 15.0)
    fresh.check(replace(GOOD, time=6.0), 15.01)
    for i in range(20):
        fresh.check(replace(GOOD, time=6.0), 15.02 + 0.01 * i)
    with pytest.raises(RobotStoppedError, match="stood still"):
        fresh.check(replace(GOOD, time=6.0), 15.22)


@pytest.mark.parametrize("where", [pose(25, 2.1), pose(-2.1), pose(52.2), pose(25, 0, 3)])
def test_arm_beside_its_line_is_off_the_path(where: Array) -> None:
    assert reason_of(replace(GOOD, pose=where)) is StopReason.OFF_PATH


def test_arm_on_its_line_goes_on_until_it_stands_at_the_end() -> None:
    w = watch()
    for i, x in enumerate(np.linspace(0, 50, 20)):
        assert not w.arrived(replace(GOOD, time=1 + i / 100, pose=pose(x, 0.5)), 100 + i / 100)
    assert not w.arrived(replace(GOOD, time=2.0, pose=pose(50)), 100.5)
    assert w.arrived(replace(GOOD, time=2.1, pose=pose(50.04), moving=False), 100.6)


def test_motion_that_ends_elsewhere_has_not_arrived_after_a_second() -> None:
    w = watch()
    beside = replace(GOOD, pose=pose(49.9), moving=False)
    for i in range(101):
        assert not w.arrived(replace(beside, time=1 + i / 100), 100 + i / 100)
    assert reason_of(replace(beside, time=3.0), 101.02, w) is StopReason.NOT_ARRIVED


def test_pause_between_the_end_of_the_motion_and_the_last_pose_is_waited_for() -> None:
    w = watch()
    assert not w.arrived(replace(GOOD, pose=pose(49.9), moving=False), 100.0)
    assert not w.arrived(replace(GOOD, pose=pose(49.9), moving=False), 103.0)
    assert w.arrived(replace(GOOD, time=4.0, pose=pose(50), moving=False), 103.01)


def test_move_that_takes_too_long_is_stopped_and_names_the_speed_slider() -> None:
    with pytest.raises(RobotStoppedError, match=r"deadline: .*speed slider is at 5 %"):
        watch().arrived(
            replace(GOOD, speed_scaling=0.05), 100 + StraightMove(pose(), pose(50)).deadline_s(0.05, 0.2) + 0.01
        )
