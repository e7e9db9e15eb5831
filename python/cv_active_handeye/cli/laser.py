# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The commands that measure with a calibrated line laser."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..calibration import Calibration
from ..dataset import Dataset
from ..measured_points import read_point_rows, write_measured
from ..report.cloud_picture import picture_cloud
from ..workflow.laser_files import write_cloud, write_seam_cloud, write_seam_table
from ..workflow.measure import MeasuredPoint
from ..workflow.measure import measure as run_measurement
from ..workflow.scan import scan as run_scan
from ..workflow.seam import GrooveShape, find_seam
from . import arguments
from .application import Settings, command, print_lines
from .console import out, terminal_reporter, told_errors
from .results import measured_lines, scan_lines, seam_lines
from .tables import differences_table, measured_table


@command(
    "scan out/scan --calibration out/demo/calibration.yaml -o cloud.ply",
    "scan out/scan --calibration out/demo/calibration.yaml --picture cloud.png --max-sigma-mm 0.3",
)
def scan(
    dataset: arguments.Dataset,
    calibration: arguments.Applied = Path("calibration.yaml"),
    output: arguments.Cloud = Path("cloud.ply"),
    picture: arguments.CloudPicture = None,
    max_sigma_mm: arguments.MaxSigmaMm = None,
) -> None:
    """Turns laser images into a point cloud in the robot's base frame: one profile a view, a point for every column.

    The laser-off image of a view, where there is one, removes the texture under the stripe and makes its points better.
    Every point carries its standard deviation in the worst direction, from stripe, calibration and robot. The cloud is
    a PLY file in metres for CloudCompare, Open3D, MeshLab or trimesh. Without a robot: simulate --motion scan.
    """
    with terminal_reporter() as reporter, told_errors(Settings.debug, reporter):
        limit = None if max_sigma_mm is None else max_sigma_mm / 1000
        result = run_scan(Dataset.open(dataset), Calibration.load(calibration), limit, reporter)
        write_cloud(output, result)
        if picture is not None:
            picture_cloud(picture, result.points, result.sigmas)
    print_lines(*scan_lines(result), f"Written to {output}", *([f"Picture: {picture}"] if picture is not None else []))


@command(
    "seam out/scan --calibration out/demo/calibration.yaml -o seam.csv",
    "seam out/scan --calibration out/demo/calibration.yaml --opening-deg 60 --ply seam.ply --picture seam.png",
)
def seam(
    dataset: arguments.Dataset,
    calibration: arguments.Applied = Path("calibration.yaml"),
    output: arguments.SeamTable = Path("seam.csv"),
    ply: arguments.SeamCloud = None,
    picture: arguments.CloudPicture = None,
    opening_deg: arguments.OpeningDeg = GrooveShape.opening_deg,
    tolerance_deg: arguments.ToleranceDeg = GrooveShape.tolerance_deg,
) -> None:
    """Finds the root of a V-groove in every profile of a scan: the path of a weld seam in the robot's base frame.

    The two faces of the groove are continued as lines until they meet, so that a root gap or a rounded root does not
    matter. The opening angle is that in the light plane, which is a little smaller than the joint's where the laser
    crosses it at a slant. Every point carries its 95 % interval, from stripe, calibration and robot.
    """
    with terminal_reporter() as reporter, told_errors(Settings.debug, reporter):
        recording, used = Dataset.open(dataset), Calibration.load(calibration)
        result = find_seam(recording, used, GrooveShape(opening_deg, tolerance_deg), reporter)
        write_seam_table(output, result)
        if ply is not None:
            write_seam_cloud(ply, result)
        if picture is not None:
            cloud = run_scan(recording, used, None, reporter)
            picture_cloud(picture, cloud.points, cloud.sigmas, path=result.points)
    written = [str(output), *(str(path) for path in (ply, picture) if path is not None)]
    print_lines(*seam_lines(result), f"Written to {', '.join(written)}")


@command(
    "measure out/scan --calibration out/demo/calibration.yaml --points points.csv",
    "measure out/scan --calibration out/demo/calibration.yaml --points points.csv -o measured.csv",
)
def measure(
    dataset: arguments.Dataset,
    points: arguments.Points,
    calibration: arguments.Applied = Path("calibration.yaml"),
    output: arguments.Measured = None,
) -> None:
    """Measures named points of the stripe: coordinates in the robot's base frame with 95 % intervals.

    The points file has a row for every point and view: name,view,u,v, with u,v a pixel of the laser image near the
    stripe. The point lies on the straight piece of the stripe next to it, at column u (row v for a vertical stripe).
    Rows of one name are one point seen in several views, and are averaged. With columns x,y,z (mm, from touching the
    point with the robot, for instance) the differences are printed, too.
    """
    with terminal_reporter() as reporter, told_errors(Settings.debug, reporter):
        rows = read_point_rows(points)
        found = run_measurement(Dataset.open(dataset), Calibration.load(calibration), rows, reporter)
        if output is not None:
            output.parent.mkdir(parents=True, exist_ok=True)
            write_measured(output, *_csv(found))
    out.print(measured_table(found))
    if any(point.reference is not None for point in found):
        out.print(differences_table(found))
    print_lines(*measured_lines(found), *([f"Written to {output}"] if output is not None else []))


def _csv(points: list[MeasuredPoint]) -> tuple[list[str], list[list[str]]]:
    """Header and rows of measured.csv, mm; differences stay empty where there is no reference."""
    ends = [f"{axis}_{end}" for axis in "xyz" for end in ("lower", "upper")]
    header = ["name", "views", "x", "y", "z", *ends, "dx", "dy", "dz", "distance"]
    rows = []
    for point in points:
        half = point.half_widths
        intervals = np.column_stack([point.position - half, point.position + half]).reshape(-1)
        values = [*point.position, *intervals]
        if point.difference is not None:
            values += [*point.difference, np.linalg.norm(point.difference)]
        texts = [f"{1000 * value:.6f}" for value in values]
        empty = [""] * (len(header) - 2 - len(texts))
        rows.append([point.name, " ".join(map(str, point.views)), *texts, *empty])
    return header, rows
