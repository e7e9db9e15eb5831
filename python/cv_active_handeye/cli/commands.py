# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The commands and their arguments."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer
from pydantic import ValidationError
from rich.markup import escape

import cv_active_handeye as cah

from ..calibration import Calibration, read_camera
from ..config import CalibrationOptions
from ..dataset import FILE_NAME, Dataset
from ..files import read_yaml, validate
from ..report import picture_view_errors
from ..workflow import BoardSpec, Comparison, calibrate_with_evidence
from ..workflow import compare as run_comparison
from ..workflow.pictures import draw_pictures
from ..workflow.reporting import report_calibration
from ..workflow.verify import verify as run_verification
from . import arguments
from .arguments import STATUS_HELP
from .console import Exit, err, out, terminal_reporter, told_errors
from .results import result_lines, verdict_text, verification_lines
from .tables import (
    calibration_table,
    cameras_table,
    dataset_table,
    demo_table,
    hand_eye_table,
    limits_table,
    scores_table,
    verification_table,
)

if TYPE_CHECKING:
    from ..simulation import CellConfig

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


@app.command(epilog="Example: cv-active-handeye demo --seed 3 --output out/demo\n\n" + STATUS_HELP)
def demo(
    output: arguments.Output = Path("out/demo"), seed: arguments.Seed = 0, robot: arguments.Robot = "denso_vp6242"
) -> None:
    """Simulates a recording, calibrates from the images alone, and compares with the truth.

    Writes the data set, truth.yaml (outside of the data set), calibration.yaml, report.html and pictures.
    """
    with terminal_reporter() as reporter, told_errors(_Settings.debug, reporter):
        from ..workflow.demo import demo as run_demo

        result = run_demo(output, _cell_config(seed=seed, robot=robot), reporter)
    out.print(demo_table(result))
    out.print(limits_table(result))
    _print_lines(verdict_text(result.calibration), *result_lines(result.calibration))
    names = "dataset/, truth.yaml, calibration.yaml, report.html, pictures/"
    _print_lines(f"Written to {output}: {names}")
    beyond = result.beyond_limits()
    if beyond:
        err.print(f"[bold red]error:[/] beyond the limits: {', '.join(beyond)}")
        raise typer.Exit(int(Exit.BEYOND_LIMITS))


@app.command(epilog="Example: cv-active-handeye simulate out/cell\n\n" + STATUS_HELP)
def simulate(
    dataset: arguments.NewDataset,
    truth: arguments.Truth = None,
    seed: arguments.Seed = 0,
    robot: arguments.Robot = "denso_vp6242",
    motion: arguments.MotionChoice = arguments.Motion.DEFAULT,
    bump_mm: arguments.BumpMm = 0.0,
    bump_deg: arguments.BumpDeg = 0.0,
) -> None:
    """Records a motion in the simulated cell: a data set like one of a real robot.

    The same seed is the same cell. With --motion check it is visited again, at other stops, for verify; with --bump-mm
    or --bump-deg its camera has been pushed since.
    """
    truth_file = truth or dataset.with_name(f"{dataset.name}-truth.yaml")
    config = {"seed": seed, "robot": robot, "motion": motion.value, "bump_mm": bump_mm, "bump_deg": bump_deg}
    with terminal_reporter() as reporter, told_errors(_Settings.debug, reporter):
        from ..workflow.simulate import simulate as run_simulation

        recorded, _ = run_simulation(dataset, truth_file, _cell_config(**config), reporter)
    _print_lines(f"{len(recorded)} views in {dataset}, the truth in {truth_file}")


@app.command(epilog="Example: cv-active-handeye calibrate out/demo/dataset -o calibration.yaml\n\n" + STATUS_HELP)
def calibrate(
    dataset: arguments.Dataset,
    output: arguments.Result = Path("calibration.yaml"),
    camera: arguments.Camera = None,
    distortion: arguments.Distortion = None,
    lens: arguments.Lens = None,
    skew: arguments.Skew = False,
    square_pixels: arguments.SquarePixels = False,
    exact_robot: arguments.ExactRobot = False,
    robot_mm: arguments.RobotMm = None,
    robot_deg: arguments.RobotDeg = None,
    allow_partial: arguments.Partial = False,
    laser: arguments.Laser = True,
    track: arguments.Track = False,
    config: arguments.Config = None,
    pictures: arguments.Pictures = None,
    board: arguments.ReportBoard = None,
    report: arguments.Report = None,
    no_report: arguments.NoReport = False,
) -> None:
    """Calibrates camera matrix, lens, R_cam2gripper, t_cam2gripper and, with laser images, the light plane.

    Needs pure translations (stops of equal orientation; for an unknown camera four directions, no three in a plane)
    and changes of orientation about two axes. Any textured scene that stands still will do. A result that contradicts
    its data is saved, marked as not usable, and the exit status is 5.
    """
    given = {
        "lens_model": lens.value if lens else None,
        "zero_skew": False if skew else None,
        "square_pixels": square_pixels or None,
        "robot_translation_mm": 0.0 if exact_robot else robot_mm,
        "robot_rotation_deg": 0.0 if exact_robot else robot_deg,
        "allow_partial": allow_partial or None,
        "use_laser": None if laser else False,
        "track_images": track or None,
    }
    spec = _board(board) if board is not None else None
    page = None if no_report else report or output.with_name("report.html")
    with terminal_reporter() as reporter, told_errors(_Settings.debug, reporter):
        options = _options(config, camera, distortion, given)
        recording = Dataset.open(dataset)
        result, evidence = calibrate_with_evidence(recording, options, reporter)
        result.save(output)
        if pictures is not None:
            draw_pictures(pictures, recording, result, evidence)
        if page is not None:
            report_calibration(page, recording, result, evidence, reporter, spec)
    _print_calibration(result, str(output))
    _print_lines(f"Written to {output}" + (f", report: {page}" if page else ""))
    if result.verdict is not None and not result.verdict.usable:
        raise typer.Exit(int(Exit.BEYOND_LIMITS))


@app.command(
    epilog="Example: cv-active-handeye verify out/check --calibration out/demo/calibration.yaml\n\n" + STATUS_HELP
)
def verify(
    dataset: arguments.Dataset,
    calibration: arguments.Verified = Path("calibration.yaml"),
    track: arguments.Track = False,
    picture: arguments.Picture = None,
) -> None:
    """Asks new views whether a calibration is still valid: after a collision, or when the camera was touched.

    Three views or more of any textured scene; more of them, and turns between them, see smaller changes. Every view is
    predicted from the others; errors are judged by the noise levels and the covariance of the calibration.
    """
    with terminal_reporter() as reporter, told_errors(_Settings.debug, reporter):
        options = CalibrationOptions(track_images=track)
        result = run_verification(Dataset.open(dataset), Calibration.load(calibration), options, reporter)
        if picture is not None:
            errors = np.array([(row.error_px, row.expected_px) for row in result.views])
            picture_view_errors(picture, errors[:, 0], errors[:, 1], result.summary.contradictingViews)
    out.print(verification_table(result))
    _print_lines(*verification_lines(result))
    if not result.valid:
        raise typer.Exit(int(Exit.BEYOND_LIMITS))


@app.command(epilog="Example: cv-active-handeye compare out/tabb --board chessboard:8x6:28.5\n\n" + STATUS_HELP)
def compare(
    dataset: arguments.Dataset,
    board: arguments.Board,
    calibration: arguments.Score = None,
    camera: arguments.Camera = None,
    distortion: arguments.Distortion = None,
    track: arguments.Track = False,
) -> None:
    """Runs OpenCV's calibrateCamera and calibrateHandEye (all five methods) on a board, beside ours without it.

    The board stands still, so with a perfect calibration and robot it would not move in the base frame. The columns
    "spread" tell how much it does, "misses" by how many pixels its points miss their places. A board that looks the
    same after a turn may be read turned in some views: prefer ChArUco, or a chessboard with an odd number of rows.
    Where the recording has no pure translations, ours starts from OpenCV's best result.
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
def show(file: arguments.ShownFile) -> None:
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
        _print_calibration(Calibration.load(file), str(file))


def _print_lines(*lines: str) -> None:
    for line in lines:
        out.print(escape(line))


def _print_calibration(calibration: Calibration, title: str) -> None:
    unusable = calibration.verdict is not None and not calibration.verdict.usable
    out.print(calibration_table(calibration, title))
    out.print(escape(verdict_text(calibration)), style="bold red" if unusable else "bold")
    _print_lines(*result_lines(calibration))


def _cell_config(**settings: object) -> CellConfig:
    from ..simulation import CellConfig

    try:
        return CellConfig.model_validate(settings)
    except ValidationError as error:
        hints = [f"--{str(item['loc'][0]).replace('_', '-')}" for item in error.errors()]
        raise typer.BadParameter(str(error), param_hint=hints) from error


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
