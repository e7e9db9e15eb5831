# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Every move of a plan checked before the first one is made; what a capture without --live ends with."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..files import FileFormatError
from ..plan_file import Plan
from ..robots.base import MoveRefusedError, Speed
from ..robots.guard import GuardedRobot
from ..robots.straight_move import StraightMove
from ..robots.workspace import step_size

TURN_RADIUS = 0.25
"""Metres: a controller turns the flange about as fast as a point this far from it may move."""


@dataclass(frozen=True)
class PlannedMove:
    """The straight way to one stop: length (m), angle (deg), and about how long it takes (s)."""

    stop: int
    length: float
    angle: float
    seconds: float


def check_plan(robot: GuardedRobot, plan: Plan, first: int = 0) -> list[PlannedMove]:
    """Checks all ways from where the robot stands now, through the stops of `plan` from number `first` on.

    Nothing moves. MoveRefusedError names the stop and what is in the way; FileFormatError: a plan for another robot.
    """
    if plan.model != robot.robot.model:
        raise FileFormatError(f"plan: was made for {plan.robot}, this is {robot.robot.name}")
    now = robot.pose()
    pose, joints = now.T_gripper2base, now.joints if robot.robot.model is not None else None
    moves = []
    for i, stop in enumerate(plan.stops[first:], start=first):
        target = stop.T_gripper2base
        try:
            joints = robot.check_way(pose, joints, target)
            robot.robot.check_reachable(target)
        except MoveRefusedError as error:
            raise MoveRefusedError(f"stop {i} of {len(plan.stops)}: {error}") from error
        length, angle = step_size(pose, target)
        moves.append(PlannedMove(i, length, angle, motor_time(length, angle, robot.speed)))
        pose = target
    return moves


def note_of(plan: Plan) -> str | None:
    """What a person should know of a plan before it is captured; None where there is nothing to say."""
    first = plan.stops[0].T_gripper2base
    if all(StraightMove(first, stop.T_gripper2base).remaining(first) is None for stop in plan.stops):
        return f"nothing can be calibrated from this plan: its stops ({len(plan.stops)}) are all one pose; plan again"
    return None


def motor_time(length: float, angle_deg: float, speed: Speed) -> float:
    """Seconds of a straight move with a trapezoidal profile; turns count at `TURN_RADIUS`."""
    return speed.seconds(max(length, math.radians(angle_deg) * TURN_RADIUS))
