# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What comes out on recorded data of real robots, beside OpenCV's methods, as it is.

There is no truth here. The board stood still, so each result is judged by how much the board seems to move in the
base frame: RMS of its positions and angles about their mean, and RMS distance of its corners from where the mean board
should be seen. Robots are not perfect: 1 to 3 px remain with any calibration that takes their poses as exact.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

import cv_active_handeye as cah
from cv_active_handeye.config import CalibrationOptions
from cv_active_handeye.dataset import Dataset
from cv_active_handeye.workflow import BoardSpec, Comparison, compare
from cv_active_handeye.workflow.boards import find_board
from cv_active_handeye.workflow.compare import MethodResult, score_hand_eye

from .real_laser import laser_table
from .report import Cell, Report, Table, finish, parser

REPOSITORY = Path(__file__).parents[1]
SOURCES = {
    "tabb": ("tabb_denso", "tabb_denso_dataset1"),
    "indcal": ("indcal", "indcal_10x10"),
    "etna main": ("etna", "etna_abb_laser/main"),
    "etna calib1": ("etna", "etna_abb_laser/calib1"),
    "etna calib2": ("etna", "etna_abb_laser/calib2"),
    "ardoo": ("ardoo", "ardoo_ur_charuco"),
}
TRACKED = ("tabb", "indcal")
BOARD = BoardSpec.parse("points")
NOTES = {
    "tabb": "The translations run mostly along one axis and the robot misses its poses by far more than image noise: "
    "without a known camera these data say little about K, and what K gets wrong goes into t. The large residual of "
    "the turns (3.6 px) tells so.",
    "indcal": "All turns are small or about nearly the same axis: t along the optical axis is weak with every method.",
}


def import_source(name: str, root: Path, folder: Path) -> Dataset:
    """Runs the importer of samples/python as a user would."""
    importer, source = SOURCES[name]
    script = REPOSITORY / f"samples/python/import_{importer}.py"
    target = folder / name.replace(" ", "_")
    subprocess.run([sys.executable, script, root / source, target], check=True, stdout=subprocess.DEVNULL)
    return Dataset.open(target)


def turns_only(dataset: Dataset, comparison: Comparison) -> MethodResult:
    """For recordings without pure translations: t alone from the changes of orientation, K and R from OpenCV (Park)."""
    name = "calibrateHandEyeRotation, R of PARK"
    park = next(row for row in comparison.rows if row.name.endswith("PARK"))
    if park.R_cam2gripper is None:
        return MethodResult(name, problem=park.problem)
    K, D = comparison.camera.camera_matrix, comparison.camera.distortion
    points, objects = find_board(dataset, BOARD, lambda done, total: None)
    R, t = dataset.R_gripper2base, dataset.t_gripper2base
    try:
        _, position, _ = cah.calibrateHandEyeRotation(R, t, points, K, D, park.R_cam2gripper)
    except cah.error as error:
        return MethodResult(name, problem=str(error))
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = park.R_cam2gripper, position.reshape(3)
    return score_hand_eye(name, dataset, points, objects, comparison.camera.views, K, D, X)


def rows_of(dataset: Dataset, tracked: bool) -> tuple[Comparison, list[MethodResult]]:
    """OpenCV's methods, ours on the same corners, and where asked ours on tracks of the whole images."""
    comparison = compare(dataset, BOARD)
    rows = list(comparison.rows)
    if all(row.problem for row in rows if row.name.startswith("ours")):
        rows.append(turns_only(dataset, comparison))
    if tracked:
        again = compare(dataset, BOARD, CalibrationOptions(track_images=True)).rows
        rows += [replace(row, name=f"{row.name}, tracks") for row in again if row.name.startswith("ours")]
    return comparison, rows


def method_table(name: str, dataset: Dataset, comparison: Comparison, rows: list[MethodResult]) -> Table:
    """One line a method; what refused is quoted below."""
    lines: list[list[Cell]] = []
    for row in rows:
        if row.R_cam2gripper is None or row.t_cam2gripper is None:
            lines.append([row.name, "refused", None, None, None, None])
            continue
        K = comparison.camera.camera_matrix if row.camera is None else row.camera[0]
        position = " ".join(f"{1000 * x:.1f}" for x in row.t_cam2gripper)
        lines.append([row.name, position, float(K[0, 0]), row.spread_mm, row.spread_deg, row.reprojection_px])
    columns = ("method", "t_cam2gripper [mm]", "fx [px]", "spread [mm]", "spread [deg]", "misses [px]")
    groups = np.unique(cah.groupViews(dataset.R_gripper2base), return_counts=True)[1]
    sizes = ", ".join(str(n) for n in sorted(groups[groups > 1], reverse=True)) or "none"
    title = f"{name}: {len(dataset)} views, groups of equal orientation: {sizes}"
    reasons: dict[str, list[str]] = {}
    for row in rows:
        reasons.setdefault(row.problem, []).append(row.name)
    quoted = [f"{' and '.join(methods)}: {text}" for text, methods in reasons.items() if text]
    return Table(title, columns, lines, "\n\n".join([NOTES.get(name, ""), *quoted]).strip())


def measure(root: Path, names: Sequence[str]) -> Report:
    """All sources that are there."""
    tables = []
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            dataset = import_source(name, root, Path(folder))
            comparison, rows = rows_of(dataset, name in TRACKED)
            tables.append(method_table(name, dataset, comparison, rows))
            if any(view.laser_image is not None for view in dataset.views):
                tables.append(laser_table(name, dataset, comparison.camera))
    setup = (
        "OpenCV: calibrateCamera and calibrateHandEye on the corners of the board. ours: the refinement on the same "
        "corners without knowing the board, K unknown, lens model chosen by its test; on the board: knowing where the "
        "corners are on it; tracks: on tracked points of the whole images instead of corners; with a start: "
        "where the closed forms give none, the refinement begins at the camera of the board and the best of OpenCV."
    )
    return Report("Recorded data of real robots", setup, tables)


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    line = parser(__doc__ or "")
    default = os.environ.get("ACTIVE_HANDEYE_DATA", REPOSITORY / "../shared/data")
    line.add_argument("--data", type=Path, default=Path(default), help="folder with the recorded data")
    line.add_argument("--only", choices=SOURCES, action="append", help="one source, may be repeated")
    options = line.parse_args(arguments)
    if not options.data.is_dir():
        print(f"real_data: no recorded data in {options.data}; set ACTIVE_HANDEYE_DATA. Nothing measured.")
        return 0
    return finish(measure(options.data, options.only or list(SOURCES)), options.output)


if __name__ == "__main__":
    sys.exit(main())
