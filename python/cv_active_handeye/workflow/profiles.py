# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Profiles: the stripe of one laser image, and where in the base frame its points lie.

Stripe and points come from `cah.detectStripe`, `cah.splitStripe` and `cah.reprojectStripe`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import cv_active_handeye as cah

from ..calibration import Calibration
from ..dataset import Dataset, Image
from ..files import FileFormatError, FloatArray
from .calibrated import noise_levels_for
from .evidence import stripe_params
from .reporter import InsufficientDataError, Reporter


class Profile(NamedTuple):
    """One stripe, a row a column of the image (a row of the image where the stripe is vertical).

    pixels (M, 2): centre line, px; sigmas (M,): standard deviations across the stripe, px; segments (M,): number of the
    straight piece, -1 = on none; intensity (M,): grey level of the laser image at the centre line.
    """

    view: int
    pixels: FloatArray
    sigmas: FloatArray
    segments: NDArray[np.int32]
    intensity: NDArray[np.float32]


class Located(NamedTuple):
    """Points of one view in the base frame.

    points (M, 3) m; noise (M, 3, 3) m^2: covariances from the image and from this view's robot pose; shared (M, 3, 3)
    m^2: from the calibration, whose errors all points of all views have in common.
    """

    points: FloatArray
    noise: FloatArray
    shared: FloatArray


@dataclass(frozen=True)
class Profiler:
    """A data set with laser images, and the calibration that makes points of its stripes; see `profiler`."""

    dataset: Dataset
    calibration: Calibration
    light_plane: FloatArray
    robot_translation_sigma: float
    robot_rotation_sigma: float

    @property
    def along(self) -> int:
        """Which pixel coordinate counts along the stripe: 0 = u (horizontal stripes), 1 = v (vertical ones)."""
        return int(self.dataset.laser is not None and self.dataset.laser.stripe == "vertical")

    def profile(self, view: int) -> Profile | None:
        """The stripe of a view, without points where none is seen; None where the view has no laser image."""
        image = self.dataset.laser_image(view)
        if image is None:
            return None
        params = stripe_params(self.dataset)
        pixels, sigmas = cah.detectStripe(image, background=self.dataset.image(view), params=params)
        K, D = self.calibration.camera_matrix, self.calibration.distortion_coefficients
        found = len(pixels) > 0
        segments = cah.splitStripe(pixels, sigmas, K, D) if found else np.zeros(0, np.int32)
        return Profile(view, pixels, sigmas.reshape(-1), segments.reshape(-1), _intensity(image, pixels))

    def locate(self, view: int, pixels: FloatArray, sigmas: FloatArray) -> Located:
        """Pixels (M, 2) of a view with standard deviations (M,) px as points in the base frame.

        Raises `cah.error` (StsOutOfRange) for pixels whose ray does not meet the light plane in front of the camera.
        """
        points, noise = self._reproject(
            view,
            pixels,
            pixelSigmas=sigmas,
            robotTranslationSigma=self.robot_translation_sigma,
            robotRotationSigma=self.robot_rotation_sigma,
        )
        _, shared = self._reproject(view, pixels, calibrationCovariance=self.calibration.covariance)
        return Located(points, noise, shared)

    def _reproject(self, view: int, pixels: FloatArray, **errors: Any) -> tuple[FloatArray, FloatArray]:
        where = self.dataset.views[view]
        points, covariances = cah.reprojectStripe(
            pixels,
            self.calibration.camera_matrix,
            self.calibration.distortion_coefficients,
            self.light_plane,
            R_cam2gripper=self.calibration.R_cam2gripper,
            t_cam2gripper=self.calibration.t_cam2gripper,
            R_gripper2base=where.R_gripper2base,
            t_gripper2base=where.t_gripper2base,
            **errors,
        )
        assert covariances is not None
        return points, covariances


def profiler(dataset: Dataset, calibration: Calibration, reporter: Reporter) -> Profiler:
    """`FileFormatError` for a calibration without light plane, of version 1, or for images of another size."""
    levels = noise_levels_for(dataset, calibration, reporter)
    if calibration.light_plane is None:
        raise FileFormatError(
            "calibration: needs a light plane, has none; record laser images (laser_image) and calibrate again"
        )
    translation, rotation = levels.robot_translation.level, levels.robot_rotation.level
    return Profiler(dataset, calibration, calibration.light_plane, translation, rotation)


def find_profiles(tool: Profiler, views: list[int], reporter: Reporter) -> list[Profile]:
    """The profiles of those of the `views` that have a laser image; `InsufficientDataError` when none has."""
    views = [view for view in views if tool.dataset.views[view].laser_image is not None]
    if not views:
        raise InsufficientDataError(f"{tool.dataset.folder}: needs views with an image taken with the laser on, has 0")
    progress = reporter.step(f"finding the stripe in {len(views)} images")
    found: list[Profile] = []
    for done, view in enumerate(views, start=1):
        profile = tool.profile(view)
        assert profile is not None
        found.append(profile)
        progress(done, len(views))
    return found


def column_scatter(profiles: Sequence[Profile], along: int) -> float:
    """How many times their stated `sigmas` the columns scatter about their straight pieces, at least 1.

    Grain of the laser light and texture, which a single profile does not show, are in it. A parabola is fitted to every
    piece, since the lens may bend it. 1 where no profile has a straight piece.
    """
    squares, freedom = 0.0, 0
    for profile in profiles:
        for number in range(profile.segments.max(initial=-1) + 1):
            on = profile.segments == number
            x, y = profile.pixels[on][:, along], profile.pixels[on][:, 1 - along]
            _, rest, *_ = np.polyfit(x - x.mean(), y, 2, w=1 / profile.sigmas[on], full=True)
            squares += float(rest.sum())
            freedom += len(x) - 3
    return max(1.0, float(np.sqrt(squares / freedom))) if freedom else 1.0


def _intensity(image: Image, pixels: FloatArray) -> NDArray[np.float32]:
    u, v = np.rint(pixels).astype(np.int64).reshape(-1, 2).T
    grey = image[v, u]
    return np.asarray(grey.mean(axis=1) if grey.ndim == 2 else grey, np.float32)
