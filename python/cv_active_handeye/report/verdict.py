# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The answer first: may the calibration be used, how good is it at the tool, what was left out, what to do next."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .inputs import IntArray, ReportInput, Summary, column
from .words import counted, sentence, two_digits, views_listed

NORMAL_95 = 1.959963984540054
"""97.5 % point of the normal distribution."""


REASONS = {
    "usable": "The data determine every parameter, and what was used of them agrees with the model.",
    "partial": "The data determine some of the parameters only; what was used of them agrees with the model.",
}
UNUSABLE = "The values below are for finding the cause, not for use: their intervals hold only where the model does."


class ToolAccuracy(NamedTuple):
    """± of a point at the working distance, 95 %, mm: in the worst direction, and along gripper x, y, z."""

    worst: float
    axes: tuple[float, float, float]


class Fact(NamedTuple):
    """A number with what it means, for the row of figures under the verdict."""

    value: str
    unit: str
    meaning: str


class Verdict(NamedTuple):
    """`state` is usable, partial or unusable."""

    state: str
    title: str
    message: str
    accuracy: str
    facts: list[Fact]
    left_out: list[str]
    next_steps: list[str]


def verdict(case: ReportInput) -> Verdict:
    """Everything the top of the page says."""
    summary = case.summary
    titles = {"usable": "Usable", "partial": "Usable in part", "unusable": "Do not use"}
    state = "unusable" if not summary.usable else "partial" if case.unobserved else "usable"
    tool = tool_accuracy(summary) if summary.usable else None
    accuracy = _accuracy(tool, 1000 * summary.workingDistance) if summary.usable else UNUSABLE
    facts = _facts(case, tool)
    reason = REASONS.get(state) or sentence(summary.message.removeprefix("not usable: "))
    return Verdict(state, titles[state], reason, accuracy, facts, _left_out(case), _next_steps(case))


def tool_accuracy(summary: Summary) -> ToolAccuracy | None:
    """From `toolCovariance`, widened as Student's t widens the intervals of the hand-eye parameters; None = unknown."""
    covariance = np.asarray(summary.toolCovariance, np.float64)
    if covariance.shape != (3, 3) or not np.isfinite(covariance).all():
        return None
    variances = np.append(np.linalg.eigvalsh(covariance)[-1], np.diag(covariance))
    worst, x, y, z = 1000 * _widening(summary) * NORMAL_95 * np.sqrt(np.clip(variances, 0, None))
    return ToolAccuracy(float(worst), (float(x), float(y), float(z)))


def _widening(summary: Summary) -> float:
    """Largest ratio of a 95 % interval of rx ... tz to the normal distribution's; 1 where none was estimated."""
    sigmas = column(summary.standardDeviations)
    halves = np.ptp(np.asarray(summary.intervals95, np.float64).reshape(-1, 2), axis=1) / 2
    names = ("rx", "ry", "rz", "tx", "ty", "tz")
    rows = [i for i, name in enumerate(summary.parameterNames) if name in names and 0 < sigmas[i] < math.inf]
    return max((float(halves[i] / (NORMAL_95 * sigmas[i])) for i in rows), default=1.0)


def _accuracy(tool: ToolAccuracy | None, distance: float) -> str:
    if tool is None:
        return "How well a measured point is placed cannot be said: the data do not determine all it depends on."
    x, y, z = (two_digits(value) for value in tool.axes)
    return (
        f"A point on the optical axis at the working distance of {distance:.0f} mm is placed to "
        f"± {two_digits(tool.worst)} mm in the worst direction, seen from the gripper (95 %), and along the gripper's "
        f"x, y, z to ± {x}, {y}, {z} mm. Errors of finding the point in the image and of the robot while measuring "
        "come on top."
    )


def _facts(case: ReportInput, tool: ToolAccuracy | None) -> list[Fact]:
    used, seen, distance = int(case.used.sum()), int(case.seen.sum()), 1000 * case.summary.workingDistance
    views = int((case.used.sum(axis=1) > 0).sum())
    at_tool = Fact(f"± {two_digits(tool.worst)}" if tool else "–", "mm", "at the tool, 95 %")
    return [
        at_tool,
        Fact(f"{distance:.0f}" if math.isfinite(distance) else "–", "mm", "working distance"),
        Fact(f"{case.summary.rms:.3f}", "px", "RMS residual"),
        Fact(f"{views}", f"of {len(case.dataset)}", "views used"),
        Fact(f"{used}", f"of {seen}", "image points used"),
    ]


def _left_out(case: ReportInput) -> list[str]:
    """The culprits that the solver names, then counts."""
    found = [sentence(text) for text in case.summary.culprits]
    if case.rejected.any():
        number, seen = int(case.rejected.sum()), int(case.seen.sum())
        text = f"{counted(number, 'image point')} of {seen} ({100 * number / seen:.1f} %) left out"
        found.append(f"{text}{_concentration(case.rejected.sum(axis=1))}.")
    if case.summary.rejectedSegments:
        number = len(case.summary.rejectedSegments)
        found.append(f"{counted(number, 'stripe segment')} of {len(case.evidence.segments)} left out.")
    return found


def _concentration(counts: IntArray) -> str:
    """Names the views that hold more than half of what was left out, where three or fewer do."""
    order = np.argsort(-counts, kind="stable")
    needed = int(np.searchsorted(np.cumsum(counts[order]), counts.sum() / 2, side="right")) + 1
    if needed > min(3, len(counts) - 1):
        return ""
    return f", most of them in {views_listed(sorted(order[:needed]))}"


def _next_steps(case: ReportInput) -> list[str]:
    steps = [sentence(text) for text in case.summary.weakDirections]
    if not case.summary.usable:
        return ["Do not move the robot by this result. Remove the cause named above and record again.", *steps]
    return [*steps, "After a collision, or when the camera was touched, run cv-active-handeye verify on new views."]
