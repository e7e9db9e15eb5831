# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Stops of their own for verifying a fresh calibration: between those of its plan, where arm and view are safe."""

from __future__ import annotations

from ..plan_file import Plan, PlannedPose, PlannedStop
from ..robots.base import MoveRefusedError
from ..robots.guard import GuardedRobot
from ..robots.workspace import half_way
from .reporter import InsufficientDataError
from .verify import MIN_VIEWS

CHECK_STOPS = 5


def check_plan_of(plan: Plan, robot: GuardedRobot) -> Plan:
    """Returns a plan of `CHECK_STOPS` stops half-way between stops of different groups, each reached from the last.

    Ways that are refused are left out; `InsufficientDataError` where fewer remain than `verify` needs.
    """
    now = robot.pose()
    pose, joints = now.T_gripper2base, now.joints if robot.robot.model is not None else None
    stops: list[PlannedStop] = []
    for a, b in _pairs(plan):
        target = half_way(a.T_gripper2base, b.T_gripper2base)
        try:
            joints = robot.check_way(pose, joints, target)
        except MoveRefusedError:
            continue
        pose = target
        stops.append(
            PlannedStop(R_gripper2base=target[:3, :3], t_gripper2base=target[:3, 3], group=len(stops), laser=False)
        )
        if len(stops) == CHECK_STOPS:
            break
    if len(stops) < MIN_VIEWS:
        raise InsufficientDataError(f"plan: {MIN_VIEWS} stops are needed to verify it, {len(stops)} can be reached")
    start = PlannedPose(R_gripper2base=now.T_gripper2base[:3, :3], t_gripper2base=now.T_gripper2base[:3, 3])
    return plan.model_copy(update={"start": start, "stops": tuple(stops), "predictions": ()})


def _pairs(plan: Plan) -> list[tuple[PlannedStop, PlannedStop]]:
    """Stops of different groups, the farthest apart in the plan first, so that all its orientations are mixed."""
    stops, count = plan.stops, len(plan.stops)
    found = []
    for distance in range(count // 2, count):
        found += [(stops[i], stops[i + distance]) for i in range(count - distance)]
    return [(a, b) for a, b in found if a.group != b.group]
