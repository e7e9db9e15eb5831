# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""In which order stops are visited: groups of equal orientation together, the nearest next, every way checked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..files import FloatArray
from ..robots.base import MoveRefusedError
from ..robots.kinematics import SerialArm
from ..robots.workspace import check_joints, step_size
from .plan_settings import PlanSettings

_GROUP = 3  # stops of equal orientation that stay together and come first


@dataclass(frozen=True)
class Order:
    """`visited`: numbers of the stops in their order; `stranded`: those that no straight line reaches, and why."""

    visited: list[int]
    stranded: list[int]
    reason: str = ""


def motor_seconds(start: FloatArray, poses: Sequence[FloatArray], settings: PlanSettings) -> float:
    """Time to visit flange poses (4, 4) one after the other: ways at the set speeds, and settling at every stop."""
    legs = zip([start, *poses[:-1]], poses, strict=True)
    return sum(_leg_seconds(a, b, settings) for a, b in legs) + settings.settle_seconds * len(poses)


def _leg_seconds(start: FloatArray, end: FloatArray, settings: PlanSettings) -> float:
    """A straight line with a trapezoidal profile, or the turn where that takes longer."""
    length, angle = step_size(start, end)
    v, a = settings.speed.metres_per_second, settings.speed.metres_per_second2
    line = length / v + v / a if length > v * v / a else 2 * float(np.sqrt(length / a))
    return max(line, angle / settings.turn_deg_per_second)


def order_stops(
    start: FloatArray,
    joints: FloatArray | None,
    arm: SerialArm | None,
    poses: Sequence[FloatArray],
    groups: Sequence[int],
    settings: PlanSettings,
) -> Order:
    """Order of flange poses (4, 4) whose orientations are numbered by `groups`, from a start (4, 4) with joints (6,).

    Groups of three stops and more come first, and a group is finished before the next begins. Every way keeps the
    workspace and, where the arm is known, joint limits and distance from singularities, all along the straight line.
    """
    left, visited, reason = set(range(len(poses))), list[int](), ""
    pose, now = start, joints
    while left:
        for number in _preferred(left, visited, pose, poses, groups, settings):
            try:
                settings.workspace.check_path(pose, poses[number])
                now = now if arm is None or now is None else check_joints(arm, now, poses[number])
            except MoveRefusedError as error:
                reason = str(error)
                continue
            visited.append(number)
            left.remove(number)
            pose = poses[number]
            break
        else:
            break
    return Order(visited, sorted(left), reason)


def _preferred(
    left: set[int],
    visited: Sequence[int],
    pose: FloatArray,
    poses: Sequence[FloatArray],
    groups: Sequence[int],
    settings: PlanSettings,
) -> list[int]:
    """What is left: the group at hand, then groups, then single stops; each by the time it takes to get there."""
    current = groups[visited[-1]] if visited else None

    def rank(number: int) -> tuple[bool, bool, float]:
        single = list(groups).count(groups[number]) < _GROUP
        return groups[number] != current, single, _leg_seconds(pose, poses[number], settings)

    return sorted(left, key=rank)
