# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A calibration on the terminal: its parameters as rows, and what it is worth in sentences."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..calibration import PARAMETERS, Calibration
from ..calibration_format import LENS_NAMES, NoiseLevel, NoiseLevels, Verdict
from ..report.parameters import DISTORTION, ROTATION, SCALES, UNITS, parameter_values
from ..report.verdict import NORMAL_95
from ..report.words import counted, sentence, two_digits, views_listed

if TYPE_CHECKING:
    from cv_active_handeye import VerifySummary

    from ..workflow.demo_seam import MeasuredJoint
    from ..workflow.measure import MeasuredPoint
    from ..workflow.scan import Scan
    from ..workflow.seam import Seam
    from ..workflow.verify import Verification

LABELS = {f"r{axis}": f"R_cam2gripper r{axis}" for axis in "xyz"}
LABELS |= {f"t{axis}": f"t_cam2gripper {axis}" for axis in "xyz"}
LABELS |= {f"n{axis}": f"light plane n{axis}" for axis in "xyz"} | {"d": "light plane d"}


class Row(NamedTuple):
    """A parameter in the unit of the table; `half`: half of its 95 % interval, 0 = kept, infinite = not observed.

    The ends of a rotation's interval are those of the error angle about the gripper's axis.
    """

    name: str
    value: float
    half: float
    lower: float
    upper: float
    unit: str

    @property
    def label(self) -> str:
        """What the table calls it."""
        return LABELS.get(self.name, self.name)

    @property
    def digits(self) -> int:
        """After the point: two significant ones of the interval."""
        estimated = 0 < self.half < math.inf
        return len(two_digits(self.half).partition(".")[2]) if estimated else 4 if self.unit else 6

    @property
    def interval(self) -> str:
        """The 95 % interval in words."""
        if self.half == 0:
            return "kept"
        if not math.isfinite(self.half):
            return "not observed"
        if self.name in ROTATION:
            return f"± {two_digits(self.half)}"
        return f"{self.lower:.{self.digits}f} to {self.upper:.{self.digits}f}"


def parameter_rows(calibration: Calibration) -> list[Row]:
    """All parameters of the table; what was kept at zero (skew, distortion) is left out."""
    rows = []
    for name, value in parameter_values(calibration).items():
        known = name in calibration.parameter_names
        sigma = calibration.standard_deviation(name) if known else 0.0
        if sigma == 0 and value == 0:
            continue
        unit = UNITS.get(name, "")
        interval = calibration.interval(name) if known else None
        middle = 0.0 if name in ROTATION else value / SCALES[unit]
        ends = interval or (middle - NORMAL_95 * sigma, middle + NORMAL_95 * sigma)
        lower, upper = (end * SCALES[unit] for end in ends)
        rows.append(Row(name, value, (upper - lower) / 2 if sigma else 0.0, lower, upper, unit))
    return rows


def verdict_text(calibration: Calibration) -> str:
    """Whether the result may be used, in one sentence."""
    verdict, tool = calibration.verdict, calibration.tool
    if verdict is None or tool is None:
        return "Closed forms (file version 1): intervals are 1.96 sigma, and each step takes the one before as exact."
    if not verdict.usable:
        return sentence(f"NOT USABLE: {verdict.message.removeprefix('not usable: ')}")
    distance = f"at the working distance of {1000 * tool.working_distance:.0f} mm"
    if not math.isfinite(tool.accuracy):
        return f"Usable in part: where a point {distance} lies from the gripper, these data do not say."
    return f"Usable: a point {distance} is placed to ± {two_digits(1000 * tool.accuracy)} mm at the tool (95 %)."


def result_lines(calibration: Calibration) -> list[str]:
    """What was left out, what is weak, noise levels, lens, residuals and counts."""
    lines = [] if calibration.verdict is None else _findings(calibration.verdict, calibration.observations)
    if calibration.noise_levels is not None:
        lines.append(_noise(calibration.noise_levels))
    if calibration.lens is not None:
        p = calibration.lens.tests[LENS_NAMES.index(calibration.lens.model), 2]
        why = f", chosen by the test (p = {p:.2g})" if calibration.lens.chosen else ""
        lines.append(f"Lens distortion estimated: {calibration.lens.model}{why}.")
    if calibration.chi_square is not None:
        chi = calibration.chi_square
        lines.append(f"Chi-square {chi.value:.1f} at {chi.degrees_of_freedom:.0f}, p = {chi.p_value:.2g}.")
    rms = [f"{key.removesuffix('_px')} {value:.3f} px" for key, value in calibration.rms if value is not None]
    lines.append(f"RMS residuals: {', '.join(rms)}.")
    seen = f"{calibration.views} views, {calibration.points} points, {calibration.observations} observations"
    stripes = f", {calibration.stripe_segments} stripe segments" if calibration.stripe_segments else ""
    kept = f" Kept: {', '.join(calibration.constraints).replace('_', ' ')}." if calibration.constraints else ""
    return [*lines, f"Used {seen}{stripes}.{kept}"]


def verification_lines(result: Verification) -> list[str]:
    """The answer, what changed most likely, and how many image points it rests on."""
    summary = result.summary
    lines = [sentence(summary.message)]
    if not result.valid:
        lines.append(f"{_shift(summary)} It is a hint where to look, not a correction: calibrate again.")
    rejected = f", {summary.rejectedObservations} left out" if summary.rejectedObservations else ""
    return [*lines, f"RMS error {result.rms_px:.3f} px; {summary.usedObservations} image points{rejected}."]


def scan_lines(result: Scan) -> list[str]:
    """How many points, how good they are, which box they fill, and what was left out."""
    views, points, sigmas = len(np.unique(result.views)), 1000 * result.points, 1000 * result.sigmas
    lines = [f"{counted(len(points), 'point')} in {counted(views, 'view')}, in the robot's base frame."]
    middle, most = (f"{two_digits(float(x))} mm" for x in np.quantile(sigmas, (0.5, 0.95), method="lower"))
    lines.append(f"Sigma in the worst direction: median {middle}, 95 % are below {most}.")
    if not np.isfinite(sigmas).all():
        lines.append(
            f"{counted(int(np.isinf(sigmas).sum()), 'point')} without a sigma: the calibration left something open."
        )
    box = zip("xyz", points.min(axis=0), points.max(axis=0), strict=True)
    lines.append(f"Box: {', '.join(f'{axis} {low:.1f} to {high:.1f} mm' for axis, low, high in box)}.")
    if result.empty_views:
        lines.append(f"Without points: {views_listed(result.empty_views)}.")
    if result.beyond_limit:
        lines.append(f"Left out for their sigma: {counted(result.beyond_limit, 'point')}.")
    return lines


def seam_lines(result: Seam) -> list[str]:
    """Length of the path, how good its points are, from where to where it goes, and which views show no groove."""
    points, sigmas = 1000 * result.points, 1000 * result.sigmas
    views = counted(len(points), "profile")
    lines = [f"Root of the groove in {views}, {1000 * result.length:.1f} mm long, in the robot's base frame."]
    ends = (", ".join(f"{value:.2f}" for value in point) for point in points[[0, -1]])
    lines.append(f"From ({') to ('.join(ends)}) mm.")
    opening = f"{result.opening_angles.mean():.1f} degrees"
    if np.isfinite(sigmas).all():
        middle = two_digits(float(np.median(sigmas)))
        lines.append(f"Sigma in the worst direction: median {middle} mm. Opening angle in the light plane: {opening}.")
    else:
        lines.append(f"Without a sigma: the calibration left something open. Opening angle: {opening}.")
    if result.without_groove:
        lines.append(f"Without a groove: {views_listed(result.without_groove)}.")
    return lines


def joint_lines(joint: MeasuredJoint) -> list[str]:
    """How far the measured root of the simulated weld joint is from the true one."""
    distances = 1000 * joint.distances
    rms, largest = f"RMS {joint.rms_mm:.3f} mm", f"largest {distances.max():.3f} mm"
    return [f"Distance from the true root: {rms}, {largest} (limit of the RMS: {joint.limit_mm:g} mm)."]


def measured_lines(points: list[MeasuredPoint]) -> list[str]:
    """How far the points are from their reference values; nothing where none is given."""
    compared = [(point, 1000 * point.difference) for point in points if point.difference is not None]
    if not compared:
        return []
    sizes = np.array([np.linalg.norm(difference) for _, difference in compared])
    worst = compared[int(sizes.argmax())][0].name
    name, axis, largest = max(
        ((point.name, axis, d) for point, difference in compared for axis, d in zip("xyz", difference, strict=True)),
        key=lambda item: abs(item[2]),
    )
    inside = sum(int((np.abs(difference) <= 1000 * point.half_widths).sum()) for point, difference in compared)
    return [
        f"3-D difference: RMS {np.sqrt(np.mean(sizes**2)):.3f} mm, maximum {sizes.max():.3f} mm ({worst}).",
        f"Largest difference of one coordinate: {largest:+.3f} mm ({name}, {axis}).",
        f"{inside} of {3 * len(compared)} differences are within the intervals, which hold no error of the references.",
    ]


def _shift(summary: VerifySummary) -> str:
    """The parameters by group that moved by more than they may."""
    deviations = np.where(summary.shiftDeviations > 0, summary.shiftDeviations, np.inf)
    ratio = np.reshape(np.abs(summary.shift) / deviations, -1)
    groups = {"camera matrix": PARAMETERS[:5], "lens": DISTORTION, "R_cam2gripper": ROTATION}
    groups["t_cam2gripper"] = ("tx", "ty", "tz")
    largest = {name: max(ratio[PARAMETERS.index(p)] for p in members) for name, members in groups.items()}
    order = sorted(largest, key=lambda name: -largest[name])
    named = ", ".join(f"{name} ({largest[name]:.1f} sigma)" for name in order if largest[name] > 2)
    return f"The views ask for another {named}." if named else "No single parameter stands out."


def _findings(verdict: Verdict, used: int) -> list[str]:
    lines = [sentence(text) for text in (*verdict.culprits, *verdict.weak_directions)]
    left_out = [f"{verdict.rejected_observations} of {used + verdict.rejected_observations} image points"]
    left_out = left_out if verdict.rejected_observations else []
    if verdict.rejected_segments:
        left_out.append(counted(len(verdict.rejected_segments), "stripe segment"))
    return [*lines, f"Left out: {', '.join(left_out)}."] if left_out else lines


def _noise(levels: NoiseLevels) -> str:
    found = [("image points", levels.image_points, 1.0, "px"), ("stripes", levels.stripes, 1.0, "px")]
    found += [("robot", levels.robot_translation, 1000.0, "mm"), ("robot", levels.robot_rotation, np.degrees(1), "deg")]
    parts = [f"{name} {_level(level, scale)} {unit}" for name, level, scale, unit in found if level is not None]
    return f"Noise levels (one axis): {', '.join(parts)}."


def _level(level: NoiseLevel, scale: float) -> str:
    if level.level == 0:
        return "0"
    digits = max(0, 2 - math.floor(math.log10(scale * level.level)))
    return f"{scale * level.level:.{digits}f}{'' if level.estimated else ' (given)'}"
