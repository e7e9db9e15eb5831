# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The DENSO driver on the emulated controller: what it reads, moves, refuses and restores."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError
from support.denso_emulator import RawSession, emulated_denso, moved, start_of

from cv_active_handeye.robots.base import (
    MoveRefusedError,
    Robot,
    RobotError,
    RobotStoppedError,
    RobotUnavailableError,
    Speed,
)
from cv_active_handeye.robots.denso import DensoConfig, connect
from cv_active_handeye.robots.kinematics import straight_line

pytestmark = pytest.mark.timeout(60)
FAST = Speed(metres_per_second=0.25, metres_per_second2=1.0)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"controller": "rc7"}, "needs experimental_rc7 and a model"),
        ({"controller": "rc7", "experimental_rc7": True}, "needs experimental_rc7 and a model"),
        ({"model": "denso_vs060"}, "needs one of"),
        ({"external_percent": 21}, "external_percent"),
        ({"speed": 3}, "speed"),
        ({"host": ""}, "host"),
    ],
)
def test_config_that_cannot_work_is_refused_by_name(given: dict[str, Any], told: str) -> None:
    with pytest.raises(ValidationError, match=told):
        DensoConfig.model_validate({"host": "127.0.0.1", **given})


def test_robot_is_what_the_protocol_asks_for() -> None:
    with emulated_denso() as emulated, connect(emulated.config(model="denso_vp6242"), live=False) as robot:
        assert isinstance(robot, Robot)
        assert robot.name == f"DENSO RC8 at 127.0.0.1:{emulated.port}"
        assert (robot.model, robot.live) == ("denso_vp6242", False)


def test_pose_is_the_reported_one_with_the_joints_of_the_encoders_and_the_controllers_clock() -> None:
    with emulated_denso() as emulated, connect(emulated.config(), live=False) as robot:
        before, pose, after = emulated.arm.now, robot.pose(), emulated.arm.now
        np.testing.assert_allclose(pose.T_gripper2base, emulated.arm.reported_pose(), atol=1e-12)
        np.testing.assert_allclose(pose.joints, emulated.arm.joints, atol=1e-12)
        assert before - 1e-3 <= pose.controller_time <= after + 1e-3
        assert pose.controller_time < robot.pose().controller_time


def test_connection_that_is_not_live_takes_no_arm_switches_nothing_and_refuses_to_move() -> None:
    with emulated_denso() as emulated, connect(emulated.config(), live=False) as robot:
        with pytest.raises(MoveRefusedError, match="not opened to be moved"):
            robot.move_linear(start_of(robot), FAST)
        with pytest.raises(RobotError, match="live"):
            robot.set_output(1, True)
        robot.stop()
        assert emulated.commands() == ["CONTROLLER_CONNECT"]


def test_moves_arrive_in_order_and_everything_is_left_as_it_was_found() -> None:
    with emulated_denso() as emulated:
        with connect(emulated.config(), live=True) as robot:
            start = start_of(robot)
            for mm, turn in (((20, 0, 0), (0, 0, 0)), ((20, 10, 5), (0, 8, 0)), ((0, 0, 0), (0, 0, 0))):
                target = moved(start, mm, turn)
                robot.move_linear(target, FAST)
                assert np.abs(robot.pose().T_gripper2base[:3, 3] - target[:3, 3]).max() < 5e-5
            robot.set_output(3, True)
            assert emulated.arm.outputs[3]
        names = emulated.commands()
        assert names.index("TakeArm") < names.index("ExtSpeed") < names.index("Motor") < names.index("ROBOT_MOVE")
        assert [name for name in names if name in ("Motor", "GiveArm")] == ["Motor", "Motor", "GiveArm"]
        assert emulated.violations() == []
        with RawSession(emulated.port) as other:
            other.execute("TakeArm", [0, 0])


def test_motor_that_was_on_stays_on() -> None:
    with emulated_denso() as emulated:
        with RawSession(emulated.port) as before:
            before.ready()
            before.execute("GiveArm")
        with connect(emulated.config(), live=True):
            pass
        assert emulated.commands().count("Motor") == 1


def test_tool_that_is_active_is_refused_for_reading_and_put_back_after_moving() -> None:
    with emulated_denso(tool=2) as emulated:
        with pytest.raises(RobotUnavailableError, match="tool 2 is active"):
            connect(emulated.config(), live=False)
        with connect(emulated.config(), live=True) as robot:
            np.testing.assert_allclose(start_of(robot), emulated.arm.reported_pose(), atol=1e-12)
        with RawSession(emulated.port) as other:
            assert other.execute("CurTool") == 2


@pytest.mark.parametrize("live", [False, True])
def test_controller_with_other_angles_is_refused_and_given_back(live: bool) -> None:
    with emulated_denso(convention="ZYZ") as emulated:
        with pytest.raises(RobotUnavailableError, match=r"P2T.*angles mean something else"):
            connect(emulated.config(), live=live)
        assert emulated.arm.log.of_kind("motion_begin") == []
        if live:
            assert emulated.commands()[-2:] == ["Motor", "GiveArm"]


def test_rc7_moves_by_p_type_and_is_checked_by_its_model() -> None:
    options = {"controller": "rc7", "experimental_rc7": True}
    with emulated_denso(controller="rc7") as emulated:
        with connect(emulated.config(**options, model="denso_vp6242"), live=True) as robot:
            target = moved(start_of(robot), (10, 0, 0), (0, 5, 0))
            robot.move_linear(target, FAST)
            assert np.abs(start_of(robot) - target).max() < 5e-5
            robot.check_reachable(np.eye(4))  # cannot be asked
        with pytest.raises(RobotUnavailableError, match=r"CurPos is \d+ mm and [\d.]+ deg away from what ur5e"):
            connect(emulated.config(**options, model="ur5e"), live=False)


def test_out_of_range_is_refused_before_anything_moves_and_is_no_stop() -> None:
    with emulated_denso() as emulated, connect(emulated.config(), live=True) as robot:
        start = start_of(robot)
        with pytest.raises(MoveRefusedError, match=r"\(\d+, 1130, \d+\) mm is out of range \(OutRange: 63\)"):
            robot.move_linear(moved(start, (0, 1000, 0)), FAST)
        assert emulated.arm.log.of_kind("motion_begin") == []
        robot.move_linear(moved(start, (0, 5, 0)), FAST)


def test_commanded_speed_is_not_exceeded_and_one_below_the_controllers_least_is_refused() -> None:
    with emulated_denso(speedup=1.0) as emulated, connect(emulated.config(), live=True) as robot:
        start = start_of(robot)
        speed = Speed(metres_per_second=0.04, metres_per_second2=0.5)
        began = emulated.arm.now
        robot.move_linear(moved(start, (0, 20, 0)), speed)
        assert 0.020 / 0.04 < emulated.arm.now - began < 2.0
        with pytest.raises(MoveRefusedError, match=r"needs 0\.012 m/s or more"):
            robot.move_linear(start, Speed(metres_per_second=0.01))


@pytest.mark.parametrize(
    ("fault", "told"),
    [
        ("emergency_stop", "emergency stop"),
        ("protective_stop", "protective stop after a collision"),
        ("not_remote", "manual mode"),
        ("silent_port", "silent"),
    ],
)
def test_live_connection_to_a_controller_in_trouble_is_refused_with_the_trouble(fault: str, told: str) -> None:
    with emulated_denso() as emulated:
        emulated.arm.faults.set(fault)
        began = time.monotonic()
        with pytest.raises(RobotUnavailableError, match=told):
            connect(emulated.config(), live=True)
        assert time.monotonic() - began < 5.0
        assert "Motor" not in emulated.commands()


def test_arm_that_another_client_has_is_refused() -> None:
    with emulated_denso() as emulated, RawSession(emulated.port) as other:
        other.execute("TakeArm", [0, 0])
        with pytest.raises(RobotUnavailableError, match=r"TakeArm: E_ACCESSDENIED.*no other client with the arm"):
            connect(emulated.config(), live=True)


def test_controller_of_another_generation_is_told() -> None:
    with emulated_denso(controller="rc9") as emulated, pytest.raises(RobotUnavailableError, match="Is it a RC8"):
        connect(emulated.config(), live=False)


def test_is_steady_waits_for_the_arm_to_settle() -> None:
    with emulated_denso(speedup=5.0) as emulated, connect(emulated.config(), live=True) as robot:
        assert robot.is_steady()
        emulated.arm.faults.set("slow_settling", 2.0)
        robot.move_linear(moved(start_of(robot), (0, 5, 0)), FAST)
        assert not robot.is_steady()
        time.sleep(0.5)
        assert robot.is_steady()


def test_output_that_does_not_exist_is_an_error_and_no_stop() -> None:
    with emulated_denso() as emulated, connect(emulated.config(), live=True) as robot:
        with pytest.raises(RobotError, match="output 99 cannot be switched") as caught:
            robot.set_output(99, True)
        assert not isinstance(caught.value, RobotStoppedError)
        robot.move_linear(moved(start_of(robot), (0, 2, 0)), FAST)


def test_half_turn_orientations_are_reached_along_the_line() -> None:
    """Down-looking flanges have RX = +-180, where the sign of the angles changes on the way."""
    with emulated_denso(speedup=100.0) as emulated, connect(emulated.config(), live=True) as robot:
        down = start_of(robot)
        down[:3, :3] = np.diag([1.0, -1.0, -1.0])
        robot.move_linear(moved(down, (0, 0, 0), (3, 0, 0)), FAST)
        for turn in ((-3, 0, 0), (0, 3, 0), (0, 0, 3)):
            target = moved(down, (0, 0, 0), turn)
            assert len(straight_line(start_of(robot), target, 0.005, 1.0)) < 9
            robot.move_linear(target, FAST)
            assert np.abs(start_of(robot)[:3, :3] - target[:3, :3]).max() < 1e-4
