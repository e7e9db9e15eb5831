# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Nothing moves that is not allowed to, and nothing moves after a stop."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.scripted_robot import BOX, ScriptedRobot, at

from cv_active_handeye.robots import kinematics
from cv_active_handeye.robots.base import MoveRefusedError, RobotStoppedError, Speed, StopReason
from cv_active_handeye.robots.guard import GuardedRobot
from cv_active_handeye.robots.workspace import Box, Workspace, step_size


class Events:
    def __init__(self) -> None:
        self.kinds: list[str] = []

    def __call__(self, kind: str, **said: Any) -> None:
        self.kinds.append(kind)


def guarded(robot: ScriptedRobot, workspace: Workspace = BOX) -> GuardedRobot:
    return GuardedRobot(robot, workspace, Speed(), Events())


def test_move_without_live_is_refused_and_nothing_is_sent() -> None:
    robot = ScriptedRobot(live=False)
    with pytest.raises(MoveRefusedError, match="opened to look only; moving needs --live"):
        guarded(robot).move_to(at(50))
    assert robot.calls == []


def test_long_way_is_made_in_moves_within_the_caps() -> None:
    robot = ScriptedRobot()
    target = at(250, -120, 30)
    target[:3, :3] = Rotation.from_rotvec(np.radians([10, 70, -20])).as_matrix()
    guarded(robot).move_to(target)
    poses = [np.eye(4), *robot.targets]
    steps = [step_size(a, b) for a, b in pairwise(poses)]
    assert max(1000 * length for length, _ in steps) <= BOX.max_step_mm
    assert max(angle for _, angle in steps) <= BOX.max_step_deg
    assert len(steps) == 3
    np.testing.assert_allclose(robot.targets[-1], target, atol=1e-12)
    # every pose on the way lies on the straight line
    for pose in robot.targets:
        assert np.linalg.norm(np.cross(pose[:3, 3], target[:3, 3])) < 1e-9


def test_way_through_a_no_go_box_is_refused_before_anything_moves() -> None:
    wall = Box(lower_mm=(100, -50, -50), upper_mm=(120, 50, 50))
    robot = ScriptedRobot()
    with pytest.raises(MoveRefusedError, match=r"the flange would be at \(100, 0, 0\) mm, inside the no-go box"):
        guarded(robot, BOX.model_copy(update={"no_go": (wall,)})).move_to(at(200))
    assert "move_linear" not in robot.calls


def test_turn_whose_sense_is_not_certain_is_refused() -> None:
    robot, target = ScriptedRobot(), at(30)
    target[:3, :3] = Rotation.from_euler("z", 179, degrees=True).as_matrix()
    with pytest.raises(MoveRefusedError, match=r"may turn by 150 deg.* this one turns by 179.0 deg"):
        guarded(robot).move_to(target)
    assert robot.targets == []
    target[:3, :3] = Rotation.from_euler("z", 149, degrees=True).as_matrix()
    guarded(robot).move_to(target)
    np.testing.assert_allclose(robot.T, target, atol=1e-12)


def test_tool_point_that_leaves_the_box_is_refused_though_the_flange_stays_inside() -> None:
    robot = ScriptedRobot()
    camera = BOX.model_copy(update={"tool_points_mm": ((0.0, 0.0, 100.0),)})
    guarded(robot, camera).move_to(at(0, 0, 390))
    with pytest.raises(MoveRefusedError, match=r"the tool's point \(0.0, 0.0, 100.0\) mm would be at \(0, 0, 50"):
        guarded(robot, camera).move_to(at(0, 0, 410))


def test_single_move_beyond_a_cap_is_refused() -> None:
    with pytest.raises(MoveRefusedError, match=r"may go 100 mm and 30 deg, this one goes 100.5 mm and 0.00 deg"):
        BOX.check_step(at(0), at(100.5))
    turned = at(0)
    turned[:3, :3] = Rotation.from_euler("z", 31, degrees=True).as_matrix()
    with pytest.raises(MoveRefusedError, match=r"this one goes 0.0 mm and 31.00 deg"):
        BOX.check_step(at(0), turned)
    BOX.check_step(at(0), at(100))


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (RobotStoppedError(StopReason.PROTECTIVE_STOP, "touched something"), StopReason.PROTECTIVE_STOP),
        (KeyboardInterrupt(), StopReason.OPERATOR),
        (RuntimeError("a bug"), StopReason.CONTROLLER_ERROR),
        (OSError("no route"), StopReason.CONTROLLER_ERROR),
    ],
)
def test_nothing_moves_after_whatever_ended_a_move(error: BaseException, reason: StopReason) -> None:
    robot = ScriptedRobot()
    guard = guarded(robot)

    def fail() -> None:
        raise error

    robot.on_move = fail
    with pytest.raises(type(error)):
        guard.move_to(at(50))
    assert robot.calls[-1] == "stop"
    moves = robot.calls.count("move_linear")
    robot.on_move = lambda: None
    for _ in range(3):
        with pytest.raises(RobotStoppedError, match="nothing moves after a stop") as stopped:
            guard.move_to(at(10))
        assert stopped.value.reason is reason
    assert robot.calls.count("move_linear") == moves == 1


def test_robot_without_readings_is_given_up() -> None:
    robot = ScriptedRobot()
    guard = guarded(robot)

    def fail() -> None:
        raise RobotStoppedError(StopReason.STALE_POSE, "no reading for 0.2 s")

    robot.on_pose = fail
    with pytest.raises(RobotStoppedError, match="no reading"):
        guard.pose()
    robot.on_pose = lambda: None
    with pytest.raises(RobotStoppedError, match="nothing moves after a stop"):
        guard.move_to(at(1))


def test_arm_is_stopped_before_the_stop_is_logged() -> None:
    robot, order = ScriptedRobot(), []

    def event(kind: str, **said: Any) -> None:
        order.append((kind, list(robot.calls)))

    guard = GuardedRobot(robot, BOX, Speed(), event)
    guard.give_up(RobotStoppedError(StopReason.DEADLINE, "late"))
    assert order == [("stop_condition", ["stop"])]
    guard.give_up(RobotStoppedError(StopReason.LINK_LOST, "later"))
    assert guard.stopped is not None
    assert guard.stopped.reason is StopReason.DEADLINE


def test_leaving_the_block_by_ctrl_c_stops_and_closes() -> None:
    robot = ScriptedRobot()
    with pytest.raises(KeyboardInterrupt), guarded(robot):
        raise KeyboardInterrupt
    assert robot.calls == ["stop", "close"]


def test_refused_move_does_not_end_the_session() -> None:
    robot = ScriptedRobot()
    guard = guarded(robot)
    with pytest.raises(MoveRefusedError):
        guard.move_to(at(900))
    guard.move_to(at(90))
    np.testing.assert_array_equal(robot.T, at(90))


def test_joint_limit_on_the_way_is_refused_with_its_joint() -> None:
    robot = ScriptedRobot()
    arm_robot: Any = robot
    arm_robot.model = "denso_vp6242"
    arm = kinematics.arm("denso_vp6242")
    joints = np.radians([0.0, 10, 100, 0, 60, 0])
    start = arm.forward(joints)
    far = start.copy()
    far[0, 3] += 0.3
    wide = Workspace(box=Box(lower_mm=(-2000, -2000, -2000), upper_mm=(2000, 2000, 2000)))
    with pytest.raises(MoveRefusedError, match=r"DENSO VP-6242: .*(joint|reach|singular)"):
        guarded(robot, wide).check_way(start, joints, far)


def test_box_without_volume_is_refused() -> None:
    with pytest.raises(ValueError, match="lower_mm: needs to be below upper_mm"):
        Box(lower_mm=(0, 0, 0), upper_mm=(1, 0, 1))
