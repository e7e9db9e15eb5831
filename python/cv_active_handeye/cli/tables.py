# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Results as tables on the terminal. Lengths are shown in mm, angles in degrees."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from rich import box
from rich.markup import escape
from rich.table import Table

import cv_active_handeye as cah

from ..calibration import Calibration
from ..dataset import Dataset
from ..report import true_parameters
from ..report.errors import rotation_vector_deg
from ..report.parameters import ROTATION, SCALES
from ..report.tables import stripe_groups
from ..report.words import two_digits
from ..workflow import Comparison
from .results import parameter_rows

if TYPE_CHECKING:
    from ..workflow.demo import DemoResult
    from ..workflow.measure import MeasuredPoint
    from ..workflow.verify import Verification

ROTATION_NOTE = "Intervals of R_cam2gripper: error angles about the gripper's axes."


def plain_table(title: str, *columns: str) -> Table:
    """An empty table in the style of all others, the first column to the left."""
    table = Table(title=escape(title), title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False, collapse_padding=True)
    for number, column in enumerate(columns):
        table.add_column(escape(column), justify="left" if number == 0 else "right", no_wrap=True)
    return table


def calibration_table(calibration: Calibration, title: str = "calibration") -> Table:
    """Every estimated quantity with its 95 % interval."""
    unusable = calibration.verdict is not None and not calibration.verdict.usable
    table = plain_table(f"{title}: NOT USABLE" if unusable else title, "quantity", "estimate", "95 % interval", "unit")
    for row in parameter_rows(calibration):
        table.add_row(row.label, f"{row.value:.{row.digits}f}", row.interval, row.unit)
    return table


def stripe_groups_table(summary: cah.RefineSummary) -> Table:
    """What the stripes of each group of equal orientation contribute to the light plane."""
    table = plain_table(
        "light plane: sigmas without the stripes of a group", "without", "segments", "surfaces", "deg", "mm"
    )
    for row in stripe_groups(summary):
        table.add_row(*row)
    return table


def demo_table(result: DemoResult) -> Table:
    """Estimate, truth, error and interval of every quantity; `inside`: whether the interval holds the truth."""
    columns = ("quantity", "estimate", "truth", "error", "± 95 %", "inside", "unit")
    table = plain_table("estimate against truth", *columns)
    turn, inside = rotation_vector_deg(result.truth.R_cam2gripper), result.inside()
    relative = true_parameters(result.calibration, result.truth)
    for row in parameter_rows(result.calibration):
        true = SCALES[row.unit] * relative[row.name]
        error = -true if row.name in ROTATION else row.value - true
        shown = turn[ROTATION.index(row.name)] if row.name in ROTATION else true
        numbers = [f"{row.value:.{row.digits}f}", f"{shown:.{row.digits}f}", f"{error:+.{row.digits}f}"]
        holds = {True: "yes", False: "no", None: "-"}[inside.get(row.name)]
        table.add_row(row.label, *numbers, two_digits(row.half), holds, row.unit)
    return table


def inside_text(result: DemoResult) -> str:
    """How many of the intervals hold the truth."""
    inside = result.inside()
    return f"{sum(inside.values())} of {len(inside)} intervals hold the truth; 95 % are meant to."


def limits_table(result: DemoResult) -> Table:
    """The errors as sizes, beside the limits that decide the exit status."""
    table = plain_table("errors", "error", "size", "limit", "unit")
    units = {"percent": "%", "px": "px", "deg": "deg", "mm": "mm"}
    for name, limit in vars(result.limits).items():
        label, _, unit = name.rpartition("_")
        error = getattr(result.errors, name)
        style = "red" if name in result.beyond_limits() else None
        shown = "not found" if error is None else f"{error:.4f}"
        table.add_row(label.replace("_", " "), shown, f"{limit:g}", units[unit], style=style)
    return table


def verification_table(result: Verification) -> Table:
    """Every view predicted from the others: its error, and what image, robot and calibration noise let expect."""
    columns = ("view", "error [px]", "expected", "error [mm]", "expected", "agrees")
    table = plain_table("new views predicted from each other (RMS)", *columns)
    for row in result.views:
        numbers = (row.error_px, row.expected_px, row.error_mm, row.expected_mm)
        predicted = math.isfinite(row.error_px)
        answer = ("no" if row.contradicts else "yes") if predicted else "not predicted"
        shown = [f"{x:.3f}" if math.isfinite(x) else "-" for x in numbers]
        table.add_row(str(row.view), *shown, answer, style="red" if row.contradicts else None)
    return table


def measured_table(points: list[MeasuredPoint]) -> Table:
    """Coordinates of every point with halves of their 95 % intervals, and the number of views that saw it."""
    table = plain_table("points in the base frame [mm], ± 95 %", "point", "x", "±", "y", "±", "z", "±", "views")
    for point in points:
        halves = ("not observed" if math.isinf(half) else f"{1000 * half:.3f}" for half in point.half_widths)
        pairs = zip((f"{1000 * x:.3f}" for x in point.position), halves, strict=True)
        table.add_row(escape(point.name), *(text for pair in pairs for text in pair), str(len(point.views)))
    return table


def differences_table(points: list[MeasuredPoint]) -> Table:
    """Measured minus reference, of the points that have one, and the length of this vector."""
    table = plain_table("measured minus reference [mm]", "point", "dx", "dy", "dz", "3-D")
    for point in points:
        difference = point.difference
        if difference is not None:
            length = f"{1000 * np.linalg.norm(difference):.3f}"
            table.add_row(escape(point.name), *(f"{1000 * d:+.3f}" for d in difference), length)
    return table


def hand_eye_table(comparison: Comparison) -> Table:
    """R_cam2gripper and t_cam2gripper of every method; those without an answer show a dash."""
    table = plain_table("hand-eye", "method", "rx ry rz [deg]", "x y z [mm]")
    for row in comparison.rows:
        if row.R_cam2gripper is None or row.t_cam2gripper is None:
            table.add_row(row.name, "-", "-")
            continue
        rotation = " ".join(f"{x:.2f}" for x in rotation_vector_deg(row.R_cam2gripper))
        table.add_row(row.name, rotation, " ".join(f"{1000 * x:.1f}" for x in row.t_cam2gripper))
    return table


def scores_table(comparison: Comparison) -> Table:
    """How still the board stands in the base frame with every method that gave an answer."""
    columns = ("method", "spread [mm]", "spread [deg]", "misses [px]")
    table = plain_table("how still the board stands in the base frame (RMS)", *columns)
    for row in comparison.rows:
        scores = (row.spread_mm, row.spread_deg, row.reprojection_px)
        if not row.problem:
            table.add_row(row.name, *(f"{x:.2f}" for x in scores if x is not None))
    return table


def cameras_table(comparison: Comparison) -> Table:
    """The camera matrices behind the rows."""
    table = plain_table("camera", "source", "fx", "fy", "cx", "cy", "distortion")
    table.columns[0].no_wrap = table.columns[-1].no_wrap = False  # rather than digits cut off on a narrow terminal
    cameras = {"OpenCV": (comparison.camera.camera_matrix, comparison.camera.distortion)}
    cameras |= {row.name: row.camera for row in comparison.rows if row.camera is not None}
    for name, (K, D) in cameras.items():
        values = [f"{K[0, 0]:.2f}", f"{K[1, 1]:.2f}", f"{K[0, 2]:.2f}", f"{K[1, 2]:.2f}"]
        table.add_row(name, *values, " ".join(f"{x:.2f}" for x in D) if np.any(D) else "none")
    return table


def dataset_table(dataset: Dataset) -> Table:
    """One row per view: position, orientation group, and what was recorded."""
    table = plain_table(
        f"{dataset.folder}", "view", "x y z [mm]", "orientation group", "image", "laser image", "surface"
    )
    groups = cah.groupViews(dataset.R_gripper2base).reshape(-1).tolist() if len(dataset) else []
    for view, group in zip(dataset.views, groups, strict=True):
        position = " ".join(f"{1000 * x:.1f}" for x in view.t_gripper2base)
        surface = "-" if view.surface_id is None else str(view.surface_id)
        table.add_row(str(view.index), position, str(group), _yes(view.image), _yes(view.laser_image), surface)
    return table


def _yes(name: str | None) -> str:
    return "-" if name is None else "yes"
