# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The arguments of the commands, with their help."""

from __future__ import annotations

from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

STATUS_HELP = (
    "[bold]Exit status:[/] 0 usable result, 1 internal error, 2 wrong usage, 3 the data cannot answer, "
    "4 a file that cannot be used, 5 result beyond its limits (demo), not usable (calibrate) or not valid (verify), "
    "6 robot, camera or laser stopped or refused, 130 interrupted."
)


class LensModel(str, Enum):
    """Choices of --lens; the names of `calibration_format.LENS_NAMES`."""

    AUTO = "auto"
    NONE = "none"
    K1 = "k1"
    K1_K2 = "k1-k2"
    TANGENTIAL = "tangential"
    K3 = "k3"


class Motion(str, Enum):
    """Choices of --motion: those of `simulation.CellConfig` over the workbench."""

    DEFAULT = "default"
    CHECK = "check"
    SCAN = "scan"


Dataset = Annotated[Path, typer.Argument(help="Folder with dataset.yaml.", metavar="DATASET")]
NewDataset = Annotated[Path, typer.Argument(help="Folder for the data set, a new one.", metavar="DATASET")]
ShownFile = Annotated[Path, typer.Argument(help="A calibration.yaml, or a data set's folder.", metavar="FILE")]

Output = Annotated[Path, typer.Option("--output", "-o", help="Folder for everything the demo writes.")]
Seed = Annotated[int, typer.Option(min=0, help="Seed of the simulated cell: same seed, same images.")]
Robot = Annotated[str, typer.Option(help="Simulated robot: denso_vp6242 or ur5e.")]
Truth = Annotated[Path | None, typer.Option(help="File for the truth; default: DATASET-truth.yaml.")]
MotionChoice = Annotated[
    Motion,
    typer.Option(help="default: 14 stops to calibrate; check: 5 others to verify; scan: 40 in a line to scan."),
]
BumpMm = Annotated[float, typer.Option(min=0, help="Push the camera out of its mounting by this many mm.")]
BumpDeg = Annotated[float, typer.Option(min=0, help="Turn the camera in its mounting by this many degrees.")]

Result = Annotated[Path, typer.Option("--output", "-o", help="Result file.")]
Camera = Annotated[
    Path | None, typer.Option(help="Known camera: a file with camera_matrix and distortion_coefficients, both kept.")
]
Distortion = Annotated[Path | None, typer.Option(help="Known distortion only, from such a file; K is estimated.")]
Lens = Annotated[
    LensModel | None,
    typer.Option(help="Distortion to estimate; auto (default): the smallest model that the data do not contradict."),
]
Skew = Annotated[bool, typer.Option("--skew", help="Estimate skew too (default: zero).")]
SquarePixels = Annotated[bool, typer.Option("--square-pixels", help="Assume fx = fy.")]
ExactRobot = Annotated[bool, typer.Option("--exact-robot", help="Take the robot's poses as exact.")]
RobotMm = Annotated[float | None, typer.Option(min=0, help="Known noise of the robot's position per axis, mm.")]
RobotDeg = Annotated[float | None, typer.Option(min=0, help="Known noise of the robot's orientation per axis, deg.")]
Partial = Annotated[
    bool, typer.Option("--allow-partial", help="Answer in part: robots that turn about one axis (SCARA) or none.")
]
Laser = Annotated[bool, typer.Option("--laser/--no-laser", help="Use laser images where there are some.")]
Track = Annotated[bool, typer.Option("--track", help="Track the images even where image points are stored.")]
Config = Annotated[Path | None, typer.Option(help="YAML file with settings; the command line overrides it.")]
Pictures = Annotated[Path | None, typer.Option(help="Folder for pictures of tracks, motion and stripe.")]
Rerun = Annotated[
    Path | None, typer.Option("--rerun", help="Recording for the rerun viewer, .rrd: all of it in 3-D (extra viz).")
]
Report = Annotated[Path | None, typer.Option(help="HTML report; default: report.html beside the result.")]
NoReport = Annotated[bool, typer.Option("--no-report", help="Write no HTML report.")]

BOARD_HELP = (
    "Board in the images, sizes in mm: chessboard:8x6:28.5 (inner corners, square), circles:10x10:24.8, "
    "charuco:9x6:40:35:DICT_4X4_250 (squares, square, marker), or points (stored in the data set)."
)
Board = Annotated[str, typer.Option(help=BOARD_HELP)]
ReportBoard = Annotated[
    str | None, typer.Option("--board", help="Compare with OpenCV in the report, on a board as in compare --help.")
]
Score = Annotated[Path | None, typer.Option(help="Score this result instead of calibrating again.")]
Verified = Annotated[Path, typer.Option(help="The calibration in question.")]
Applied = Annotated[Path, typer.Option(help="The calibration to measure with; it needs a light plane.")]
Cloud = Annotated[Path, typer.Option("--output", "-o", help="PLY file for the point cloud.")]
CloudPicture = Annotated[Path | None, typer.Option("--picture", help="PNG file for a picture of the cloud.")]
MaxSigmaMm = Annotated[
    float | None, typer.Option(min=0, help="Leave out points whose standard deviation is larger, mm (default: none).")
]
SeamTable = Annotated[Path, typer.Option("--output", "-o", help="CSV file for the path of the seam, mm.")]
SeamCloud = Annotated[Path | None, typer.Option("--ply", help="PLY file for the same path, m.")]
OpeningDeg = Annotated[float, typer.Option(min=1, max=179, help="Angle between the faces of the groove, degrees.")]
ToleranceDeg = Annotated[float, typer.Option(min=0.1, max=90, help="By which that angle may be off, degrees.")]
Points = Annotated[
    Path,
    typer.Option(help="CSV file: name,view,u,v (px) and, where known, sigma (px, along the stripe), x,y,z (mm)."),
]
Measured = Annotated[Path | None, typer.Option("--output", "-o", help="CSV file for the measured points.")]
Picture = Annotated[Path | None, typer.Option(help="PNG file for a picture of the errors of all views.")]
