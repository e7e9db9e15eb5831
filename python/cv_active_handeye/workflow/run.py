# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The whole job on one station: capture, views to check with, calibrate, verify, report."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ..calibration import Calibration
from ..config import CalibrationOptions
from ..dataset import FILE_NAME, Dataset
from ..plan_file import Plan
from .calibrate import calibrate_with_evidence
from .capture import PLAN_NAME, Capture, CaptureSettings, Improve, Station, begin
from .check_stops import check_plan_of
from .dry_run import check_plan
from .event_log import EventLog
from .pictures import draw_pictures
from .reporter import Reporter
from .reporting import report_calibration
from .resume import check_again, reopen
from .verify import Verification, verify


@dataclass(frozen=True)
class RunResult:
    """What a run found, and where it wrote it."""

    folder: Path
    calibration: Calibration
    verification: Verification
    report: Path


def record(
    folder: Path,
    plan: Plan,
    station: Station,
    settings: CaptureSettings,
    log: EventLog,
    reporter: Reporter,
    improve: Improve | None = None,
) -> Dataset:
    """Captures `plan` into a new data set, or goes on with the one that `folder` holds (its own plan counts then).

    Every way is checked before the first move. For errors see `Capture.run`.
    """
    capture = Capture(station, folder, log, settings, reporter)
    if (folder / FILE_NAME).is_file():
        plan, dataset = reopen(folder, station, settings.settle)
        if len(dataset) == len(plan.stops):
            return dataset
        check_plan(station.robot, plan, len(dataset))
        check_again(dataset, plan, station, settings, log)
        reporter.note(f"going on with view {len(dataset)} of {len(plan.stops)}")
    else:
        check_plan(station.robot, plan)
        dataset = begin(folder, plan, station)
    log("begin", plan=plan.sha256(), robot=station.robot.robot.name, views=len(dataset), stops=len(plan.stops))
    return capture.run(plan, dataset, improve)


def record_with_checks(
    folder: Path,
    plan: Plan,
    station: Station,
    settings: CaptureSettings,
    log: EventLog,
    reporter: Reporter,
    improve: Improve | None = None,
) -> tuple[Dataset, Dataset]:
    """Records `dataset` and then `check`, some views between its stops, into `folder`."""
    dataset = record(folder / "dataset", plan, station, settings, log, reporter, improve)
    captured = Plan.load(folder / "dataset" / PLAN_NAME)
    resumed = (folder / "check" / FILE_NAME).is_file()
    checks = captured if resumed else check_plan_of(captured, station.robot)
    return dataset, record(folder / "check", checks, station, settings, log, reporter)


def evaluate(folder: Path, options: CalibrationOptions, reporter: Reporter) -> RunResult:
    """Calibrates from `dataset`, verifies with `check`, and writes calibration.yaml, report.html and pictures."""
    dataset, check = Dataset.open(folder / "dataset"), Dataset.open(folder / "check")
    calibration, evidence = calibrate_with_evidence(dataset, options, reporter)
    calibration.save(folder / "calibration.yaml")
    draw_pictures(folder / "pictures", dataset, calibration, evidence)
    report_calibration(folder / "report.html", dataset, calibration, evidence, reporter)
    verification = verify(check, calibration, options, reporter)
    return RunResult(folder, calibration, verification, folder / "report.html")
