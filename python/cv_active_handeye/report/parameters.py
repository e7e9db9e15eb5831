# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The calibrated parameters with their 95 % intervals, in mm, degrees and pixels, and as text to copy."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np

from ..calibration import Calibration
from ..files import FloatArray
from .errors import rotation_vector_deg
from .inputs import ReportInput, column
from .words import two_digits

DISTORTION = ("k1", "k2", "p1", "p2", "k3")
ROTATION = ("rx", "ry", "rz")
GROUPS = {
    "Camera": ("fx", "fy", "cx", "cy", "skew"),
    "Lens": DISTORTION,
    "Rotation of the camera in the gripper": ROTATION,
    "Position of the camera in the gripper": ("tx", "ty", "tz"),
    "Light plane in the camera": ("nx", "ny", "nz", "d"),
}
UNITS = dict.fromkeys(GROUPS["Camera"], "px") | dict.fromkeys(ROTATION, "deg")
UNITS |= dict.fromkeys(("tx", "ty", "tz", "d"), "mm")
SCALES = {"px": 1.0, "": 1.0, "deg": math.degrees(1), "mm": 1000.0}


class Parameter(NamedTuple):
    """One row: `value` and `half` (half of the 95 % interval) are shown; the numbers behind them are for copying.

    A rotation vector's interval is that of the error angle about the gripper's axis, so it has no ends of its own.
    """

    name: str
    value: str
    half: str
    interval: str
    unit: str
    state: Literal["estimated", "kept", "unobserved"]
    exact: tuple[float, float, float]


def parameter_values(calibration: Calibration) -> dict[str, float]:
    """Every parameter by name in the units of the page; the light plane only where there is one."""
    K, D = calibration.camera_matrix, calibration.distortion_coefficients
    values = {"fx": K[0, 0], "fy": K[1, 1], "cx": K[0, 2], "cy": K[1, 2], "skew": K[0, 1]}
    values |= dict(zip(DISTORTION, np.append(D, 0.0), strict=False))
    values |= dict(zip(ROTATION, rotation_vector_deg(calibration.R_cam2gripper), strict=True))
    values |= dict(zip(("tx", "ty", "tz"), 1000 * calibration.t_cam2gripper, strict=True))
    if calibration.light_plane is not None:
        values |= dict(zip(("nx", "ny", "nz", "d"), calibration.light_plane * [1, 1, 1, 1000], strict=True))
    return {name: float(value) for name, value in values.items()}


def parameter_groups(case: ReportInput) -> dict[str, list[Parameter]]:
    """The rows of the table under their headings; groups of which nothing is known are left out."""
    values = parameter_values(case.calibration)
    names = list(case.summary.parameterNames)
    sigmas = column(case.summary.standardDeviations)
    intervals = np.asarray(case.summary.intervals95, np.float64).reshape(-1, 2)
    groups = {}
    for title, members in GROUPS.items():
        known = [name for name in members if name in values and name in names]
        found = [_row(name, values[name], sigmas[names.index(name)], intervals[names.index(name)]) for name in known]
        if found:
            groups[title] = found
    return groups


def _row(name: str, value: float, sigma: float, interval: FloatArray) -> Parameter:
    unit = UNITS.get(name, "")
    if sigma == 0:
        return Parameter(name, f"{value:.6g}", "kept", "", unit, "kept", (value, value, value))
    if not math.isfinite(sigma):
        return Parameter(name, f"{value:.6g}", "not observed", "", unit, "unobserved", (value, -math.inf, math.inf))
    lower, upper = (float(end) * SCALES[unit] for end in interval)
    half = (upper - lower) / 2
    if name in ROTATION:
        lower, upper = value + lower, value + upper
    shown = two_digits(half)
    digits = len(shown.partition(".")[2])
    ends = f"about the gripper's {name[1]}" if name in ROTATION else f"{lower:.{digits}f} to {upper:.{digits}f}"
    return Parameter(name, f"{value:.{digits}f}", f"± {shown}", ends, unit, "estimated", (value, lower, upper))


def table_text(groups: dict[str, list[Parameter]]) -> str:
    """All rows with all digits, separated by tabs, as a spreadsheet takes them."""
    lines = ["parameter\tvalue\tlower 95 %\tupper 95 %\tunit"]
    for row in (row for rows in groups.values() for row in rows):
        lines.append("\t".join([row.name, *(repr(number) for number in row.exact), row.unit]))
    return "\n".join(lines)


def matrices_text(calibration: Calibration) -> str:
    """The matrices as Python, in metres and pixels, with all digits."""
    matrices = {
        "camera_matrix": calibration.camera_matrix,
        "distortion_coefficients": calibration.distortion_coefficients,
        "R_cam2gripper": calibration.R_cam2gripper,
        "t_cam2gripper": calibration.t_cam2gripper,
    }
    if calibration.light_plane is not None:
        matrices["light_plane"] = calibration.light_plane
    return "\n".join(f"{name} = {_python(values)}" for name, values in matrices.items())


def _python(values: FloatArray) -> str:
    if values.ndim == 1:
        return f"[{', '.join(repr(float(x)) for x in values)}]"
    rows = ",\n    ".join(_python(row) for row in values)
    return f"[\n    {rows},\n]"
