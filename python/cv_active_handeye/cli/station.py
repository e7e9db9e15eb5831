# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Options that say which station there is, and the person who is asked before anything moves."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer

from ..robots.base import MoveRefusedError
from ..station import StationConfig, load_station
from .console import err

StationFile = Annotated[Path | None, typer.Option("--station", help="station.yaml; the other options override it.")]
RobotKind = Annotated[str | None, typer.Option("--robot", help="ur, denso, sim (this process) or recorded.")]
HostName = Annotated[str | None, typer.Option("--host", help="Address of the robot's controller.")]
Model = Annotated[str | None, typer.Option(help="Its geometry: ur5e or denso_vp6242; for checks along the way.")]
CameraKind = Annotated[str | None, typer.Option("--camera", help="opencv, basler, genicam, folder or sim.")]
LaserKind = Annotated[str | None, typer.Option("--laser", help="camera_line, robot_output, operator or none.")]
SpeedMm = Annotated[float | None, typer.Option("--speed-mm-s", min=1, max=250, help="Speed of the flange, mm/s.")]
Live = Annotated[bool, typer.Option("--live", help="Let the robot move, after a typed confirmation.")]
Resume = Annotated[bool, typer.Option("--resume", help="Go on with a capture that ended early.")]

CONFIRMATION = "move"


def station_of(
    file: Path | None,
    robot: str | None,
    host: str | None,
    model: str | None,
    camera: str | None,
    laser: str | None,
    speed_mm_s: float | None,
) -> StationConfig:
    """The station of the file with what the options say on top; a simulated camera looks at the emulator at `host`."""
    said: dict[str, Any] = {
        "robot": _given(type=robot, host=host, model=model),
        "camera": _given(type=camera, host=host if camera == "sim" else None),
        "laser": _given(type=laser or ("camera_line" if camera == "sim" else None)),
        "speed": _given(metres_per_second=None if speed_mm_s is None else speed_mm_s / 1000),
    }
    if file is None and (robot is None or camera is None):
        raise typer.BadParameter("needs a station file, or --robot and --camera", param_hint="--station")
    return load_station(file, {key: value for key, value in said.items() if value})


def confirm(what: str) -> None:
    """Asks the person beside the robot; MoveRefusedError for anything but the word itself."""
    err.print(f"[bold yellow]The robot will move:[/] {what}", highlight=False)
    err.print("Stand clear, keep the emergency stop in reach; this program is no safety function.", highlight=False)
    answer = typer.prompt(f'Type "{CONFIRMATION}" to let it move', default="", show_default=False, err=True)
    if answer.strip() != CONFIRMATION:
        raise MoveRefusedError(f'nothing was moved: the answer was {answer.strip()!r}, needed "{CONFIRMATION}"')


@contextmanager
def ended_by_signals() -> Iterator[None]:
    """A termination by the system stops the robot like Ctrl-C."""
    previous = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, previous)


def _given(**values: Any) -> dict[str, Any]:
    return {key: value for key, value in values.items() if value is not None}
