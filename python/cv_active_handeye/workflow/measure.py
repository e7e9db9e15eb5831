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
from .profiles import NEAR, Profile, Profiler, find_profiles, profiler
from .reporter import Reporter, Silent

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


class _Located(NamedTuple):
    """A row's pixel (2,) px on the stripe and its covariance (2, 2) px^2."""

    row: PointRow
    pixel: FloatArray
    covariance: FloatArray


def measure(
    dataset: Dataset | str | Path,
    calibration: Calibration,
    rows: Sequence[PointRow],
    reporter: Reporter | None = None,
) -> list[MeasuredPoint]:
    """The points of `rows` in the order in which their names appear; rows of one name are views of one point.

    The u of a row (v where the stripe is vertical) says where on the stripe the point is, to within the row's sigma;
    the other coordinate only chooses the straight piece. Raises `FileFormatError` that names the row when there is no
    stripe, and as `scan` does.
    """
    reporter = reporter or Silent()
    dataset = open_recording(dataset, reporter)
    tool = profiler(dataset, calibration, reporter)
    for row in rows:
        _check_view(tool, row)
    views = sorted({row.view for row in rows})
    profiles = {profile.view: profile for profile in find_profiles(tool, views, reporter)}
    located = [_located(tool, profiles[row.view], row) for row in rows]
    names = list(dict.fromkeys(row.name for row in rows))
    reporter.step(f"placing {len(names)} points in the base frame")(1, 1)
    return _placed(tool, names, located, reporter)


def _check_view(tool: Profiler, row: PointRow) -> None:
    count = len(tool.dataset)
    if row.view >= count:
        raise FileFormatError(f"{row.where}: needs a view of the data set (0 to {count - 1}), given {row.view}")
    if tool.dataset.views[row.view].laser_image is None:
        raise FileFormatError(f"{row.where}: needs a view with a laser image, view {row.view} has none")


def _located(tool: Profiler, profile: Profile, row: PointRow) -> _Located:
    pixel, covariance = tool.on_line(profile, np.array([row.u, row.v]), row.sigma)
    if not np.isfinite(pixel).all():
        raise FileFormatError(f"{row.where}: {nothing_near(profile, np.array([row.u, row.v]))}")
    return _Located(row, pixel, covariance)


def nothing_near(profile: Profile, pixel: FloatArray) -> str:
    """What is wrong at a pixel (2,) beside which a profile has no straight piece."""
    u, v = pixel
    needed = f"needs a straight piece of the stripe within {NEAR:g} px of ({u:g}, {v:g}) in view {profile.view}"
    if len(profile.pixels) == 0:
        return f"{needed}; the view shows no stripe"
    far = np.hypot(*(profile.pixels - pixel).T)
    u, v = profile.pixels[np.argmin(far)]
    why = "the stripe is not straight around" if far.min() <= NEAR else "the nearest point of the stripe is"
    return f"{needed}; {why} ({u:.1f}, {v:.1f})"


def _placed(
    tool: Profiler, names: Sequence[str], located: Sequence[_Located], reporter: Reporter
) -> list[MeasuredPoint]:
    pixels, spread = [one.pixel for one in located], [one.covariance for one in located]
    views, ids = [one.row.view for one in located], [names.index(one.row.name) for one in located]
    try:
        positions, covariances, disagreements = tool.measure(pixels, spread, views, ids)
    except cah.error as error:
        raise FileFormatError(f"the points cannot be placed: {error}") from error
    for one, disagreement in zip(located, disagreements, strict=True):
        if disagreement > DISAGREEMENT:
            reporter.note(
                f"point {one.row.name}: view {one.row.view} contradicts the others by more than noise explains "
                f"(chi-square {disagreement:.0f} at 3 degrees of freedom); is it the same point?"
            )
    return [
        MeasuredPoint(
            name,
            tuple(one.row.view for one in located if one.row.name == name),
            position,
            covariance,
            _reference([one.row for one in located if one.row.name == name]),
        )
        for name, position, covariance in zip(names, positions, covariances, strict=True)
    ]


def _reference(rows: Sequence[PointRow]) -> FloatArray | None:
    known = [row.reference for row in rows if row.reference is not None]
    return np.array(known[0]) / 1000 if known else None
