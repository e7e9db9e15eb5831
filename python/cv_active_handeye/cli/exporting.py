# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The command `export`: a calibration for other programs."""

from __future__ import annotations

from enum import Enum
from pathlib import Path
from typing import Annotated

import typer
from pydantic import ValidationError
from rich.markup import escape

from ..calibration import Calibration
from ..export import Frames, NotUsableError
from ..export import export as export_text
from ..export.frames import BASE, CAMERA, FLANGE
from ..files import write_atomic
from ..report.words import command_line_words
from .application import Settings, command, print_lines
from .console import Exit, err, out, told_errors


class Form(str, Enum):
    """Choices of --format: the keys of `export.FORMATS`."""

    OPENCV = "opencv"
    JSON = "json"
    ROS1 = "ros1"
    ROS2 = "ros2"
    EASY_HANDEYE2 = "easy-handeye2"
    CAMERA_INFO = "camera-info"
    URDF = "urdf"


class Mounting(str, Enum):
    """Choices of --mounting."""

    IN_HAND = "eye-in-hand"
    ON_BASE = "eye-on-base"


File = Annotated[Path, typer.Argument(help="A calibration.yaml.", metavar="CALIBRATION")]
FormChoice = Annotated[Form, typer.Option("--format", help="What is to read it.")]
Output = Annotated[Path | None, typer.Option("--output", "-o", help="File to write; default: the terminal.")]
MountingChoice = Annotated[
    Mounting,
    typer.Option(help="eye-in-hand: camera on the arm. eye-on-base: it stands, calibrated with inverted robot poses."),
]
Parent = Annotated[
    str | None,
    typer.Option(help=f"The robot's frame: flange (default {FLANGE}), or for eye-on-base the base (default {BASE})."),
]
Child = Annotated[str, typer.Option(help="The camera's optical frame: x right, y down, z forward.")]
Other = Annotated[str | None, typer.Option(help="easy-handeye2 only: the robot's frame on the other side of the arm.")]
Name = Annotated[str, typer.Option(help="Name of the camera or the calibration.")]
Force = Annotated[bool, typer.Option("--force", help="Export even what is not usable or only determined in part.")]


@command(
    "export out/calibration.yaml --format ros2",
    "export out/calibration.yaml --format urdf --parent flange --child wrist_camera_optical_frame -o camera.xacro",
    "export out/calibration.yaml --format easy-handeye2 --name wrist -o wrist.calib",
)
def export(
    calibration: File,
    form: FormChoice,
    output: Output = None,
    mounting: MountingChoice = Mounting.IN_HAND,
    parent: Parent = None,
    child: Child = CAMERA,
    other_frame: Other = None,
    name: Name = "camera",
    force: Force = False,
) -> None:
    """Writes a calibration in the form another program reads: OpenCV, JSON, ROS 1, ROS 2, easy_handeye2, URDF.

    opencv: YAML for cv::FileStorage. ros1, ros2: the command line of static_transform_publisher. camera-info: the YAML
    of camera_info_manager. urdf: a link and a fixed joint for a URDF or xacro file. Poses are those of the camera's
    optical frame in the robot's frame, quaternions x y z w, roll pitch yaw about fixed axes, metres and rad.
    """
    with told_errors(Settings.debug):
        text = _text(
            Calibration.load(calibration), form.value, _frames(mounting, parent, child, other_frame), name, force
        )
        if output is not None:
            output.parent.mkdir(parents=True, exist_ok=True)
            write_atomic(output, text.encode())
    if output is None:
        out.out(text, end="", highlight=False)
    else:
        print_lines(f"Written to {output}")


def _frames(mounting: Mounting, parent: str | None, child: str, other: str | None) -> Frames:
    try:
        return Frames(mounting=mounting.value, parent=parent, child=child, other=other)
    except ValidationError as error:
        options = {"parent": "--parent", "child": "--child", "other": "--other-frame"}
        item = error.errors()[0]
        text = f"needs a letter, then letters, digits, _ / . or -, given {item['input']!r}"
        raise typer.BadParameter(text, param_hint=options[str(item["loc"][0])]) from error


def _text(calibration: Calibration, form: str, frames: Frames, name: str, force: bool) -> str:
    try:
        return export_text(calibration, form, frames, name=name, force=force)
    except NotUsableError as error:
        reason = escape(command_line_words(str(error)))
        err.print(f"[bold red]error:[/] not exported: {reason}. --force exports it as it is.")
        raise typer.Exit(int(Exit.BEYOND_LIMITS)) from error
    except ValueError as error:
        raise typer.BadParameter(str(error), param_hint="--format") from error
