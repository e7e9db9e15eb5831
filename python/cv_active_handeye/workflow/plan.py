# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Plans where the robot stops, and plans the rest anew when some stops are done."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

import cv_active_handeye as cah

from ..calibration import Calibration
from ..files import FloatArray
from ..plan_file import Plan, PlannedPose, PlannedStop
from ..robots.workspace import step_size
from .plan_knowledge import Knowledge, predict
from .plan_order import order_stops
from .plan_settings import PlanSettings
from .plan_views import Start, Views, possible_views
from .reporter import NO_CONVERGENCE, InsufficientDataError, Reporter, Silent

_OUT_OF_RANGE = -211  # cv::Error::StsOutOfRange: too few or too many stops
_FEWEST = 4
_REPLANS = 8  # with views left out that no straight line reaches


def make_plan(start: Start, settings: PlanSettings, reporter: Reporter | None = None) -> Plan:
    """The plan from a start pose: as many stops as asked, or as few as reach the target.

    Raises InsufficientDataError that names what is in the way: boxes, joint limits, singularities with numbers, or a
    target that `most_stops` do not reach and what they do.
    """
    choice = _Choice(start, [], Knowledge.assumed(start, settings), settings, reporter or Silent())
    return choice.plan(start, [])


def improve_plan(
    plan: Plan,
    taken: int,
    knowledge: Knowledge,
    settings: PlanSettings,
    joints: FloatArray | None = None,
    reporter: Reporter | None = None,
) -> Plan:
    """The plan with everything after its first `taken` stops chosen anew for what is known now (`Knowledge.learned`).

    joints (6,): those at the last of these stops, where the arm's model is known. The number of stops is that of the
    settings: `stops` as before, or as few as reach the target. Same errors as `make_plan`.
    """
    if not 1 <= taken <= len(plan.stops):
        raise ValueError(f"taken: needs 1 to the plan's {len(plan.stops)} stops, given {taken}")
    done = list(plan.stops[:taken])
    now = Start(plan.robot, plan.model, done[-1].T_gripper2base, joints)
    first = plan.start.T_gripper2base
    joints_at_start = None if now.arm is None or joints is None else now.arm.inverse(first, near=joints)
    start = Start(plan.robot, plan.model, first, joints_at_start)
    poses = [stop.T_gripper2base for stop in done]
    return _Choice(start, poses, knowledge, settings, reporter or Silent()).plan(now, done)


def target_met(calibration: Calibration, settings: PlanSettings) -> bool:
    """Whether a calibration so far is usable and knows t_cam2gripper as well as asked; never without a target."""
    if settings.target_sigma_mm is None or calibration.verdict is None or not calibration.verdict.usable:
        return False
    at = [calibration.parameter_names.index(name) for name in ("tx", "ty", "tz")]
    return 1000 * float(np.sqrt(np.diag(calibration.covariance)[at].sum())) <= settings.target_sigma_mm


def fewest(suffices: Callable[[int], bool], low: int, high: int) -> int:
    """The smallest number from `low` to `high` that suffices, `high` being known to; by bisection."""
    while low < high:
        middle = (low + high) // 2
        low, high = (low, middle) if suffices(middle) else (middle + 1, high)
    return high


def _same_stop(a: FloatArray, b: FloatArray) -> bool:
    """Whether two flange poses (4, 4) would show the same image."""
    length, angle = step_size(a, b)
    return length < 0.001 and angle < 0.05


class _Choice:
    """Views that are possible after those done (flange poses), and the choice among them."""

    def __init__(
        self, start: Start, done: list[FloatArray], knowledge: Knowledge, settings: PlanSettings, reporter: Reporter
    ) -> None:
        ready = reporter.step("looking at possible views")
        self.views: Views = possible_views(start, settings)
        ready(1, 1)
        self.start, self.done, self.knowledge, self.settings = start, done, knowledge, settings
        self.reporter = reporter
        self._left_out = {i for i, pose in enumerate(self.views.poses) if any(_same_stop(pose, old) for old in done)}

    def plan(self, now: Start, done: list[PlannedStop]) -> Plan:
        """The whole plan; the arm stands at `now`."""
        ready = self.reporter.step("choosing stops")
        poses = [*self.done, *self._ordered(now)]
        ready(1, 1)
        first = self.start.T_gripper2base
        return Plan(
            robot=self.start.robot,
            model=self.start.model,
            start=PlannedPose(R_gripper2base=first[:3, :3], t_gripper2base=first[:3, 3]),
            workspace=self.settings.workspace,
            stops=(*done, *self._stops(poses)[len(done) :]),
            predictions=tuple(predict(poses[:count], self.knowledge) for count in range(2, len(poses) + 1)),
        )

    def _stops(self, poses: Sequence[FloatArray]) -> list[PlannedStop]:
        groups = cah.groupViews([pose[:3, :3] for pose in poses]).reshape(-1).tolist()
        laser = self.settings.light_plane_mm is not None
        return [
            PlannedStop(R_gripper2base=pose[:3, :3], t_gripper2base=pose[:3, 3], group=group, laser=laser)
            for pose, group in zip(poses, groups, strict=True)
        ]

    def _ordered(self, now: Start) -> list[FloatArray]:
        """The new stops in their order; views that no way leads to are left out and the choice is made again."""
        for _ in range(_REPLANS):
            _, chosen = self._choose(self._number_of_stops())
            poses = [self.views.poses[i] for i in chosen]
            groups = cah.groupViews([pose[:3, :3] for pose in poses]).reshape(-1).tolist()
            order = order_stops(now, poses, groups, self.settings)
            if not order.stranded:
                return [poses[i] for i in order.visited]
            self._left_out |= {chosen[i] for i in order.stranded}
            self.views.refuse("the way to them", order.reason, len(order.stranded))
        raise InsufficientDataError(f"no order of stops is possible: {self.views.obstacles()}")

    def _choose(self, stops: int) -> tuple[float, list[int]]:
        """Predicted standard deviation, m, of so many stops in all, and the numbers of the new ones."""
        allowed = [i for i in range(len(self.views.poses)) if i not in self._left_out]
        poses = np.asarray([*self.done, *(self.views.poses[i] for i in allowed)])
        known, plan_params = self.knowledge, cah.PlanParams()
        plan_params.seenShare = self.settings.seen_share
        try:
            sigma, chosen = cah.planHandEyeViews(
                poses[:, :3, :3],
                poses[:, :3, 3],
                *known.arguments(),
                stops,
                taken=list(range(len(self.done))) or None,
                params=known.params,
                planParams=plan_params,
            )
        except cah.error as error:
            if error.code not in (NO_CONVERGENCE, _OUT_OF_RANGE):
                raise
            text = f"{stops} stops do not suffice: {str(error).strip()}; more stops may; {self.views.obstacles()}"
            raise InsufficientDataError(text) from error
        return sigma, [allowed[view - len(self.done)] for view in chosen]

    def _number_of_stops(self) -> int:
        """As asked, or the fewest that reach the target."""
        settings = self.settings
        if settings.target_sigma_mm is None:
            assert settings.stops is not None
            return settings.stops
        target, most = settings.target_sigma_mm, settings.most_stops
        best = 1000 * self._choose(most)[0]
        if best > target:
            raise InsufficientDataError(
                f"target_sigma_mm: {target:g} mm is out of reach; {most} stops (most_stops) are predicted to reach "
                f"{best:.3g} mm. More stops, a larger tilt_deg or more room would help; {self.views.obstacles()}"
            )

        def suffices(stops: int) -> bool:
            try:
                return 1000 * self._choose(stops)[0] <= target
            except InsufficientDataError:
                return False

        return fewest(suffices, max(_FEWEST, len(self.done) + 1), most)
