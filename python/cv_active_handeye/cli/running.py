# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The command that does the whole job on a station."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..dataset import FILE_NAME, Dataset
from ..plan_file import Plan
from ..robots.registry import open_robot
from ..station import StationConfig
from ..workflow.capture import PLAN_NAME
from ..workflow.event_log import FILE_NAME as LOG_NAME
from ..workflow.event_log import EventLog
from ..workflow.next_motion import next_motion
from ..workflow.plan import make_plan
from ..workflow.plan_settings import PlanSettings
from ..workflow.plan_views import start_of
from ..workflow.planned_station import planning_of
from ..workflow.run import RunResult, evaluate, record_with_checks
from ..workflow.stand import open_station
from .application import Settings, command, print_lines
from .console import Exit, err, out, terminal_reporter, told_errors
from .live import look_at, told_what_is_safe
from .live_tables import motion_text
from .planning import Stops, TargetSigma, asked_stops, draw_plan, plan_lines, predictions_table
from .results import result_lines, verdict_text, verification_lines
from .station import (
    CameraKind,
    HostName,
    LaserKind,
    Live,
    Model,
    Resume,
    RobotKind,
    SpeedMm,
    StationFile,
    confirm,
    ended_by_signals,
    station_of,
)
from .tables import calibration_table, verification_table

RunFolder = Annotated[Path, typer.Argument(help="Folder for everything that the run writes.", metavar="FOLDER")]
Adapt = Annotated[bool, typer.Option("--adapt/--no-adapt", help="After each group, plan the rest anew.")]


@command(
    "run out/run --robot ur --host 127.0.0.1 --camera sim --live",
    "run out/run --station station.yaml --target-sigma 0.1mm --live",
    "run out/run --station station.yaml --live --resume",
)
def run(
    folder: RunFolder,
    station: StationFile = None,
    robot: RobotKind = None,
    host: HostName = None,
    model: Model = None,
    camera: CameraKind = None,
    laser: LaserKind = None,
    speed_mm_s: SpeedMm = None,
    stops: Stops = None,
    target_sigma: TargetSigma = None,
    adapt: Adapt = True,
    live: Live = False,
    resume: Resume = False,
) -> None:
    """Plans, captures, calibrates, verifies and reports: plan + capture + calibrate + verify in one command.

    Without --live it plans from where the robot stands, checks every way, prints the moves, and nothing moves. With
    --live a person types a word first. After each group of stops the rest of the plan is chosen anew from what was seen
    so far, and with --target-sigma the capture ends when the target is met. Some further views, between those of the
    plan, verify the result. To practise: cv-active-handeye emulate ur, in another terminal.
    """
    with told_errors(Settings.debug), ended_by_signals():
        config = station_of(station, robot, host, model, camera, laser, speed_mm_s)
        settings, plan = planned(folder, config, asked_stops(stops, target_sigma), resume)
        first = len(Dataset.open(folder / "dataset")) if resume and (folder / "dataset" / FILE_NAME).is_file() else 0
        moves = look_at(config, plan, first)
        if not live:
            print_lines("Nothing was moved. --live lets the robot do it.")
            return
        confirm(motion_text(moves, config.speed))
        take(folder, config, settings, plan, adapt)
        with terminal_reporter() as reporter, told_errors(Settings.debug, reporter):
            result = evaluate(folder, config.calibration, reporter)
    print_result(result)


def planned(folder: Path, config: StationConfig, asked: dict[str, object], resume: bool) -> tuple[PlanSettings, Plan]:
    """Makes a plan from where the robot stands and writes it to the folder; with `resume` that of the folder counts.

    What is planned anew later keeps to the same workspace, also where that was drawn around the first start.
    """
    path = folder / PLAN_NAME
    if resume:
        captured = folder / "dataset" / PLAN_NAME
        plan = Plan.load(captured if captured.is_file() else path)
        with open_robot(config.robot, live=False) as arm:
            settings = planning_of(config, arm, asked)
        return settings.model_copy(update={"workspace": plan.workspace}), plan
    if (folder / "dataset" / FILE_NAME).is_file():
        raise FileExistsError(f"{folder}: already holds a run; --resume goes on with it")
    with (
        terminal_reporter() as reporter,
        told_errors(Settings.debug, reporter),
        open_robot(config.robot, live=False) as arm,
    ):
        settings = planning_of(config, arm, asked)
        plan = make_plan(start_of(arm), settings, reporter)
    folder.mkdir(parents=True, exist_ok=True)
    plan.save(path)
    draw_plan(path.with_suffix(".png"), plan, settings)
    out.print(predictions_table(plan))
    print_lines(*plan_lines(plan, settings), f"Written to {path}", f"Picture: {path.with_suffix('.png')}")
    return settings, plan


def take(folder: Path, config: StationConfig, settings: PlanSettings, plan: Plan, adapt: bool) -> None:
    """Records the views to calibrate from, and those to verify with."""
    with (
        told_what_is_safe(folder / "dataset"),
        terminal_reporter() as reporter,
        EventLog(folder / LOG_NAME) as log,
        open_station(config, plan.workspace, live=True, event=log, ask=reporter.ask, reporter=reporter) as station,
    ):
        improve = next_motion(station.robot.robot, config.calibration, settings, reporter) if adapt else None
        record_with_checks(folder, plan, station, config.capture, log, reporter, improve)


def print_result(result: RunResult) -> None:
    """The calibration, its verdict and its verification; exit status 5 where it may not be used."""
    out.print(calibration_table(result.calibration))
    print_lines(verdict_text(result.calibration), *result_lines(result.calibration))
    out.print(verification_table(result.verification))
    print_lines(*verification_lines(result.verification))
    print_lines(f"Written to {result.folder}: dataset/, check/, calibration.yaml, pictures/")
    print_lines(f"Report: {result.report}")
    usable = result.calibration.verdict is not None and result.calibration.verdict.usable
    if not usable or not result.verification.valid:
        err.print("[bold red]error:[/] the result must not be used" if not usable else "[bold red]error:[/] not valid")
        raise typer.Exit(int(Exit.BEYOND_LIMITS))
