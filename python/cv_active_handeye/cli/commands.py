# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The commands and their arguments."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.markup import escape

import cv_active_handeye as cah

from ..calibration import Calibration, read_camera
from ..config import CalibrationOptions
from ..dataset import FILE_NAME, Dataset
from ..files import read_yaml, validate
from ..workflow import BoardSpec, Comparison, calibrate_with_evidence
from ..workflow import compare as run_comparison
from ..workflow.pictures import draw_pictures
from .console import Exit, err, out, terminal_reporter, told_errors
from .tables import (
    calibration_summary,
    calibration_table,
    cameras_table,
    dataset_table,
    demo_table,
    hand_eye_table,
    limits_table,
    scores_table,
)

if TYPE_CHECKING:
    from ..simulation import CellConfig

STATUS_HELP = (
    "[bold]Exit status:[/] 0 usable result, 1 internal error, 2 wrong usage, 3 the data cannot answer, "
    "4 a file that cannot be used, 5 result beyond its limits (demo)."
)

app = typer.Typer(
    name="cv-active-handeye",
    no_args_is_help=True,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


class _Settings:
    debug = False


def _print_version(wanted: bool) -> None:
    if wanted:
        out.print(cah.__version__)
        raise typer.Exit


@app.callback(epilog=STATUS_HELP)
def main(
    debug: Annotated[bool, typer.Option("--debug", help="Show the trace-back of an error.")] = False,
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Version.")
    ] = False,
) -> None:
    """Calibrates a robot's camera and line laser without a target: from pure translations and turns of the robot.

    Start with [bold]cv-active-handeye demo[/]: it records a simulated cell and calibrates it.
    """
    _Settings.debug = debug


OutputOption = Annotated[Path, typer.Option("--output", "-o", help="Folder for everything the demo writes.")]
SeedOption = Annotated[int, typer.Option(min=0, help="Seed of the simulated cell: same seed, same images.")]
RobotOption = Annotated[str, typer.Option(help="Simulated robot: denso_vp6242 or ur5e.")]
DatasetArgument = Annotated[Path, typer.Argument(help="Folder with dataset.yaml.", metavar="DATASET")]
CameraOption = Annotated[
    Path | None, typer.Option(help="Known camera: a file with camera_matrix and distortion_coefficients, both kept.")
]
DistortionOption = Annotated[Path | None, typer.Option(help="Known distortion only, from such a file; K is estimated.")]
TrackOption = Annotated[bool, typer.Option("--track", help="Track the images even where image points are stored.")]
NewDatasetArgument = Annotated[Path, typer.Argument(help="Folder for the data set, a new one.", metavar="DATASET")]
TruthOption = Annotated[Path | None, typer.Option(help="File for the truth; default: DATASET-truth.yaml.")]
ResultOption = Annotated[Path, typer.Option("--output", "-o", help="Result file.")]
SkewOption = Annotated[bool, typer.Option("--skew", help="Estimate skew too (default: zero).")]
SquareOption = Annotated[bool, typer.Option("--square-pixels", help="Assume fx = fy.")]
MethodOption = Annotated[str, typer.Option(help="metric (uses how far the robot moved) or foe (directions only).")]
LaserOption = Annotated[bool, typer.Option("--laser/--no-laser", help="Use laser images where there are some.")]
ConfigOption = Annotated[Path | None, typer.Option(help="YAML file with settings; the command line overrides it.")]
PicturesOption = Annotated[Path | None, typer.Option(help="Folder for pictures of tracks, motion and stripe.")]
BoardOption = Annotated[
    str,
    typer.Option(
        help="Board in the images, sizes in mm: chessboard:8x6:28.5 (inner corners, square), circles:10x10:24.8, "
        "charuco:9x6:40:35:DICT_4X4_250 (squares, square, marker), or points (stored in the data set)."
    ),
]
ScoreOption = Annotated[Path | None, typer.Option(help="Score this result instead of calibrating again.")]


@app.command(epilog="Example: cv-active-handeye demo --seed 3 --output out/demo\n\n" + STATUS_HELP)
def demo(output: OutputOption = Path("out/demo"), seed: SeedOption = 0, robot: RobotOption = "denso_vp6242") -> None:
    """Simulates a recording, calibrates from the images alone, and compares with the truth.

    Writes the data set, truth.yaml (outside of the data set), calibration.yaml and pictures.
    """
    with terminal_reporter() as reporter, told_errors(_Settings.debug, reporter):
        from ..workflow.demo import demo as run_demo

        result = run_demo(output, _cell_config(seed, robot), reporter)
    out.print(demo_table(result))
    out.print(limits_table(result))
    out.print(escape(calibration_summary(result.calibration)))
    out.print(f"written to {escape(str(output))}: dataset/, truth.yaml, calibration.yaml, pictures/")
    beyond = result.beyond_limits()
    if beyond:
        err.print(f"[bold red]error:[/] beyond the limits: {', '.join(beyond)}")
        raise typer.Exit(int(Exit.BEYOND_LIMITS))


@app.command(epilog="Example: cv-active-handeye simulate out/cell\n\n" + STATUS_HELP)
def simulate(
    dataset: NewDatasetArgument, truth: TruthOption = None, seed: SeedOption = 0, robot: RobotOption = "denso_vp6242"
) -> None:
    """Records the default motion in the simulated cell: a data set like one of a real robot."""
    truth_file = truth or dataset.with_name(f"{dataset.name}-truth.yaml")
    with terminal_reporter() as reporter, told_errors(_Settings.debug, reporter):
        from ..workflow.simulate import simulate as run_simulation

        recorded, _ = run_simulation(dataset, truth_file, _cell_config(seed, robot), reporter)
    out.print(f"{len(recorded)} views in {escape(str(dataset))}, the truth in {escape(str(truth_file))}")


@app.command(epilog="Example: cv-active-handeye calibrate out/demo/dataset -o calibration.yaml\n\n" + STATUS_HELP)
def calibrate(
    dataset: DatasetArgument,
    output: ResultOption = Path("calibration.yaml"),
    camera: CameraOption = None,
    distortion: DistortionOption = None,
    skew: SkewOption = False,
    square_pixels: SquareOption = False,
    method: MethodOption = "metric",
    laser: LaserOption = True,
    track: TrackOption = False,
    config: ConfigOption = None,
    pictures: PicturesOption = None,
) -> None:
    """Calibrates camera matrix, R_cam2gripper, t_cam2gripper and, with laser images, the light plane.

    Needs pure translations (stops of equal orientation; for an unknown camera four directions, no three in a plane)
    and changes of orientation about two axes. Any textured scene that stands still will do.
    """
    given = {
        "zero_skew": False if skew else None,
        "square_pixels": True if square_pixels else None,
        "method": method if method != "metric" else None,
        "use_laser": False if not laser else None,
        "track_images": True if track else None,
    }
    with terminal_reporter() as reporter, told_errors(_Settings.debug, reporter):
        options = _options(config, camera, distortion, given)
        recording = Dataset.open(dataset)
        result, evidence = calibrate_with_evidence(recording, options, reporter)
        result.save(output)
        if pictures is not None:
            draw_pictures(pictures, recording, result, evidence)
    out.print(calibration_table(result, str(output)))
    out.print(escape(calibration_summary(result)))


@app.command(epilog="Example: cv-active-handeye compare out/tabb --board chessboard:8x6:28.5\n\n" + STATUS_HELP)
def compare(
    dataset: DatasetArgument,
    board: BoardOption,
    calibration: ScoreOption = None,
    camera: CameraOption = None,
    distortion: DistortionOption = None,
    track: TrackOption = False,
) -> None:
    """Runs OpenCV's calibrateCamera and calibrateHandEye (all five methods) on a board, beside ours without it.

    The board stands still, so with a perfect calibration and robot it would not move in the base frame. The columns
    "spread" tell how much it does, "misses" by how many pixels its points miss their places. A board that looks the
    same after a turn may be read turned in some views: prefer ChArUco, or a chessboard with an odd number of rows.
    """
    spec = _board(board)
    with terminal_reporter() as reporter, told_errors(_Settings.debug, reporter):
        recording = Dataset.open(dataset)
        options = _options(None, camera, distortion, {"track_images": True if track else None})
        given = Calibration.load(calibration) if calibration is not None else None
        comparison = run_comparison(recording, spec, options, reporter, given)
    out.print(cameras_table(comparison))
    out.print(hand_eye_table(comparison))
    out.print(scores_table(comparison))
    _print_problems(comparison)
    if all(row.problem for row in comparison.rows if not row.name.startswith("OpenCV")):
        raise typer.Exit(int(Exit.INSUFFICIENT_DATA))


@app.command(epilog="Example: cv-active-handeye show calibration.yaml\n\n" + STATUS_HELP)
def show(
    file: Annotated[Path, typer.Argument(help="A calibration.yaml, or a data set's folder.", metavar="FILE")],
) -> None:
    """Prints a result or a data set, and what a data set lacks."""
    with told_errors(_Settings.debug):
        if file.is_dir() or file.name == FILE_NAME:
            dataset = Dataset.open(file if file.is_dir() else file.parent)
            out.print(dataset_table(dataset))
            problems = dataset.problems()
            for problem in problems:
                err.print(f"[yellow]note:[/] {escape(problem)}")
            if problems:
                raise typer.Exit(int(Exit.BAD_FILE))
            return
        calibration = Calibration.load(file)
        out.print(calibration_table(calibration, str(file)))
        out.print(escape(calibration_summary(calibration)))


def _cell_config(seed: int, robot: str) -> CellConfig:
    from ..simulation import CellConfig

    try:
        return CellConfig.model_validate({"seed": seed, "robot": robot})
    except ValueError as error:
        raise typer.BadParameter(str(error), param_hint="--robot") from error


def _board(text: str) -> BoardSpec:
    try:
        return BoardSpec.parse(text)
    except ValueError as error:
        raise typer.BadParameter(str(error), param_hint="--board") from error


def _options(
    config: Path | None, camera: Path | None, distortion: Path | None, given: dict[str, Any]
) -> CalibrationOptions:
    """Settings from the file, then what the command line says on top."""
    keys = read_yaml(config, "settings") if config is not None else {}
    keys |= {key: value for key, value in given.items() if value is not None}
    if camera is not None:
        keys["camera_matrix"], keys["distortion_coefficients"] = read_camera(camera)
    elif distortion is not None:
        keys["distortion_coefficients"] = read_camera(distortion)[1]
    return validate(CalibrationOptions, keys, config or Path("command line"))


def _print_problems(comparison: Comparison) -> None:
    names: dict[str, list[str]] = {}
    for row in comparison.rows:
        names.setdefault(row.problem, []).append(row.name)
    for problem, methods in names.items():
        if problem:
            err.print(f"[yellow]{escape('; '.join(methods))}:[/] {escape(problem)}")
