# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The commands about calibrations and data sets, and their arguments; those that measure are in `laser`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import typer
from rich.markup import escape

from ..calibration import Calibration
from ..config import CalibrationOptions
from ..dataset import FILE_NAME, Dataset
from ..report import picture_view_errors
from ..report.rerun_log import require_rerun, write_rerun
from ..workflow import Comparison, calibrate_with_evidence
from ..workflow import compare as run_comparison
from ..workflow.pictures import draw_pictures
from ..workflow.reporting import report_calibration
from ..workflow.verify import verify as run_verification
from . import arguments
from .application import Settings, app, command, print_lines
from .console import Exit, err, out, terminal_reporter, told_errors
from .results import joint_lines, result_lines, seam_lines, verdict_text, verification_lines
from .settings import board_spec, calibration_options, cell_config
from .tables import (
    ROTATION_NOTE,
    calibration_table,
    cameras_table,
    dataset_table,
    demo_table,
    hand_eye_table,
    inside_text,
    limits_table,
    scores_table,
    stripe_groups_table,
    verification_table,
)

__all__ = ["app"]


@command("demo", "demo --seed 3 --output out/demo")
def demo(
    output: arguments.Output = Path("out/demo"), seed: arguments.Seed = 0, robot: arguments.Robot = "denso_vp6242"
) -> None:
    """Simulates a recording, calibrates from the images alone, measures a weld joint, and compares with the truth.

    Writes the data set, truth.yaml (outside of the data set), calibration.yaml, report.html and pictures; of the weld
    joint the scan, its point cloud scan.ply, and the seam's path seam.csv and seam.ply.
    """
    with terminal_reporter() as reporter, told_errors(Settings.debug, reporter):
        from ..workflow.demo import demo as run_demo

        result = run_demo(output, cell_config(seed=seed, robot=robot), reporter)
    out.print(demo_table(result))
    print_lines(inside_text(result), ROTATION_NOTE)
    out.print(limits_table(result))
    print_lines(verdict_text(result.calibration), *result_lines(result.calibration))
    print_lines("", *seam_lines(result.joint.seam), *joint_lines(result.joint))
    print_lines(f"Written to {output}: dataset/, truth.yaml, calibration.yaml, pictures/, scan.ply, seam.ply, seam.csv")
    print_lines(f"Report: {result.report}")
    beyond = result.beyond_limits()
    if beyond:
        err.print(f"[bold red]error:[/] beyond the limits: {', '.join(beyond)}")
        raise typer.Exit(int(Exit.BEYOND_LIMITS))


@command(
    "simulate out/cell",
    "simulate out/check --motion check",
    "simulate out/bumped --motion check --bump-mm 0.5",
    "simulate out/scan --motion scan",
)
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

    The same seed is the same cell. With --motion check it is visited again, at other stops, for verify; with --motion
    scan the laser is moved across the bench, for scan and measure; with --bump-mm or --bump-deg its camera has been
    pushed since.
    """
    truth_file = truth or dataset.with_name(f"{dataset.name}-truth.yaml")
    if dataset.resolve() in truth_file.resolve().parents:
        raise typer.BadParameter(f"needs a place outside of {dataset}, given {truth_file}", param_hint="--truth")
    config = {"seed": seed, "robot": robot, "motion": motion.value, "bump_mm": bump_mm, "bump_deg": bump_deg}
    with terminal_reporter() as reporter, told_errors(Settings.debug, reporter):
        from ..workflow.simulate import simulate as run_simulation

        recorded, _ = run_simulation(dataset, truth_file, cell_config(**config), reporter)
    print_lines(f"{len(recorded)} views in {dataset}, the truth in {truth_file}")


@command(
    "calibrate out/cell -o out/calibration.yaml",
    "calibrate out/cell --lens k1-k2 --no-laser",
    "calibrate out/cell --camera camera.yaml --robot-mm 0.02 --robot-deg 0.005",
)
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
    rerun: arguments.Rerun = None,
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
    spec = board_spec(board) if board is not None else None
    page = None if no_report else report or output.with_name("report.html")
    with terminal_reporter() as reporter, told_errors(Settings.debug, reporter):
        options = calibration_options(config, camera, distortion, given)
        if rerun is not None:
            require_rerun()
        recording = Dataset.open(dataset)
        result, evidence = calibrate_with_evidence(recording, options, reporter)
        output.parent.mkdir(parents=True, exist_ok=True)
        result.save(output)
        if pictures is not None:
            draw_pictures(pictures, recording, result, evidence)
        if rerun is not None and evidence.summary is not None:
            write_rerun(rerun, recording, result, evidence)
        if page is not None:
            report_calibration(page, recording, result, evidence, reporter, spec)
    _print_calibration(result, str(output))
    if evidence.summary is not None and result.light_plane is not None:
        out.print(stripe_groups_table(evidence.summary))
    print_lines(f"Written to {output}", *([f"Report: {page}"] if page is not None else []))
    print_lines(*([f"In three dimensions: rerun {rerun}"] if rerun is not None else []))
    if result.verdict is not None and not result.verdict.usable:
        raise typer.Exit(int(Exit.BEYOND_LIMITS))


@command(
    "verify out/check --calibration out/calibration.yaml",
    "verify out/check --calibration out/calibration.yaml --picture errors.png",
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
    with terminal_reporter() as reporter, told_errors(Settings.debug, reporter):
        options = CalibrationOptions(track_images=track)
        result = run_verification(Dataset.open(dataset), Calibration.load(calibration), options, reporter)
        if picture is not None:
            errors = np.array([(row.error_px, row.expected_px) for row in result.views])
            picture_view_errors(picture, errors[:, 0], errors[:, 1], result.summary.contradictingViews)
    out.print(verification_table(result))
    print_lines(*verification_lines(result))
    if not result.valid:
        raise typer.Exit(int(Exit.BEYOND_LIMITS))


@command(
    "compare out/tabb --board chessboard:8x6:28.5",
    "compare out/tabb --board points --calibration out/calibration.yaml",
)
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
    spec = board_spec(board)
    with terminal_reporter() as reporter, told_errors(Settings.debug, reporter):
        recording = Dataset.open(dataset)
        options = calibration_options(None, camera, distortion, {"track_images": True if track else None})
        given = Calibration.load(calibration) if calibration is not None else None
        comparison = run_comparison(recording, spec, options, reporter, given)
    out.print(cameras_table(comparison))
    out.print(hand_eye_table(comparison))
    out.print(scores_table(comparison))
    _print_problems(comparison)
    if all(row.problem for row in comparison.rows if not row.name.startswith("OpenCV")):
        raise typer.Exit(int(Exit.INSUFFICIENT_DATA))


@command("show out/calibration.yaml", "show out/cell")
def show(file: arguments.ShownFile) -> None:
    """Prints a result or a data set, and what a data set lacks."""
    with told_errors(Settings.debug):
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


def _print_calibration(calibration: Calibration, title: str) -> None:
    unusable = calibration.verdict is not None and not calibration.verdict.usable
    out.print(calibration_table(calibration, title))
    print_lines(ROTATION_NOTE)
    out.print(escape(verdict_text(calibration)), style="bold red" if unusable else "bold")
    print_lines(*result_lines(calibration))


def _print_problems(comparison: Comparison) -> None:
    names: dict[str, list[str]] = {}
    for row in comparison.rows:
        names.setdefault(row.problem, []).append(row.name)
    for problem, methods in names.items():
        if problem:
            err.print(f"[yellow]{escape('; '.join(methods))}:[/] {escape(problem)}")
