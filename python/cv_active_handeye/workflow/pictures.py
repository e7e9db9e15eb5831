# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Chooses what of a calibration is worth a picture, and draws it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import cv_active_handeye as cah

from ..calibration import Calibration
from ..dataset import Dataset
from ..files import FloatArray
from ..report import picture_motion, picture_stripe, picture_tracks
from .evidence import Evidence


def draw_pictures(folder: Path, dataset: Dataset, calibration: Calibration, evidence: Evidence) -> tuple[Path, ...]:
    """Draws what the recording allows: tracks, motion, and the stripe of the view with most known surfaces."""
    group_ids = cah.groupViews(dataset.R_gripper2base).reshape(-1)
    drawn = [folder / "motion.png"]
    K = calibration.camera_matrix
    view_angle = (calibration.image_width / (2 * K[0, 0]), calibration.image_height / (2 * K[1, 1]))
    picture_motion(
        folder / "motion.png",
        dataset.R_gripper2base,
        dataset.t_gripper2base,
        calibration.R_cam2gripper,
        calibration.t_cam2gripper,
        group_ids,
        view_angle,
    )
    group = _largest_group(group_ids)
    view = _best_seen(evidence.image_points, group)
    image = dataset.image(view)
    if image is not None:
        drawn.append(folder / "tracks.png")
        picture_tracks(folder / "tracks.png", image, evidence.image_points, view, group)
    if evidence.segments:
        known = [segment.view for segment in evidence.segments if segment.surface >= 0]
        numbers = known or [segment.view for segment in evidence.segments]
        view = max(set(numbers), key=lambda number: (numbers.count(number), -number))
        segments = [(s.points, s.surface) for s in evidence.segments if s.view == view]
        image = dataset.laser_image(view)
        assert image is not None
        drawn.append(folder / "stripe.png")
        picture_stripe(folder / "stripe.png", image, segments, view)
    return tuple(drawn)


def _largest_group(group_ids: NDArray[np.int32]) -> list[int]:
    numbers, counts = np.unique(group_ids, return_counts=True)
    return [int(i) for i in np.flatnonzero(group_ids == numbers[counts.argmax()])]


def _best_seen(image_points: FloatArray, group: list[int]) -> int:
    counts = np.isfinite(image_points[group]).all(axis=2).sum(axis=1)
    return group[int(counts.argmax())]
