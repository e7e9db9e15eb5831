# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The command that plans where the robot stops."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.table import Table
from scipy.spatial.transform import Rotation

from ..files import FloatArray, read_yaml, validate
from ..plan_file import Plan
from ..report.plan_picture import picture_plan
from ..robots.kinematics import ARMS, arm
from ..robots.registry import open_robot
from ..station import StationConfig
from ..workflow.plan import make_plan
from ..workflow.plan_order import motor_seconds
from ..workflow.plan_settings import PlanSettings
from ..workflow.plan_views import Start, start_of
from ..workflow.planned_station import planning_of
from .application import Settings, command, print_lines
from .console import out, terminal_reporter, told_errors
from .station import CameraKind, HostName, Model, RobotKind, StationFile, station_of
from .tables import plain_table

_UNITS_MM = {"mm": 1.0, "um": 0.001, "m": 1000.0, "": 1.0}

SettingsFile = Annotated[
    Path | None,
    typer.Argument(help="YAML file: mounting, optics, boxes, noise; default: the station's.", metavar="SETTINGS"),
]
PlanFile = Annotated[Path, typer.Option("--output", "-o", help="Plan file.")]
PlanPicture = Annotated[Path | None, typer.Option("--picture", help="PNG file; default: beside the plan.")]
Stops = Annotated[int | None, typer.Option(min=4, help="Number of stops.")]
TargetSigma = Annotated[
    str | None,
    typer.Option(help="As few stops as predict this standard deviation of t_cam2gripper, such as 0.2mm."),
]
StartJoints = Annotated[str | None, typer.Option(help="Start: six joint angles, degrees, separated by commas.")]
StartPose = Annotated[
    str | None, typer.Option(help="Start: flange x,y,z in mm and rotation vector in degrees, separated by commas.")
]


@command(
    "plan --station station.yaml --stops 24",
    "plan --robot ur --host 127.0.0.1 --camera sim --target-sigma 0.2mm",
    "plan cell.yaml --model ur5e --start-joints 0,-90,90,-90,-90,0 --stops 24",
    "plan cell.yaml --start-pose 400,0,300,180,0,0 --target-sigma 0.2mm -o plan.yaml",
)
def plan(
    settings: SettingsFile = None,
    output: PlanFile = Path("plan.yaml"),
    picture: PlanPicture = None,
    stops: Stops = None,
    target_sigma: TargetSigma = None,
    station: StationFile = None,
    robot: RobotKind = None,
    host: HostName = None,
    model: Model = None,
    camera: CameraKind = None,
    start_joints: StartJoints = None,
    start_pose: StartPose = None,
) -> None:
    """Plans where the robot stops: groups of translations and turns that make t_cam2gripper as certain as they can.

    Nothing moves. The plan stays within the boxes of the settings and, where the arm's model is known, within its joint
    limits and away from singularities, all along the straight lines from stop to stop. Predicted standard deviations
    are those that the calibration would state.

    The start is where the camera looks at the scene from the stand-off of the settings: where the station's robot
    stands now, which is only looked at, or what the options say.
    """
    with terminal_reporter() as reporter, told_errors(Settings.debug, reporter):
        wanted = asked_stops(stops, target_sigma)
        if settings is None or station is not None or robot is not None:
            if start_joints is not None or start_pose is not None:
                raise typer.BadParameter("the station's robot says where it stands", param_hint="--start-pose")
            config = station_of(station, robot, host, model, camera, None, None)
            start, asked = start_at(config, settings, wanted)
        else:
            start, asked = start_from(model, start_joints, start_pose), plan_settings(settings, wanted)
        made = make_plan(start, asked, reporter)
        output.parent.mkdir(parents=True, exist_ok=True)
        made.save(output)
        shown = output.with_suffix(".png") if picture is None else picture
        draw_plan(shown, made, asked)
    out.print(predictions_table(made))
    print_lines(*plan_lines(made, asked), f"Written to {output}", f"Picture: {shown}")


def start_at(config: StationConfig, settings: Path | None, wanted: dict[str, Any]) -> tuple[Start, PlanSettings]:
    """Where the robot of a station stands, and the settings of a file or else of the station."""
    with open_robot(config.robot, live=False) as arm:
        asked = planning_of(config, arm, wanted) if settings is None else plan_settings(settings, wanted)
        return start_of(arm), asked


def plan_settings(file: Path, asked: dict[str, Any]) -> PlanSettings:
    """Settings of a file, with what the command line asks instead."""
    return validate(PlanSettings, {**read_yaml(file, "settings"), **asked}, file)


def asked_stops(stops: int | None, target_sigma: str | None) -> dict[str, Any]:
    """What the options ask of a plan, for `PlanSettings`; empty where they ask nothing."""
    if stops is not None and target_sigma is not None:
        raise typer.BadParameter("needs one of --stops and --target-sigma, given both", param_hint="--target-sigma")
    if stops is not None:
        return {"stops": stops, "target_sigma_mm": None}
    return {} if target_sigma is None else {"stops": None, "target_sigma_mm": millimetres(target_sigma)}


def millimetres(text: str) -> float:
    """A length such as 0.2mm, 200um or 0.0002m; without a unit, mm."""
    found = re.fullmatch(r"([0-9]*\.?[0-9]+(?:e-?[0-9]+)?)\s*(mm|um|m|)", text.strip())
    if found is None or float(found[1]) <= 0:
        raise typer.BadParameter(f"needs a positive length such as 0.2mm, given {text!r}", param_hint="--target-sigma")
    return float(found[1]) * _UNITS_MM[found[2]]


def start_from(model: str | None, joints: str | None, pose: str | None) -> Start:
    """The start that the command line names: joints of a known arm, or a flange pose."""
    if (joints is None) == (pose is None):
        raise typer.BadParameter("needs one of --start-joints and --start-pose", param_hint="--start-pose")
    if model is not None and model not in ARMS:
        raise typer.BadParameter(f"needs one of {', '.join(sorted(ARMS))}, given {model!r}", param_hint="--model")
    if joints is None:
        assert pose is not None
        if model is not None:
            raise typer.BadParameter("an arm needs --start-joints: a pose has several", param_hint="--model")
        return Start("no robot", None, _flange(_six(pose, "--start-pose")))
    if model is None:
        raise typer.BadParameter("--start-joints need the arm they belong to", param_hint="--model")
    q = np.radians(_six(joints, "--start-joints"))
    return Start(arm(model).name, model, arm(model).forward(q), q)


def _six(text: str, option: str) -> FloatArray:
    try:
        values = np.array([float(part) for part in text.split(",")])
    except ValueError:
        values = np.array([])
    if values.shape != (6,) or not np.isfinite(values).all():
        raise typer.BadParameter(f"needs six numbers separated by commas, given {text!r}", param_hint=option)
    return values


def _flange(values: FloatArray) -> FloatArray:
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = Rotation.from_rotvec(np.radians(values[3:])).as_matrix(), values[:3] / 1000
    return T


def draw_plan(path: Path, made: Plan, settings: PlanSettings) -> None:
    """The picture of a plan."""
    K = settings.camera_matrix
    half_view = settings.image_width / (2 * K[0, 0]), settings.image_height / (2 * K[1, 1])
    picture_plan(path, made, settings.T_cam2gripper, half_view, settings.stand_off_mm / 1000)


def predictions_table(made: Plan) -> Table:
    """Predicted standard deviations against the number of stops; - = not determined by so few."""
    table = plain_table("predicted standard deviations", "stops", "t [mm]", "R [deg]", "fx [%]", "light plane [mm]")
    for row in made.predictions:
        values = (row.t_cam2gripper_mm, row.R_cam2gripper_deg, row.fx_percent, row.light_plane_mm)
        table.add_row(str(row.stops), *("-" if value is None else f"{value:.3g}" for value in values))
    return table


def plan_lines(made: Plan, settings: PlanSettings) -> list[str]:
    """How much there is to do."""
    poses = [stop.T_gripper2base for stop in made.stops]
    seconds = motor_seconds(made.start.T_gripper2base, poses, settings)
    groups = [stop.group for stop in made.stops]
    translating = sum(groups.count(group) > 1 for group in set(groups))
    return [
        f"{len(made.stops)} stops at {len(set(groups))} orientations, {translating} of them with translations; "
        f"about {seconds:.0f} s on the way and settling"
    ]
