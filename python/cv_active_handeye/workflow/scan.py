# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""From laser images to a point cloud in the robot's base frame: one profile a view, every point with its sigma."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..calibration import Calibration
from ..dataset import Dataset
from ..files import FloatArray
from .evidence import open_recording
from .profiles import Profile, Profiler, find_profiles, profiler
from .reporter import InsufficientDataError, Reporter, Silent


@dataclass(frozen=True)
class Scan:
    """A point cloud, in the order of the views and along each stripe.

    points (N, 3): base frame, m; sigmas (N,): standard deviation of a point in its worst direction, m, from image,
    robot and calibration; infinite where the calibration leaves the position open. intensity (N,): grey level of the
    laser image; views (N,): number of the view. empty_views: with a laser image but without points; beyond_limit:
    points left out for their sigma.
    """

    points: FloatArray
    sigmas: FloatArray
    intensity: NDArray[np.float32]
    views: NDArray[np.int32]
    empty_views: tuple[int, ...] = ()
    beyond_limit: int = 0


def scan(
    dataset: Dataset | str | Path,
    calibration: Calibration,
    max_sigma: float | None = None,
    reporter: Reporter | None = None,
) -> Scan:
    """Every point of the stripe in every laser image; points whose sigma exceeds `max_sigma` (m) are left out.

    Raises `InsufficientDataError` when no point is left, `FileFormatError` for a calibration without light plane or one
    that does not belong to the data set.
    """
    reporter = reporter or Silent()
    dataset = open_recording(dataset, reporter)
    tool = profiler(dataset, calibration, reporter)
    profiles = find_profiles(tool, [view.index for view in dataset.views], reporter)
    return _cloud(tool, profiles, max_sigma, reporter)


def _cloud(tool: Profiler, profiles: list[Profile], max_sigma: float | None, reporter: Reporter) -> Scan:
    progress = reporter.step("placing the points in the base frame")
    parts, empty = [], []
    for done, profile in enumerate(profiles, start=1):
        part = _placed(tool, profile, reporter)
        if part is None:
            empty.append(profile.view)
        else:
            parts.append(part)
        progress(done, len(profiles))
    if not parts:
        raise InsufficientDataError(
            f"{tool.dataset.folder}: needs a stripe in a laser image, found none in {len(profiles)}; is the laser on, "
            "and does it run as laser.stripe in dataset.yaml says (horizontal or vertical)?"
        )
    points, sigmas, intensity, views = (np.concatenate(column) for column in zip(*parts, strict=True))
    keep = np.ones(len(sigmas), np.bool_) if max_sigma is None else sigmas <= max_sigma
    if max_sigma is not None and not keep.any():
        limit, best = 1000 * max_sigma, 1000 * sigmas.min()
        raise InsufficientDataError(
            f"{tool.dataset.folder}: no point has a sigma of {limit:g} mm or less; the best of {len(sigmas)} has "
            f"{best:.3g} mm"
        )
    cloud = (points[keep], sigmas[keep], intensity[keep], views[keep])
    return Scan(*cloud, tuple(empty), int((~keep).sum()))


def _placed(
    tool: Profiler, profile: Profile, reporter: Reporter
) -> tuple[FloatArray, FloatArray, NDArray[np.float32], NDArray[np.int32]] | None:
    """Points, sigmas, intensity and view numbers of one profile; None when there are no points."""
    if len(profile.pixels) == 0:
        reporter.note(f"view {profile.view}: skipped, no stripe was found")
        return None
    points, covariances = tool.place(profile)
    met = ~np.isnan(points[:, 0])
    if not met.all():
        missed = f"{(~met).sum()} of {len(met)} stripe points do not see the light plane"
        reporter.note(f"view {profile.view}: {missed}: reflections, or the calibration is of another laser")
    if not met.any():
        return None
    views = np.full(met.sum(), profile.view, np.int32)
    return points[met], worst_sigma(covariances[met]), profile.intensity[met], views


def worst_sigma(covariances: FloatArray) -> FloatArray:
    """Standard deviation (M,) in the worst direction of covariances (M, 3, 3); infinite where a variance is."""
    known = np.isfinite(covariances).all(axis=(1, 2))
    sigmas = np.full(len(covariances), np.inf)
    sigmas[known] = np.sqrt(np.linalg.eigvalsh(covariances[known])[:, -1])
    return sigmas
