# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The simulated and the recorded robot behind the robot protocol."""

from __future__ import annotations

import threading
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.recordings import exact_dataset

from cv_active_handeye.files import FileFormatError
from cv_active_handeye.robots import recorded, simulated
from cv_active_handeye.robots.base import MoveRefusedError, Robot, RobotError, RobotStoppedError, Speed, StopReason
from cv_active_handeye.robots.recorded import RecordedConfig, read_poses
from cv_active_handeye.robots.simulated import SimulatedRobotConfig
from cv_active_handeye.robots.workspace import step_size

pytestmark = pytest.mark.timeout(60)
FAST = Speed(metres_per_second=0.25, metres_per_second2=1.0)


def sim(robot: str = "ur5e", live: bool = True, speedup: float = 50) -> simulated.SimulatedRobot:
    return simulated.connect(SimulatedRobotConfig.model_validate({"robot": robot, "speedup": speedup}), live=live)


@pytest.mark.parametrize("robot", ["ur5e", "denso_vp6242"])
def test_simulated_robot_moves_settles_and_switches(robot: str) -> None:
    with sim(robot) as arm:
        assert isinstance(arm, Robot)
        assert arm.model == robot
        target = arm.pose().T_gripper2base
        target[:3, 3] += 0.01, -0.01, 0.02
        arm.check_reachable(target)
        arm.move_linear(target, FAST)
        assert step_size(arm.pose().T_gripper2base, target)[0] < 0.05e-3
        arm.set_output(1, True)
        assert arm.arm.outputs[1]
        with pytest.raises(RobotError, match="given 9"):
            arm.set_output(9, True)


def test_simulated_robot_refuses_when_not_live_and_out_of_reach() -> None:
    far = np.eye(4)
    far[:3, 3] = 3.0
    with sim(live=False) as arm, pytest.raises(MoveRefusedError, match="not opened to be moved"):
        arm.move_linear(arm.pose().T_gripper2base, FAST)
    with sim() as arm:
        with pytest.raises(MoveRefusedError, match="reach"):
            arm.check_reachable(far)
        with pytest.raises(MoveRefusedError):
            arm.move_linear(far, FAST)
        assert not arm.arm.log.of_kind("motion_begin")


@pytest.mark.parametrize(
    ("fault", "reason"),
    [("protective_stop", StopReason.PROTECTIVE_STOP), ("emergency_stop", StopReason.EMERGENCY_STOP)],
)
def test_simulated_robot_names_a_stop_and_moves_no_more(fault: str, reason: StopReason) -> None:
    with sim() as arm:
        target = arm.pose().T_gripper2base
        target[2, 3] += 0.05
        arm.arm.faults.set(fault)
        for _ in range(2):
            with pytest.raises(RobotStoppedError) as caught:
                arm.move_linear(target, FAST)
            assert caught.value.reason is reason
        assert not arm.arm.log.of_kind("motion_begin")


def test_simulated_robot_that_does_not_arrive_says_so() -> None:
    with sim() as arm:
        arm.arm.faults.set("pose_noise", 2.0)
        target = arm.arm.arm.forward(arm.arm.joints)
        target[2, 3] += 0.01
        with pytest.raises(RobotStoppedError, match=r"not arrived: .* mm"):
            arm.move_linear(target, FAST)


def test_simulated_robot_stops_from_another_thread() -> None:
    with sim(speedup=1) as arm:
        start = arm.pose().T_gripper2base
        target = start.copy()
        target[2, 3] += 0.08
        threading.Timer(0.2, arm.stop).start()
        with pytest.raises(RobotStoppedError) as caught:
            arm.move_linear(target, Speed())
        assert caught.value.reason is StopReason.OPERATOR
        assert step_size(start, arm.pose().T_gripper2base)[0] < 0.03


def test_recorded_robot_plays_a_data_set_in_its_order_only(tmp_path: Path) -> None:
    dataset = exact_dataset(tmp_path / "set")
    with recorded.connect(RecordedConfig(path=tmp_path / "set"), live=True) as robot:
        assert isinstance(robot, Robot)
        poses = []
        for R, t in zip(dataset.R_gripper2base, dataset.t_gripper2base, strict=True):
            T = np.eye(4)
            T[:3, :3], T[:3, 3] = R, t
            poses.append(T)
        np.testing.assert_array_equal(robot.pose().T_gripper2base, poses[0])
        with pytest.raises(MoveRefusedError, match="next recorded pose"):
            robot.move_linear(poses[2], FAST)
        for pose in poses[1:]:
            robot.check_reachable(pose)
            robot.move_linear(pose, FAST)
            np.testing.assert_array_equal(robot.pose().T_gripper2base, pose)
        with pytest.raises(MoveRefusedError, match=f"ends after {len(poses)} poses"):
            robot.move_linear(poses[0], FAST)
        with pytest.raises(MoveRefusedError, match="is not recorded"):
            robot.check_reachable(np.eye(4))
        robot.stop()
        with pytest.raises(RobotStoppedError):
            robot.move_linear(poses[0], FAST)


@pytest.mark.parametrize("quaternion", [False, True])
def test_read_poses_takes_rotation_vectors_and_quaternions(tmp_path: Path, quaternion: bool) -> None:
    rng = np.random.default_rng(5)
    rotations, t = Rotation.from_rotvec(rng.uniform(-2, 2, (9, 3))), rng.uniform(-400, 400, (9, 3))
    columns = ["qw", "qx", "qy", "qz"] if quaternion else ["rx", "ry", "rz"]
    turns = rotations.as_quat()[:, [3, 0, 1, 2]] if quaternion else rotations.as_rotvec()
    rows = [",".join(["name", *columns, "z", "y", "x"])]
    rows += [",".join(["p", *map(repr, map(float, [*turn, *p[::-1]]))]) for turn, p in zip(turns, t, strict=True)]
    (tmp_path / "poses.csv").write_text("\n".join(rows) + "\n")
    poses = read_poses(tmp_path / "poses.csv")
    np.testing.assert_allclose(poses[:, :3, :3], rotations.as_matrix(), atol=1e-12)
    np.testing.assert_allclose(poses[:, :3, 3], t / 1000, atol=1e-12)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x,y,z\n1,2,3\n", "has no rx"),
        ("x,y,z,rx,ry,rz\n", "holds no poses"),
        ("x,y,z,rx,ry,rz\n1,2,three,0,0,0\n", "row 0: column 'z': needs a finite number, given 'three'"),
        ("x,y,z,rx,ry,rz\n1,2,3,0,0,0\n1,2,nan,0,0,0\n", "row 1: column 'z'"),
        ("x,y,z,qw,qx,qy,qz\n1,2,3,1,1,0,0\n", "quaternion's length is 1.4142"),
    ],
)
def test_recorded_robot_names_row_and_column_of_a_bad_file(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "poses.csv").write_text(text)
    with pytest.raises(FileFormatError, match=message):
        recorded.connect(RecordedConfig(path=tmp_path / "poses.csv"), live=False)
