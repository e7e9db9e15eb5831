# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The tables of the page, as rows of finished text."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .errors import rotation_vector_deg
from .inputs import ReportInput, Summary, column
from .words import counted, fixed, sentence, two_digits

LENS_MODELS = ("none", "k1", "k1, k2", "k1, k2, p1, p2", "k1, k2, p1, p2, k3")
NOISE = (
    ("Image points", "px", 1.0),
    ("Stripe segments", "px", 1.0),
    ("Robot position, each axis", "mm", 1000.0),
    ("Robot orientation, each axis", "deg", math.degrees(1)),
)


class NoiseLevel(NamedTuple):
    """One noise level; `interval` is empty where it was not estimated."""

    name: str
    level: str
    interval: str
    unit: str
    origin: str


def noise_levels(case: ReportInput) -> list[NoiseLevel]:
    """Standard deviations of what went in, with 95 % intervals where they were estimated."""
    rows = []
    levels = np.asarray(case.summary.noiseLevels, np.float64).reshape(-1, 4)
    for (name, unit, scale), (level, lower, upper, estimated) in zip(NOISE, levels, strict=True):
        absent = not math.isfinite(level) or (name == "Stripe segments" and not len(case.stripe_residuals))
        origin = "no data" if absent else "estimated" if estimated else "taken as exact" if level == 0 else "given"
        digits = max(0, 2 - math.floor(math.log10(scale * level))) if level > 0 else 0
        interval = f"{scale * lower:.{digits}f} to {scale * upper:.{digits}f}" if origin == "estimated" else ""
        rows.append(NoiseLevel(name, "–" if absent else f"{scale * level:.{digits}f}", interval, unit, origin))
    return rows


class LensTest(NamedTuple):
    """What the data say against a lens model."""

    model: str
    statistic: str
    missing: str
    p_value: str
    criterion: str
    chosen: bool


def lens_tests(case: ReportInput) -> list[LensTest]:
    """One row a lens model; empty where no test was made."""
    tests = np.asarray(case.summary.lensTests, np.float64)
    if tests.shape != (len(LENS_MODELS), 4) or not np.isfinite(tests).any():
        return []
    rows = []
    for k, (name, (statistic, missing, p, criterion)) in enumerate(zip(LENS_MODELS, tests, strict=True)):
        chosen = k == case.summary.lensModel
        p = p if missing > 0 else math.nan
        rows.append(LensTest(name, fixed(statistic, 1), fixed(missing, 0), p_value(p), fixed(criterion, 1), chosen))
    return rows


def p_value(p: float) -> str:
    """A probability as one reads it."""
    return "–" if not math.isfinite(p) else "< 0.0001" if p < 1e-4 else f"{p:.4f}" if p < 0.01 else f"{p:.2f}"


def chi_square_words(case: ReportInput) -> str:
    """The test of the model in a sentence."""
    summary = case.summary
    if not math.isfinite(summary.chiSquarePValue) or not summary.chiSquareDof > 0:
        return "No chi-square test: with noise levels that are all estimated it would fit by construction."
    text = f"Chi-square {summary.chiSquare:.1f} at {summary.chiSquareDof:.0f} degrees of freedom, p = "
    text += p_value(summary.chiSquarePValue).replace("< ", "below ")
    estimated = np.asarray(case.summary.noiseLevels, np.float64).reshape(-1, 4)[:, 3]
    if estimated.any():
        return f"{text}. Noise levels that were estimated make it fit by construction; then the lens tests tell more."
    return f"{text}: " + ("the model fits." if summary.chiSquarePValue > 0.01 else "the model does not fit the data.")


class ViewRow(NamedTuple):
    """One view in numbers."""

    view: int
    orientation: int
    used: int
    left_out: int
    rms: str
    translation: str
    rotation: str
    believed: bool


def views_table(case: ReportInput) -> list[ViewRow]:
    """Everything the figures show of a view, for those who read numbers or cannot see the figures."""
    translation = np.linalg.norm(case.pose_corrections[:, 3:], axis=1)
    rotation = np.linalg.norm(case.pose_corrections[:, :3], axis=1)
    return [
        ViewRow(
            view,
            int(case.group_ids[view]) + 1,
            int(case.used[view].sum()),
            int(case.rejected[view].sum()),
            fixed(case.view_rms[view], 3),
            fixed(translation[view], 3),
            fixed(rotation[view], 4),
            view not in case.summary.rejectedViews,
        )
        for view in range(len(case.dataset))
    ]


class SegmentRow(NamedTuple):
    """A stripe segment that was left out; `place`: its ends in the image."""

    segment: int
    view: int
    surface: str
    place: str


def rejected_segments(case: ReportInput) -> list[SegmentRow]:
    """Which stripe segments were left out, and where they are."""
    rows = []
    for k in case.summary.rejectedSegments:
        segment = case.evidence.segments[k]
        place = " to ".join(f"({u:.0f}, {v:.0f})" for u, v in segment.points[[0, -1]])
        surface = str(segment.surface) if segment.surface >= 0 else "not known"
        rows.append(SegmentRow(k, segment.view, surface, place))
    return rows


class StripeGroupRow(NamedTuple):
    """What the light plane owes to the stripes of one group of equal orientation: sigmas without them."""

    group: str
    segments: str
    surfaces: str
    normal_deg: str
    offset_mm: str


def stripe_groups(summary: Summary) -> list[StripeGroupRow]:
    """First the sigmas with all stripes, then those without each group; empty without stripes."""
    groups = np.asarray(summary.stripeGroups, np.float64).reshape(-1, 6)
    if not len(groups):
        return []
    variances = dict(zip(summary.parameterNames, np.diag(summary.covariance), strict=True))
    normal = math.sqrt(sum(variances[name] for name in ("nx", "ny", "nz")))
    offset = math.sqrt(variances["d"])
    rows = [StripeGroupRow("none", f"{groups[:, 2].sum():.0f}", "", *_plane_sigmas(normal, offset))]
    for first, views, segments, surfaces, *without in groups.tolist():
        name = f"{counted(int(views), 'view')} from view {first:.0f} on"
        rows.append(StripeGroupRow(name, f"{segments:.0f}", f"{surfaces:.0f}", *_plane_sigmas(*without)))
    return rows


def _plane_sigmas(normal: float, offset: float) -> tuple[str, str]:
    """In degrees and mm, in words where nothing determines them."""
    if not math.isfinite(normal + offset):
        return "not determined", "not determined"
    return two_digits(math.degrees(normal)), two_digits(1000 * offset)


class ComparisonRow(NamedTuple):
    """One method on the board; `problem` replaces the numbers of a method that gave no answer."""

    name: str
    spread_mm: str
    spread_deg: str
    misses_px: str
    rotation: str
    position: str
    ours: bool
    problem: str


def comparison_table(case: ReportInput) -> list[ComparisonRow]:
    """How still the board stands with every method."""
    rows = []
    for row in case.comparison.rows if case.comparison else []:
        ours = not row.name.startswith("OpenCV")
        if row.R_cam2gripper is None or row.t_cam2gripper is None:
            rows.append(ComparisonRow(row.name, "–", "–", "–", "–", "–", ours, row.problem or "no answer"))
            continue
        scores = (row.spread_mm, row.spread_deg, row.reprojection_px)
        spreads = [fixed(math.nan if x is None else x, digits) for x, digits in zip(scores, (3, 4, 3), strict=True)]
        rotation = ", ".join(f"{x:.3f}" for x in rotation_vector_deg(row.R_cam2gripper))
        position = ", ".join(f"{1000 * x:.2f}" for x in row.t_cam2gripper)
        rows.append(ComparisonRow(row.name, spreads[0], spreads[1], spreads[2], rotation, position, ours, row.problem))
    return rows


def comparison_words(case: ReportInput) -> str:
    """Who was best, in a sentence."""
    scored = [row for row in (case.comparison.rows if case.comparison else []) if row.spread_mm is not None]
    if not scored:
        return "No method gave an answer."
    best = min(scored, key=lambda row: (row.spread_mm, row.name))
    text = f"The board stands stillest with “{best.name}”: {best.spread_mm:.3f} mm RMS around its mean position"
    theirs = [row for row in scored if row.name.startswith("OpenCV")]
    if not theirs or best in theirs:
        return f"{text}."
    second = min(theirs, key=lambda row: (row.spread_mm, row.name))
    return f"{text}; of OpenCV's methods, with “{second.name}”: {second.spread_mm:.3f} mm."


def provenance(case: ReportInput) -> list[tuple[str, str]]:
    """Where the numbers come from; nothing that changes from run to run."""
    calibration, summary = case.calibration, case.summary
    laser, seen = case.dataset.laser, int(case.seen.sum())
    levels = column(np.asarray(summary.noiseLevels, np.float64)[:, 3])
    rows = [
        ("Software", f"cv_active_handeye {calibration.software_version}"),
        ("Data set (SHA-256)", calibration.dataset_sha256 or "not recorded"),
        ("Description", case.dataset.description),
        ("Camera", f"{case.dataset.camera.name} {case.image_size[0]} × {case.image_size[1]} px".strip()),
        ("Laser", f"{laser.name} {laser.stripe} stripe".strip() if laser else "none"),
        ("Recorded", f"{len(case.dataset)} views, {case.image_points.shape[1]} points, {seen} image points"),
        ("Stripe segments", str(len(case.evidence.segments))),
        ("Kept instead of estimated", ", ".join(calibration.constraints).replace("_", " ") or "nothing"),
        ("Noise levels estimated", f"{int(levels.sum())} of {len(levels)}"),
        ("Solver", f"{sentence(summary.message)} {sentence(summary.stopReason)} Iterations: {summary.iterations}."),
    ]
    return [(name, text) for name, text in rows if text]
