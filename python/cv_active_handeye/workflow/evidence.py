# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What a data set shows: points followed through its images, and straight stripe segments in its laser images."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

import cv_active_handeye as cah

from ..config import CalibrationOptions
from ..dataset import Dataset
from ..files import FloatArray
from ..tracking import TrackingError, track_points
from .reporter import InsufficientDataError, Reporter

UNSURE = -1
MOST_PROBLEMS = 5
"""Of a data set, told one by one."""


@dataclass(frozen=True)
class StripeSegment:
    """A straight piece of a stripe: `points` (M, 2) px in image `view`; equal `surface` = same plane of the scene."""

    view: int
    points: FloatArray
    surface: int = UNSURE


class ImagePoints(NamedTuple):
    """`points` (V, N, 2) px, NaN = not seen; `sigmas` (V, N): the standard deviations per axis that the tracker states,
    None for points that came with the data set; `object_points` (N, 3): where they are on a board, m, None without."""

    points: FloatArray
    sigmas: FloatArray | None = None
    object_points: FloatArray | None = None

    @property
    def stated_sigma(self) -> float | None:
        """Median of `sigmas`, px."""
        return None if self.sigmas is None else float(np.nanmedian(self.sigmas))

    @property
    def relative_sigmas(self) -> FloatArray | None:
        """`sigmas` in units of `stated_sigma`: with them a noise level is that of a typical point, in px."""
        return None if self.sigmas is None else np.asarray(self.sigmas / np.nanmedian(self.sigmas))


@dataclass(frozen=True)
class Evidence:
    """What was found in the images: `image_points` (V, N, 2) px, NaN = not seen, and the stripe segments.

    `point_sigmas` (V, N) px as the tracker states them, and `summary`: what `cah.refineHandEye` made of it all.
    """

    image_points: FloatArray
    segments: tuple[StripeSegment, ...]
    point_sigmas: FloatArray | None = None
    summary: cah.RefineSummary | None = None


def open_recording(dataset: Dataset | str | Path, reporter: Reporter) -> Dataset:
    """Opens the data set and passes on what it lacks."""
    if not isinstance(dataset, Dataset):
        dataset = Dataset.open(dataset)
    problems = dataset.problems()
    for problem in problems[:MOST_PROBLEMS]:
        reporter.note(f"data set: {problem}")
    if len(problems) > MOST_PROBLEMS:
        reporter.note(f"data set: {len(problems) - MOST_PROBLEMS} more problems; cv-active-handeye show tells them all")
    return dataset


def find_points(dataset: Dataset, options: CalibrationOptions, reporter: Reporter) -> ImagePoints:
    """The data set's own image points where it has some, else tracks of its laser-off images."""
    stored = None if options.track_images else dataset.image_points()
    if stored is not None:
        reporter.step(f"reading {stored.shape[1]} image points")(1, 1)
        return ImagePoints(stored)
    found = [(view.index, dataset.image(view.index)) for view in dataset.views]
    images = {index: image for index, image in found if image is not None}
    if len(images) < 2:
        text = f"{dataset.folder}: tracking needs two views with an image taken with the laser off, has {len(images)}"
        raise InsufficientDataError(text)
    views = list(images)
    progress = reporter.step(f"tracking points in {len(views)} images")
    try:
        tracks = track_points(list(images.values()), dataset.R_gripper2base[views], options.tracking, progress)
    except TrackingError as error:
        raise InsufficientDataError(f"{dataset.folder}: {error}") from error
    for view in tracks.empty_views:
        reporter.note(f"view {views[view]} shares no points with the others")
    points = np.full((len(dataset), len(tracks), 2), np.nan)
    sigmas = np.full((len(dataset), len(tracks)), np.nan)
    points[views], sigmas[views] = tracks.points, tracks.sigmas
    return ImagePoints(points, sigmas)


def stripe_params(dataset: Dataset) -> cah.StripeParams:
    """What `cah.detectStripe` has to know of the data set's laser."""
    params = cah.StripeParams()
    if dataset.laser is not None:
        vertical = dataset.laser.stripe == "vertical"
        params.orientation = int(cah.STRIPE_VERTICAL if vertical else cah.STRIPE_HORIZONTAL)
        params.sigma = dataset.laser.sigma_px
    return params


def find_stripes(
    dataset: Dataset, camera_matrix: FloatArray, distortion: FloatArray | None, reporter: Reporter
) -> list[StripeSegment]:
    """Straight segments of the stripe in every laser image; the laser-off image of the view is the background."""
    found = [(view.index, dataset.laser_image(view.index)) for view in dataset.views]
    images = {index: image for index, image in found if image is not None}
    progress = reporter.step(f"finding the stripe in {len(images)} images") if images else None
    params = stripe_params(dataset)
    segments: list[StripeSegment] = []
    for done, (index, image) in enumerate(images.items(), start=1):
        points, sigmas = cah.detectStripe(image, background=dataset.image(index), params=params)
        if len(points):
            labels = cah.splitStripe(points, sigmas, camera_matrix, distortion).reshape(-1)
            segments += [StripeSegment(index, points[labels == k]) for k in range(labels.max() + 1)]
        if progress:
            progress(done, len(images))
    return segments
