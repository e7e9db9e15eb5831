# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Moves are checked and timed before they are made; stops to verify with lie between those of a plan."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.scripted_robot import BOX, ScriptedRobot, at

from cv_active_handeye.files import FileFormatError
from cv_active_handeye.plan_file import Plan, PlannedPose, PlannedStop
from cv_active_handeye.robots.base import MoveRefusedError, Speed
from cv_active_handeye.robots.guard import GuardedRobot
from cv_active_handeye.robots.workspace import Box, half_way, step_size
from cv_active_handeye.workflow.check_stops import CHECK_STOPS, check_plan_of
from cv_active_handeye.workflow.dry_run import check_plan, motor_time, note_of
from cv_active_handeye.workflow.reporter import InsufficientDataError


def turned(x_mm: float, deg: float) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    pose = at(x_mm, 20 * deg / 10)
    pose[:3, :3] = Rotation.from_euler("xyz", [deg, -deg / 2, deg], degrees=True).as_matrix()
    return pose


def some_plan(model: str | None = None) -> Plan:
    poses = [turned(20 * i, 8 * (i // 2)) for i in range(8)]
    stops = [
        PlannedStop(R_gripper2base=T[:3, :3], t_gripper2base=T[:3, 3], group=i // 2) for i, T in enumerate(poses)
    ]
    start = PlannedPose(R_gripper2base=np.eye(3), t_gripper2base=np.zeros(3))
    return Plan(robot="scripted", model=model, start=start, workspace=BOX, stops=tuple(stops))


def guarded(robot: ScriptedRobot, plan: Plan) -> GuardedRobot:
    return GuardedRobot(robot, plan.workspace, Speed(), lambda kind, **said: None)


def test_moves_are_listed_with_length_angle_and_time_and_nothing_moves() -> None:
    robot, plan = ScriptedRobot(live=False), some_plan()
    moves = check_plan(guarded(robot, plan), plan)
    assert [move.stop for move in moves] == list(range(8))
    poses = [np.eye(4), *(stop.T_gripper2base for stop in plan.stops)]
    for move, a, b in zip(moves, poses[:-1], poses[1:], strict=True):
        assert (move.length, move.angle) == step_size(a, b)
        assert move.seconds == motor_time(move.length, move.angle, Speed())
    assert "move_linear" not in robot.calls


def test_plan_whose_stops_are_all_one_pose_is_noted_and_any_other_is_not() -> None:
    plan = some_plan()
    assert note_of(plan) is None
    one = plan.model_copy(update={"stops": plan.stops[:1] * 5})
    note = note_of(one)
    assert note is not None
    assert "its stops (5) are all one pose; plan again" in note


def test_motor_time_is_that_of_a_trapezoid() -> None:
    speed = Speed(metres_per_second=0.05, metres_per_second2=0.2)
    t = np.linspace(0, 2.25, 200001)
    v = np.minimum(np.minimum(0.2 * t, 0.05), 0.2 * (2.25 - t))
    way = float(np.sum((v[1:] + v[:-1]) / 2) * (t[1] - t[0]))
    assert motor_time(way, 0.0, speed) == pytest.approx(2.25, abs=1e-4)
    assert motor_time(0.002, 0.0, speed) == pytest.approx(2 * np.sqrt(0.002 / 0.2))
    assert motor_time(0.0, 90.0, speed) > motor_time(0.0, 45.0, speed) > 1.0


def test_plan_for_another_arm_is_refused() -> None:
    with pytest.raises(FileFormatError, match="was made for scripted"):
        check_plan(guarded(ScriptedRobot(), some_plan()), some_plan("ur5e"))


def test_refused_stop_is_named() -> None:
    wall = Box(lower_mm=(90, -300, -300), upper_mm=(110, 300, 300))
    plan = some_plan()
    plan = plan.model_copy(update={"workspace": BOX.model_copy(update={"no_go": (wall,)})})
    with pytest.raises(MoveRefusedError, match=r"stop 5 of 8: workspace: the flange .* inside the no-go box"):
        check_plan(guarded(ScriptedRobot(), plan), plan)


def test_half_way_is_in_the_middle_of_translation_and_turn() -> None:
    a, b = turned(10, 5), turned(90, 40)
    middle = half_way(a, b)
    np.testing.assert_allclose(middle[:3, 3], (a[:3, 3] + b[:3, 3]) / 2, atol=1e-12)
    assert step_size(a, middle)[1] == pytest.approx(step_size(a, b)[1] / 2, abs=1e-6)
    assert step_size(middle, b)[1] == pytest.approx(step_size(a, b)[1] / 2, abs=1e-6)
    np.testing.assert_allclose(half_way(a, a), a, atol=1e-12)


def test_stops_to_verify_with_are_new_and_of_different_orientations() -> None:
    plan = some_plan()
    checks = check_plan_of(plan, guarded(ScriptedRobot(), plan))
    assert len(checks.stops) == CHECK_STOPS
    planned = [stop.T_gripper2base for stop in plan.stops]
    for stop in checks.stops:
        assert min(max(step_size(stop.T_gripper2base, T)) for T in planned) > 0.001
        assert not stop.laser
    turns = [step_size(checks.stops[0].T_gripper2base, stop.T_gripper2base)[1] for stop in checks.stops[1:]]
    assert max(turns) > 1


def test_too_few_stops_to_verify_with_are_told() -> None:
    plan = some_plan()
    narrow = Box(lower_mm=(-1, -1, -1), upper_mm=(1, 1, 1))
    plan = plan.model_copy(update={"workspace": BOX.model_copy(update={"box": narrow})})
    with pytest.raises(InsufficientDataError, match="3 stops are needed to verify it, 0 can be reached"):
        check_plan_of(plan, guarded(ScriptedRobot(), plan))
