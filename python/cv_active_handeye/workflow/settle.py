# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""When an arm that arrived has come to rest, so that an image and a pose belong together."""

from __future__ import annotations

import time

from pydantic import BaseModel, ConfigDict, Field

from ..files import FloatArray
from ..robots.base import RobotPose, RobotStoppedError, StopReason
from ..robots.guard import GuardedRobot
from ..robots.workspace import step_size

_ASK_EVERY = 0.004  # seconds


class SettleSettings(BaseModel):
    """What standing still means.

    The pose is within arrival_mm and arrival_deg of the commanded one, the controller says steady, and `poses` fresh
    readings in a row stay within spread_mm and spread_deg of each other over at least dwell_s. An arm that does not
    come to rest within deadline_s is given up.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    arrival_mm: float = Field(default=0.05, gt=0, le=5)
    arrival_deg: float = Field(default=0.01, gt=0, le=1)
    spread_mm: float = Field(default=0.02, gt=0, le=1)
    spread_deg: float = Field(default=0.005, gt=0, le=1)
    poses: int = Field(default=5, ge=2, le=1000)
    dwell_s: float = Field(default=0.3, ge=0, le=60)
    deadline_s: float = Field(default=10.0, gt=0, le=300)


def settle(robot: GuardedRobot, target: FloatArray, settings: SettleSettings) -> RobotPose:
    """Waits until the arm rests at the flange pose `target` (4, 4) and returns its last reading.

    Where it does not within the deadline, the robot is given up: RobotStoppedError (NOT_ARRIVED) says what was missing.
    """
    begun = time.monotonic()
    still: list[RobotPose] = []
    missing = "no reading"
    while time.monotonic() - begun <= settings.deadline_s:
        still, missing = _judged(robot, target, still, settings)
        if not missing:
            return still[-1]
        time.sleep(_ASK_EVERY)
    error = RobotStoppedError(
        StopReason.NOT_ARRIVED, f"did not come to rest within {settings.deadline_s:g} s after a move: {missing}"
    )
    robot.give_up(error)
    raise error


def differs(a: RobotPose, b: RobotPose, settings: SettleSettings) -> str:
    """Says by how much two readings differ where that is more than standing still allows, else an empty text."""
    length, angle = step_size(a.T_gripper2base, b.T_gripper2base)
    if 1000 * length <= settings.spread_mm and angle <= settings.spread_deg:
        return ""
    return f"{1000 * length:.3f} mm and {angle:.4f} deg apart"


def _judged(
    robot: GuardedRobot, target: FloatArray, still: list[RobotPose], settings: SettleSettings
) -> tuple[list[RobotPose], str]:
    """The readings that agree with the newest one, and what is missing (empty: nothing)."""
    now = robot.pose()
    length, angle = step_size(now.T_gripper2base, target)
    if 1000 * length > settings.arrival_mm or angle > settings.arrival_deg:
        return [], f"it is {1000 * length:.3f} mm and {angle:.4f} deg from where it should be"
    if not robot.is_steady():
        return [], "the controller does not say steady"
    fresh = not still or now.controller_time > still[-1].controller_time
    agreeing = [pose for pose in still if not differs(pose, now, settings)]
    if len(agreeing) < len(still):
        return [now], f"its readings are {differs(still[0], now, settings) or 'further'}"
    still = [*still, now] if fresh else still
    waited = still[-1].received - still[0].received
    if len(still) < settings.poses or waited < settings.dwell_s:
        return still, f"{len(still)} fresh readings over {waited:.2f} s"
    return still, ""
