# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""In which order stops are visited: groups of equal orientation together, the nearest next, every way checked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..files import FloatArray
from ..robots.base import MoveRefusedError
from ..robots.workspace import check_joints, step_size
from .plan_settings import PlanSettings
from .plan_views import Start

_SAME_RAD = 1e-3
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
    return max(settings.speed.seconds(length), angle / settings.turn_deg_per_second)


def order_stops(start: Start, poses: Sequence[FloatArray], groups: Sequence[int], settings: PlanSettings) -> Order:
    """Order of flange poses (4, 4) whose orientations are numbered by `groups`.

    Groups of three stops and more come first, and a group is finished before the next begins. Every way keeps the
    workspace and, where the arm is known, joint limits and distance from singularities, all along the straight line. A
    stop that cannot be reached from where the arm then stands is put in between others where that is possible.
    """
    tour = _Tour(start, poses, groups, settings)
    while tour.left and tour.advance():
        pass
    while any(tour.insert(number) for number in sorted(tour.left)):
        while tour.left and tour.advance():
            pass
    return Order([leg.stop for leg in tour.legs[1:]], sorted(tour.left), tour.reason)


@dataclass(frozen=True)
class _Leg:
    """A stop that is reached, -1 for the start, and the joints there."""

    stop: int
    pose: FloatArray
    joints: FloatArray | None


class _Tour:
    """The order as it grows."""

    def __init__(
        self, start: Start, poses: Sequence[FloatArray], groups: Sequence[int], settings: PlanSettings
    ) -> None:
        self._arm, self._poses, self._groups, self._settings = start.arm, poses, groups, settings
        self.legs = [_Leg(-1, start.T_gripper2base, start.joints)]
        self.left, self.reason = set(range(len(poses))), ""

    def advance(self) -> bool:
        """Goes on to the best stop that a straight line reaches; False where there is none."""
        for number in self._preferred():
            leg = self._leg(self.legs[-1], number)
            if leg is not None:
                self.legs.append(leg)
                self.left.remove(number)
                return True
        return False

    def insert(self, number: int) -> bool:
        """Puts a stop between two others, or after a group, without breaking one up; False where no place is found."""
        for place in range(1, len(self.legs)):
            before, after = self.legs[place - 1], self.legs[place]
            neighbours = {self._group(before.stop), self._group(after.stop)}
            if len(neighbours) == 1 and self._groups[number] not in neighbours:
                continue
            there = self._leg(before, number)
            back = None if there is None else self._leg(there, after.stop)
            if there is not None and back is not None and _same(back.joints, after.joints):
                self.legs.insert(place, there)
                self.left.remove(number)
                return True
        return False

    def _group(self, stop: int) -> int:
        return -1 if stop < 0 else self._groups[stop]

    def _leg(self, start: _Leg, number: int) -> _Leg | None:
        """The way from one stop to another; None where boxes or the arm refuse it, which `reason` then says."""
        pose = self._poses[number]
        try:
            self._settings.workspace.check_path(start.pose, pose)
            arm, now = self._arm, start.joints
            joints = None if arm is None or now is None else check_joints(arm, now, pose)
        except MoveRefusedError as error:
            self.reason = str(error)
            return None
        return _Leg(number, pose, joints)

    def _preferred(self) -> list[int]:
        """What is left: the group at hand, then groups, then single stops; each by the time it takes to get there."""
        now = self.legs[-1]

        def rank(number: int) -> tuple[bool, bool, float]:
            single = list(self._groups).count(self._groups[number]) < _GROUP
            seconds = _leg_seconds(now.pose, self._poses[number], self._settings)
            return self._groups[number] != self._group(now.stop), single, seconds

        return sorted(self.left, key=rank)


def _same(a: FloatArray | None, b: FloatArray | None) -> bool:
    """Whether two joint vectors are one configuration."""
    return (a is None and b is None) or (a is not None and b is not None and bool(np.abs(a - b).max() < _SAME_RAD))
