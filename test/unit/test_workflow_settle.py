# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""An arm stands still when it arrived, says so, and its fresh readings agree for a while; else it is given up."""

from __future__ import annotations

import time

import numpy as np
import pytest
from support.scripted_robot import BOX, ScriptedRobot, at

from cv_active_handeye.robots.base import RobotStoppedError, Speed, StopReason
from cv_active_handeye.robots.guard import GuardedRobot
from cv_active_handeye.workflow.settle import SettleSettings, differs, settle

QUICK = SettleSettings(dwell_s=0.03, deadline_s=0.4)


def guarded(robot: ScriptedRobot) -> GuardedRobot:
    return GuardedRobot(robot, BOX, Speed(), lambda kind, **said: None)


def test_resting_arm_settles_after_the_dwell_and_the_readings() -> None:
    robot = ScriptedRobot()
    begun = time.monotonic()
    pose = settle(guarded(robot), at(0), QUICK)
    assert time.monotonic() - begun >= QUICK.dwell_s
    assert robot.clock >= QUICK.poses * 0.002
    np.testing.assert_array_equal(pose.T_gripper2base, np.eye(4))
    assert "stop" not in robot.calls


@pytest.mark.parametrize(
    ("what", "text"),
    [
        ("far", r"it is 0.200 mm and 0.0000 deg from where it should be"),
        ("unsteady", "the controller does not say steady"),
        ("shaking", r"its readings are 0.0[34][0-9] mm"),
        ("frozen", r"1 fresh readings"),
    ],
)
def test_arm_that_does_not_come_to_rest_is_given_up_with_what_was_missing(what: str, text: str) -> None:
    robot = ScriptedRobot()
    if what == "far":
        robot.T = at(0.2)
    robot.steady = what != "unsteady"

    def disturb() -> None:
        if what == "shaking":
            robot.T = at(0.04 * (round(robot.clock * 500) % 2))
        if what == "frozen":
            robot.clock = 0.0

    robot.on_pose = disturb
    guard = guarded(robot)
    with pytest.raises(RobotStoppedError, match=text) as stopped:
        settle(guard, at(0), QUICK)
    assert stopped.value.reason is StopReason.NOT_ARRIVED
    assert robot.calls[-1] == "stop"
    with pytest.raises(RobotStoppedError, match="nothing moves after a stop"):
        guard.move_to(at(1))


def test_arm_that_swings_out_settles_later() -> None:
    robot = ScriptedRobot()
    begun = time.monotonic()

    def swing() -> None:
        amplitude = 0.5 * np.exp(-(time.monotonic() - begun) / 0.02)
        robot.T = at(amplitude * np.cos(400 * time.monotonic()))

    robot.on_pose = swing
    pose = settle(guarded(robot), at(0), QUICK.model_copy(update={"deadline_s": 2.0}))
    assert time.monotonic() - begun > 0.08
    assert abs(pose.T_gripper2base[0, 3]) <= 2e-5


def test_difference_of_two_readings_is_told_in_mm_and_deg() -> None:
    robot = ScriptedRobot()
    a = robot.pose()
    robot.T = at(0.05)
    assert differs(a, robot.pose(), QUICK) == "0.050 mm and 0.0000 deg apart"
    robot.T = at(0.01)
    assert differs(a, robot.pose(), QUICK) == ""
