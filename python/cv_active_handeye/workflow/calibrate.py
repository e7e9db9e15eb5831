# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""From a data set to a calibration: open, points, refinement from points, stripes, refinement with stripes, result.

Everything that is estimated comes from the C++ functions named in each step; this file only carries data between them.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv_active_handeye as cah

from ..calibration import Calibration
from ..config import CalibrationOptions
from ..dataset import Dataset
from .evidence import Evidence, ImagePoints, StripeSegment, find_points, find_stripes, open_recording
from .refinement import Refined, Start, refine
from .reporter import Reporter, Silent
from .result import calibration_of


def calibrate(
    dataset: Dataset | str | Path, options: CalibrationOptions | None = None, reporter: Reporter | None = None
) -> Calibration:
    """Calibrates camera, hand-eye transform and, with laser images, the light plane.

    Raises `cah.error` (with what is missing) or `InsufficientDataError` when the data do not determine the result, and
    `FileFormatError` for a damaged data set. A result that contradicts its data is returned; `verdict.usable` is False.
    """
    return calibrate_with_evidence(dataset, options, reporter)[0]


def calibrate_with_evidence(
    dataset: Dataset | str | Path,
    options: CalibrationOptions | None = None,
    reporter: Reporter | None = None,
    points: ImagePoints | None = None,
    start: Start | None = None,
) -> tuple[Calibration, Evidence]:
    """`calibrate`, and the points, stripes and summary behind it, for pictures and reports.

    `points` replaces `find_points`; `start` replaces the closed forms, which need pure translations.
    """
    options, reporter = options or CalibrationOptions(), reporter or Silent()
    dataset = open_recording(dataset, reporter)
    points = find_points(dataset, options, reporter) if points is None else points
    refined = _refine_points(dataset, points, options, start or Start(), reporter)
    segments = _find_stripes(dataset, points, refined, options, reporter)
    refined = _refine_with_stripes(dataset, points, segments, refined, options, reporter)
    return _result(dataset, points, segments, refined, options, reporter)


def _refine_points(
    dataset: Dataset, points: ImagePoints, options: CalibrationOptions, start: Start, reporter: Reporter
) -> Refined:
    progress = reporter.step("refining camera and hand-eye transform, from the points")
    refined = refine(dataset, points, options, start)
    progress(1, 1)
    return refined


def _find_stripes(
    dataset: Dataset, points: ImagePoints, refined: Refined, options: CalibrationOptions, reporter: Reporter
) -> list[StripeSegment]:
    """Straight segments in the laser images, and which of them lie on one plane of the scene."""
    if not options.use_laser:
        return []
    segments = find_stripes(dataset, refined.camera_matrix, refined.distortion, reporter)
    if not segments:
        reporter.note("no light plane: the data set has no laser image that shows a stripe")
    return _associate(dataset, segments, points, refined, reporter)


def _associate(
    dataset: Dataset, segments: list[StripeSegment], points: ImagePoints, refined: Refined, reporter: Reporter
) -> list[StripeSegment]:
    """Takes the surfaces from the data set where they are written there, else finds them with the tracks."""
    known = [dataset.views[segment.view].surface_id for segment in segments]
    if not segments or None not in known:
        return _on_surfaces(segments, [k for k in known if k is not None])
    progress = reporter.step(f"finding the surfaces of {len(segments)} stripe segments")
    surfaces, _ = cah.associateStripes(
        dataset.R_gripper2base,
        dataset.t_gripper2base,
        [segment.points for segment in segments],
        [segment.view for segment in segments],
        points.points,
        refined.camera_matrix,
        refined.distortion,
        refined.R_cam2gripper,
        refined.t_cam2gripper,
    )
    progress(1, 1)
    return _on_surfaces(segments, surfaces.reshape(-1).tolist())


def _on_surfaces(segments: list[StripeSegment], surfaces: Sequence[int]) -> list[StripeSegment]:
    return [StripeSegment(s.view, s.points, k) for s, k in zip(segments, surfaces, strict=True)]


def _refine_with_stripes(
    dataset: Dataset,
    points: ImagePoints,
    segments: list[StripeSegment],
    refined: Refined,
    options: CalibrationOptions,
    reporter: Reporter,
) -> Refined:
    """Starts from the refinement without stripes."""
    if not segments:
        return refined
    progress = reporter.step(f"refining everything with {len(segments)} stripe segments")
    start = Start(refined.camera_matrix, refined.R_cam2gripper, refined.t_cam2gripper)
    refined = refine(dataset, points, options, start, segments)
    progress(1, 1)
    return refined


def _result(
    dataset: Dataset,
    points: ImagePoints,
    segments: list[StripeSegment],
    refined: Refined,
    options: CalibrationOptions,
    reporter: Reporter,
) -> tuple[Calibration, Evidence]:
    result = calibration_of(refined, dataset, points, segments, options)
    if not refined.summary.usable:
        reporter.note(refined.summary.message)
    return result, Evidence(points.points, tuple(segments), points.sigmas, refined.summary)
