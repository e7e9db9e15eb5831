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
from ..files import FloatArray
from ..report.errors import rotation_vector_deg
from ..workflow import Comparison

if TYPE_CHECKING:
    from ..workflow.demo import DemoResult

SIGMA_NOTE = "* from image noise and jitter of the robot's orientations; the earlier steps are taken as exact"

Values = dict[str, tuple[float, str, int]]
"""Name -> (value, unit, digits after the point)."""


def _values(K: FloatArray, R: FloatArray, t: FloatArray, plane: FloatArray | None) -> Values:
    rows: Values = {
        "fx": (K[0, 0], "px", 2),
        "fy": (K[1, 1], "px", 2),
        "cx": (K[0, 2], "px", 2),
        "cy": (K[1, 2], "px", 2),
    }
    rows |= {f"R_cam2gripper r{axis}": (x, "deg", 4) for axis, x in zip("xyz", rotation_vector_deg(R), strict=True)}
    rows |= {f"t_cam2gripper {axis}": (1000 * x, "mm", 3) for axis, x in zip("xyz", t, strict=True)}
    if plane is not None:
        rows |= {f"light plane n{axis}": (x, "", 5) for axis, x in zip("xyz", plane[:3], strict=True)}
        rows["light plane d"] = (1000 * plane[3], "mm", 3)
    return rows


def _sigmas(calibration: Calibration) -> dict[str, float]:
    """Standard deviations in the units of `_values`, for what was estimated."""

    def sigma(name: str, scale: float) -> float:
        return scale * calibration.standard_deviation(name) if name in calibration.parameter_names else math.nan

    found = {name: sigma(name, 1.0) for name in ("fx", "fy", "cx", "cy")}
    found |= {f"R_cam2gripper r{axis}": sigma(f"r{axis}", math.degrees(1)) for axis in "xyz"}
    found |= {f"t_cam2gripper {axis}": sigma(f"t{axis}", 1000.0) for axis in "xyz"}
    found |= {f"light plane n{axis}": sigma(f"n{axis}", 1.0) for axis in "xyz"}
    return found | {"light plane d": sigma("d", 1000.0)}


def _table(title: str, *columns: str) -> Table:
    table = Table(title=escape(title), title_justify="left", box=box.SIMPLE_HEAD)
    for number, column in enumerate(columns):
        table.add_column(escape(column), justify="left" if number == 0 else "right", no_wrap=True)
    return table


def calibration_table(calibration: Calibration, title: str = "calibration") -> Table:
    """Every estimated quantity with its standard deviation; 0 where it was given and kept."""
    table = _table(title, "quantity", "estimate", "1 sigma*", "unit")
    values = _values(
        calibration.camera_matrix, calibration.R_cam2gripper, calibration.t_cam2gripper, calibration.light_plane
    )
    sigmas = _sigmas(calibration)
    for name, (value, unit, digits) in values.items():
        sigma = sigmas[name]
        table.add_row(name, f"{value:.{digits}f}", "known" if sigma == 0 else f"{sigma:.{digits}f}", unit)
    return table


def calibration_summary(calibration: Calibration) -> str:
    """What the sigmas mean, residuals and counts in three lines."""
    rms = calibration.rms
    parts = [f"translations {rms.translations_px:.3f} px", f"rotation {rms.rotation_px:.3f} px"]
    if rms.light_plane_px is not None:
        parts.append(f"light plane {rms.light_plane_px:.3f} px")
    seen = f"{calibration.views} views, {calibration.points} points, {calibration.observations} observations"
    stripes = f", {calibration.stripe_segments} stripe segments" if calibration.stripe_segments else ""
    constraints = f"constraints: {', '.join(calibration.constraints)}"
    return f"{SIGMA_NOTE}\nRMS residuals: {', '.join(parts)}\n{seen}{stripes}; {constraints}"


def demo_table(result: DemoResult) -> Table:
    """Estimate, truth and error of every quantity, then the errors that have limits."""
    table = _table("estimate against truth", "quantity", "estimate", "truth", "error", "1 sigma*", "unit")
    found, truth = result.calibration, result.truth
    estimates = _values(found.camera_matrix, found.R_cam2gripper, found.t_cam2gripper, found.light_plane)
    truths = _values(truth.camera_matrix, truth.R_cam2gripper, truth.t_cam2gripper, truth.light_plane)
    sigmas = _sigmas(found)
    for name, (value, unit, digits) in estimates.items():
        true = truths[name][0]
        numbers = [f"{value:.{digits}f}", f"{true:.{digits}f}", f"{value - true:+.{digits}f}"]
        table.add_row(name, *numbers, f"{sigmas[name]:.{digits}f}", unit)
    return table


def limits_table(result: DemoResult) -> Table:
    """The errors as sizes, beside the limits that decide the exit status."""
    table = _table("errors", "error", "size", "limit", "unit")
    units = {"percent": "%", "px": "px", "deg": "deg", "mm": "mm"}
    for name, limit in vars(result.limits).items():
        label, _, unit = name.rpartition("_")
        error = getattr(result.errors, name)
        style = "red" if name in result.beyond_limits() else None
        shown = "not found" if error is None else f"{error:.3f}"
        table.add_row(label.replace("_", " "), shown, f"{limit:g}", units[unit], style=style)
    return table


def hand_eye_table(comparison: Comparison) -> Table:
    """R_cam2gripper and t_cam2gripper of every method; those without an answer show a dash."""
    table = _table("hand-eye", "method", "rx ry rz [deg]", "x y z [mm]")
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
    table = _table("how still the board stands in the base frame (RMS)", *columns)
    for row in comparison.rows:
        scores = (row.spread_mm, row.spread_deg, row.reprojection_px)
        if not row.problem:
            table.add_row(row.name, *(f"{x:.2f}" for x in scores if x is not None))
    return table


def cameras_table(comparison: Comparison) -> Table:
    """The camera matrices behind the rows."""
    table = _table("camera", "source", "fx", "fy", "cx", "cy", "distortion")
    cameras = {"OpenCV": (comparison.camera.camera_matrix, comparison.camera.distortion)}
    cameras |= {row.name: row.camera for row in comparison.rows if row.camera is not None}
    for name, (K, D) in cameras.items():
        values = [f"{K[0, 0]:.2f}", f"{K[1, 1]:.2f}", f"{K[0, 2]:.2f}", f"{K[1, 2]:.2f}"]
        table.add_row(name, *values, " ".join(f"{x:.2f}" for x in D) if np.any(D) else "none")
    return table


def dataset_table(dataset: Dataset) -> Table:
    """One row per view: position, orientation group, and what was recorded."""
    table = _table(f"{dataset.folder}", "view", "x y z [mm]", "orientation group", "image", "laser image", "surface")
    groups = cah.groupViews(dataset.R_gripper2base).reshape(-1).tolist() if len(dataset) else []
    for view, group in zip(dataset.views, groups, strict=True):
        position = " ".join(f"{1000 * x:.1f}" for x in view.t_gripper2base)
        surface = "-" if view.surface_id is None else str(view.surface_id)
        table.add_row(str(view.index), position, str(group), _yes(view.image), _yes(view.laser_image), surface)
    return table


def _yes(name: str | None) -> str:
    return "-" if name is None else "yes"
