# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A weld seam: the root of a V-groove in every profile of a scan, as a path in the robot's base frame."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import cv_active_handeye as cah

from ..calibration import Calibration
from ..dataset import Dataset
from ..files import FloatArray
from .evidence import open_recording
from .profiles import Profile, Profiler, find_profiles, profiler
from .reporter import InsufficientDataError, Reporter, Silent
from .scan import worst_sigma

FACE_COLUMNS = 8
"""Least columns of a groove's face: of a groove 12 mm deep the camera of the simulated cell sees 17."""


@dataclass(frozen=True)
class GrooveShape:
    """What counts as the groove: `opening_deg`, the angle between its faces, to within `tolerance_deg`."""

    opening_deg: float = 60.0
    tolerance_deg: float = 20.0


@dataclass(frozen=True)
class Seam:
    """The path of the root, in the order of the views; base frame.

    points (N, 3) m and covariances (N, 3, 3) m^2 from stripe, robot and calibration; opening_angles (N,) degrees;
    views (N,): number of the view; without_groove: views with a laser image that show none.
    """

    points: FloatArray
    covariances: FloatArray
    opening_angles: FloatArray
    views: NDArray[np.int32]
    without_groove: tuple[int, ...] = ()

    @property
    def sigmas(self) -> FloatArray:
        """Standard deviation (N,) of a point in its worst direction, m; infinite where it is not known."""
        return worst_sigma(self.covariances)

    @property
    def length(self) -> float:
        """Of the path, m."""
        return float(np.linalg.norm(np.diff(self.points, axis=0), axis=1).sum())


class _Root(NamedTuple):
    view: int
    pixel: FloatArray
    covariance: FloatArray
    opening_angle: float


def find_seam(
    dataset: Dataset | str | Path,
    calibration: Calibration,
    shape: GrooveShape | None = None,
    reporter: Reporter | None = None,
) -> Seam:
    """The root of the groove in every laser image: where the lines of its two faces meet, rounded root or gap or not.

    Of several grooves in one view that fit `shape` the one whose angle is nearest counts. Raises
    `InsufficientDataError` when no view shows one, and as `scan` does.
    """
    reporter, shape = reporter or Silent(), shape or GrooveShape()
    dataset = open_recording(dataset, reporter)
    tool = profiler(dataset, calibration, reporter, FACE_COLUMNS)
    profiles = find_profiles(tool, [view.index for view in dataset.views], reporter)
    found = [(profile.view, _root(tool, profile, shape)) for profile in profiles]
    roots = [root for _, root in found if root is not None]
    if not roots:
        raise InsufficientDataError(
            f"{dataset.folder}: needs a groove of {shape.opening_deg:g} ± {shape.tolerance_deg:g} degrees across the "
            f"stripe, found none in {len(profiles)} laser images"
        )
    points, covariances = _placed(tool, roots)
    return Seam(
        points,
        covariances,
        np.array([root.opening_angle for root in roots]),
        np.array([root.view for root in roots], np.int32),
        tuple(view for view, root in found if root is None),
    )


def _root(tool: Profiler, profile: Profile, shape: GrooveShape) -> _Root | None:
    if len(profile.pixels) == 0:
        return None
    corners, covariances, angles, _ = cah.findProfileCorners(
        profile.pixels,
        profile.sigmas,
        profile.segments,
        tool.calibration.camera_matrix,
        tool.calibration.distortion_coefficients,
        tool.light_plane,
        orientation=tool.orientation,
    )
    off = np.abs(angles.reshape(-1) - shape.opening_deg)
    if not (off <= shape.tolerance_deg).any():
        return None
    best = int(off.argmin())
    return _Root(profile.view, corners[best], covariances[best], float(angles[best, 0]))


def _placed(tool: Profiler, roots: list[_Root]) -> tuple[FloatArray, FloatArray]:
    pixels, covariances = [root.pixel for root in roots], [root.covariance for root in roots]
    points, spread, _ = tool.measure(pixels, covariances, [root.view for root in roots], list(range(len(roots))))
    return points, spread
