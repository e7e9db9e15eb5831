# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Characteristic points on the stripe: from pixels of one or more views to base coordinates with covariances."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

import cv_active_handeye as cah

from ..calibration import Calibration
from ..dataset import Dataset
from ..files import FileFormatError, FloatArray
from ..measured_points import PointRow
from ..report.verdict import NORMAL_95
from .evidence import open_recording
from .profiles import Profile, Profiler, column_scatter, find_profiles, profiler
from .reporter import Reporter, Silent

HALF_WINDOW = 15.0
"""Columns of the segment on either side of the point that its line is fitted to. Longer lines are hardly better, and a
lens bends them."""

LEAST_COLUMNS = 8
"""Of the segment, inside the window."""

REACH = 3.0
"""Columns by which a point may lie beyond the end of its segment: an edge is where the segment ends."""

NEAR = 10.0
"""Pixels between the stripe and the pixel that names it."""

LINE_SIGMA, LINE_SHARE = 0.02, 1 / 3
"""Pixels that even the best line is uncertain by, or this share of a column's sigma, whichever is more: neighbouring
columns share grain, texture and the edge that cuts the stripe."""

DISAGREEMENT = 16.27
"""Quantile 99.9 % of chi-square with three degrees of freedom."""


@dataclass(frozen=True)
class MeasuredPoint:
    """One point in the base frame: position (3,) m, covariance (3, 3) m^2, the views it was seen in, and the reference
    (3,) m, None without."""

    name: str
    views: tuple[int, ...]
    position: FloatArray
    covariance: FloatArray
    reference: FloatArray | None = None

    @property
    def half_widths(self) -> FloatArray:
        """Halves of the 95 % intervals of x, y, z, m."""
        return np.asarray(NORMAL_95 * np.sqrt(np.diag(self.covariance)))

    @property
    def difference(self) -> FloatArray | None:
        """Measured minus reference (3,), m."""
        return None if self.reference is None else np.asarray(self.position - self.reference)


class _Seen(NamedTuple):
    """A point as one view shows it; the parts of its covariance as in `profiles.Located`."""

    position: FloatArray
    noise: FloatArray
    shared: FloatArray


def measure(
    dataset: Dataset | str | Path,
    calibration: Calibration,
    rows: Sequence[PointRow],
    reporter: Reporter | None = None,
) -> list[MeasuredPoint]:
    """The points of `rows` in the order in which their names appear; rows of one name are averaged.

    The u of a row (v where the stripe is vertical) is taken as exact, the other coordinate only chooses the segment.
    Raises `FileFormatError` that names the row when there is no stripe, and as `scan` does.
    """
    reporter = reporter or Silent()
    dataset = open_recording(dataset, reporter)
    tool = profiler(dataset, calibration, reporter)
    for row in rows:
        _check_view(tool, row)
    views = sorted({row.view for row in rows})
    profiles = {profile.view: profile for profile in find_profiles(tool, views, reporter)}
    scatter = column_scatter(list(profiles.values()), tool.along)
    names = list(dict.fromkeys(row.name for row in rows))
    progress = reporter.step(f"placing {len(names)} points in the base frame")
    points = []
    for done, name in enumerate(names, start=1):
        own = [row for row in rows if row.name == name]
        points.append(_mean(own, [_seen(tool, profiles[row.view], row, scatter) for row in own], reporter))
        progress(done, len(names))
    return points


def _check_view(tool: Profiler, row: PointRow) -> None:
    count = len(tool.dataset)
    if row.view >= count:
        raise FileFormatError(f"{row.where}: needs a view of the data set (0 to {count - 1}), given {row.view}")
    if tool.dataset.views[row.view].laser_image is None:
        raise FileFormatError(f"{row.where}: needs a view with a laser image, view {row.view} has none")


def _seen(tool: Profiler, profile: Profile, row: PointRow, scatter: float) -> _Seen:
    pixel, sigma = stripe_line(profile, row, tool.along, scatter)
    try:
        found = tool.locate(row.view, pixel[None], np.array([sigma]))
    except cah.error as error:
        raise FileFormatError(f"{row.where}: point {row.name} cannot be placed: {error}") from error
    return _Seen(found.points[0], found.noise[0], found.shared[0])


def stripe_line(profile: Profile, row: PointRow, along: int, scatter: float) -> tuple[FloatArray, float]:
    """The pixel (2,) where the line of the nearest segment crosses the row's column, and its sigma across in px.

    `along`: the coordinate that counts along the stripe; `scatter` as from `column_scatter`. Raises `FileFormatError`
    when no segment is near.
    """
    start, across = (row.u, row.v) if along == 0 else (row.v, row.u)
    best: tuple[float, float] | None = None
    for number in range(profile.segments.max(initial=-1) + 1):
        line = _line(profile, number, start, along, scatter)
        if line is not None and (best is None or abs(line[0] - across) < abs(best[0] - across)):
            best = line
    if best is None or abs(best[0] - across) > NEAR:
        raise FileFormatError(_nothing_near(profile, row, along, best))
    pixel = [start, best[0]] if along == 0 else [best[0], start]
    return np.array(pixel), best[1]


def _line(profile: Profile, number: int, start: float, along: int, scatter: float) -> tuple[float, float] | None:
    """Value and sigma at `start` of the line through segment `number`, None where the segment does not reach."""
    distance = profile.pixels[:, along] - start
    on = profile.segments == number
    if distance[on].min() > REACH or distance[on].max() < -REACH:
        return None
    on &= np.abs(distance) <= HALF_WINDOW
    if on.sum() < LEAST_COLUMNS:
        return None
    sigmas = scatter * profile.sigmas[on]
    line, C = np.polyfit(distance[on], profile.pixels[on, 1 - along], 1, w=1 / sigmas, cov="unscaled")
    common = max(LINE_SIGMA, LINE_SHARE * float(np.median(sigmas)))
    return float(line[1]), float(np.hypot(np.sqrt(C[1, 1]), common))


def _nothing_near(profile: Profile, row: PointRow, along: int, best: tuple[float, float] | None) -> str:
    pixel = f"({row.u:g}, {row.v:g})"
    needed = f"{row.where}: needs a straight piece of the stripe within {NEAR:g} px of {pixel} in view {row.view}"
    if len(profile.pixels) == 0:
        return f"{needed}; the view shows no stripe"
    if best is not None:
        return f"{needed}; the stripe is at {'vu'[along]} = {best[0]:.1f} there"
    far = np.hypot(*(profile.pixels - [row.u, row.v]).T)
    u, v = profile.pixels[np.argmin(far)]
    why = "the stripe is not straight around" if far.min() <= NEAR else "the nearest point of the stripe is"
    return f"{needed}; {why} ({u:.1f}, {v:.1f})"


def _mean(rows: Sequence[PointRow], seen: Sequence[_Seen], reporter: Reporter) -> MeasuredPoint:
    """The mean of what the views show, weighted by the inverse covariances.

    Noise is independent from view to view; the calibration's errors are not. How far they cancel is not known here, so
    their part is bounded from above, with the weights' shares p: |sum of a_i|^2 <= sum of |a_i|^2 / p_i.
    """
    name, views = rows[0].name, tuple(row.view for row in rows)
    known = [row.reference for row in rows if row.reference is not None]
    reference = np.array(known[0]) / 1000 if known else None
    totals = np.array([one.noise + one.shared for one in seen])
    if len(seen) == 1 or not np.isfinite(totals).all():
        return MeasuredPoint(name, views, np.mean([s.position for s in seen], axis=0), totals.mean(axis=0), reference)
    informations = np.linalg.inv(totals)
    weights = np.linalg.solve(informations.sum(axis=0), informations)
    positions = np.array([one.position for one in seen])
    mean = np.einsum("nij,nj->i", weights, positions)
    shares = np.trace(weights, axis1=1, axis2=2) / 3
    covariance = sum(
        W @ (one.noise + one.shared / p) @ W.T for W, one, p in zip(weights, seen, shares, strict=True)
    )
    for row, apart, C in zip(rows, positions - mean, totals, strict=True):
        if apart @ np.linalg.solve(C, apart) > DISAGREEMENT:
            far = 1000 * np.linalg.norm(apart)
            reporter.note(f"point {name}: view {row.view} puts it {far:.2f} mm from the mean, more than noise explains")
    return MeasuredPoint(name, views, mean, np.asarray(covariance), reference)
