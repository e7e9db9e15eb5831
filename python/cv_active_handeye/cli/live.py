# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The command that records a planned motion, on a real or an emulated robot."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from ..dataset import FILE_NAME, Dataset
from ..files import FileFormatError
from ..plan_file import Plan
from ..robots.guard import GuardedRobot
from ..robots.registry import open_robot
from ..station import StationConfig
from ..workflow.capture import PLAN_NAME, safe_text
from ..workflow.dry_run import PlannedMove, check_plan, note_of
from ..workflow.event_log import FILE_NAME as LOG_NAME
from ..workflow.event_log import EventLog
from ..workflow.run import record
from ..workflow.stand import open_station
from . import arguments
from .application import Settings, command, print_lines
from .console import err, out, terminal_reporter, told_errors
from .live_tables import motion_text, moves_table
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

PlanFile = Annotated[Path | None, typer.Option("--plan", help="plan.yaml; with --resume that of the data set counts.")]


@command(
    "capture out/set --plan plan.yaml --robot ur --host 127.0.0.1 --camera sim",
    "capture out/set --plan plan.yaml --station station.yaml --live",
    "capture out/set --station station.yaml --live --resume",
)
def capture(
    dataset: arguments.NewDataset,
    plan: PlanFile = None,
    station: StationFile = None,
    robot: RobotKind = None,
    host: HostName = None,
    model: Model = None,
    camera: CameraKind = None,
    laser: LaserKind = None,
    speed_mm_s: SpeedMm = None,
    live: Live = False,
    resume: Resume = False,
) -> None:
    """Moves through the stops of a plan and records images and poses: a data set to calibrate from.

    Without --live it looks at the robot, checks every way and prints the moves; nothing moves. At every stop the arm
    has to come to rest, and the pose is read before and after the images; each view is on disk before the next move.
    Any doubt (a stop of the controller, no fresh pose, a dead link, Ctrl-C) stops the arm and ends the capture; what
    was taken stays, and --resume goes on behind it after comparing pose and image of the last stop. DATASET gets
    plan.yaml beside its views and events.jsonl, the log of all that happened.
    """
    with told_errors(Settings.debug), ended_by_signals():
        planned = planned_stops(dataset, plan, resume)
        config = station_of(station, robot, host, model, camera, laser, speed_mm_s)
        moves = look_at(config, planned, len(Dataset.open(dataset)) if resume else 0)
        if not live:
            print_lines("Nothing was moved. --live lets the robot do it.")
            return
        confirm(motion_text(moves, config.speed))
        dataset.mkdir(parents=True, exist_ok=True)
        with (
            told_what_is_safe(dataset),
            terminal_reporter() as reporter,
            EventLog(dataset / LOG_NAME) as log,
            open_station(
                config, planned.workspace, live=True, event=log, ask=reporter.ask, reporter=reporter
            ) as opened,
        ):
            recorded = record(dataset, planned, opened, config.capture, log, reporter)
    print_lines(f"{len(recorded)} views in {dataset}")


def look_at(config: StationConfig, plan: Plan, first: int) -> list[PlannedMove]:
    """Checks and prints the moves to the stops from number `first` on; nothing moves."""
    with terminal_reporter() as reporter:
        progress = reporter.step("looking where the robot is, checking every way")
        with open_robot(config.robot, live=False) as robot:
            guard = GuardedRobot(robot, plan.workspace, config.speed, lambda kind, **said: None)
            moves = check_plan(guard, plan, first)
        progress(1, 1)
        note = note_of(plan)
        if note is not None:
            reporter.note(note)
    out.print(moves_table(plan, moves))
    print_lines(motion_text(moves, config.speed))
    return moves


@contextmanager
def told_what_is_safe(dataset: Path) -> Iterator[None]:
    """After whatever ended a capture: what is on disk, and how to go on."""
    try:
        yield
    except BaseException:
        taken = len(Dataset.open(dataset)) if (dataset / FILE_NAME).is_file() else 0
        err.print(f"{dataset}: {safe_text(taken)}", highlight=False)
        raise


def planned_stops(dataset: Path, plan: Path | None, resume: bool) -> Plan:
    """The plan to follow: the one given, or with --resume the one beside the views."""
    exists = (dataset / FILE_NAME).is_file()
    if resume:
        if not exists:
            raise FileFormatError(f"{dataset}: holds no data set to go on with; leave out --resume")
        return Plan.load(dataset / PLAN_NAME)
    if exists:
        raise FileExistsError(f"{dataset}: already holds a data set; --resume goes on with it")
    if plan is None:
        raise typer.BadParameter("needs a plan (cv-active-handeye plan makes one)", param_hint="--plan")
    return Plan.load(plan)
