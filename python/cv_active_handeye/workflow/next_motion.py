# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Between the groups of a capture: calibrate from what was taken, and plan the rest anew for what is known now."""

from __future__ import annotations

import numpy as np

import cv_active_handeye as cah

from ..calibration import Calibration
from ..config import CalibrationOptions
from ..dataset import Dataset
from ..plan_file import Plan
from ..robots.base import Robot
from .calibrate import calibrate_with_evidence
from .capture import Improve
from .plan import improve_plan, target_met
from .plan_knowledge import Knowledge
from .plan_settings import PlanSettings
from .plan_views import Start, start_of
from .reporter import NO_CONVERGENCE, InsufficientDataError, Reporter, Silent

NEW_STOPS = 4
"""Stops after an improvement, before which it is not worth calibrating again."""


def next_motion(robot: Robot, options: CalibrationOptions, settings: PlanSettings, reporter: Reporter) -> Improve:
    """What `Capture.run` asks after each group: the plan with its rest improved, or None when the target is met.

    As long as the views taken cannot be calibrated, and for `NEW_STOPS` stops after it was improved, the plan stays.
    """
    looked_at = 0

    def improve(dataset: Dataset, plan: Plan) -> Plan | None:
        nonlocal looked_at
        taken, last = len(dataset), len(dataset) == len(plan.stops)
        worth_it = settings.target_sigma_mm is not None if last else taken - looked_at >= NEW_STOPS
        if not worth_it:
            return plan
        found = _calibrated(dataset, options)
        if found is None:
            return plan
        looked_at = taken
        calibration, summary = found
        if target_met(calibration, settings):
            return None
        try:
            knowledge = Knowledge.learned(calibration, summary, _start(plan), settings)
            return improve_plan(plan, taken, knowledge, settings, start_of(robot).joints)
        except InsufficientDataError as error:
            reporter.note(f"the plan stays as it is: {error}")
            return plan

    return improve


def _calibrated(dataset: Dataset, options: CalibrationOptions) -> tuple[Calibration, cah.RefineSummary] | None:
    try:
        calibration, evidence = calibrate_with_evidence(dataset, options, Silent())
    except InsufficientDataError:
        return None
    except cah.error as error:
        if error.code != NO_CONVERGENCE:
            raise
        return None
    assert evidence.summary is not None
    usable = calibration.verdict is not None and calibration.verdict.usable
    known = np.isfinite(np.diag(calibration.covariance)).all()
    return (calibration, evidence.summary) if usable and known else None


def _start(plan: Plan) -> Start:
    return Start(plan.robot, plan.model, plan.start.T_gripper2base)
