# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Profiles: the stripe of one laser image, and where in the base frame its points lie.

Stripe and points come from `cah.detectStripe`, `cah.splitStripe`, `cah.locateOnStripe` and `cah.reprojectStripe`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import cv_active_handeye as cah

from ..calibration import Calibration
from ..dataset import Dataset, Image
from ..files import FileFormatError, FloatArray
from .calibrated import noise_levels_for
from .evidence import stripe_params
from .reporter import InsufficientDataError, Reporter

NEAR = 10.0
"""Pixels across the stripe between it and the pixel that names a point of it."""


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


@dataclass(frozen=True)
class Profiler:
    """A data set with laser images, and the calibration that makes points of its stripes; see `profiler`."""

    dataset: Dataset
    calibration: Calibration
    light_plane: FloatArray
    robot_translation_sigma: float
    robot_rotation_sigma: float
    least_columns: int

    @property
    def orientation(self) -> int:
        """Of the stripe, for the functions of `cah`."""
        return int(cah.STRIPE_VERTICAL if self.along else cah.STRIPE_HORIZONTAL)

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
        least = self.least_columns
        segments = cah.splitStripe(pixels, sigmas, K, D, minPoints=least) if found else np.zeros(0, np.int32)
        return Profile(view, pixels, sigmas.reshape(-1), segments.reshape(-1), _intensity(image, pixels))

    def on_line(
        self, profile: Profile, pixel: FloatArray, sigma: float = 0.0, orientation: int | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """The point (2,) px of a straight piece of the line that `pixel` (2,) names, and its covariance (2, 2) px^2.

        sigma: standard deviation of `pixel` along the line, px; orientation: None = that of the stripe. NaN where no
        straight piece is within `NEAR`.
        """
        points, covariances = cah.locateOnStripe(
            profile.pixels,
            profile.sigmas,
            profile.segments,
            pixel[None],
            self.calibration.camera_matrix,
            self.calibration.distortion_coefficients,
            sigmaAlong=sigma,
            orientation=self.orientation if orientation is None else orientation,
            maxDistance=NEAR,
        )
        return points[0], covariances[0]

    def place(self, profile: Profile) -> tuple[FloatArray, FloatArray]:
        """Points (M, 3) m of a profile in the base frame, and their covariances (M, 3, 3) m^2 from image, robot and
        calibration; NaN for pixels whose ray does not meet the light plane in front of the camera."""
        where, calibration = self.dataset.views[profile.view], self.calibration
        points, covariances = cah.reprojectStripe(
            profile.pixels,
            calibration.camera_matrix,
            calibration.distortion_coefficients,
            self.light_plane,
            R_cam2gripper=calibration.R_cam2gripper,
            t_cam2gripper=calibration.t_cam2gripper,
            R_gripper2base=where.R_gripper2base,
            t_gripper2base=where.t_gripper2base,
            calibrationCovariance=calibration.covariance,
            pixelSigmas=profile.sigmas,
            robotTranslationSigma=self.robot_translation_sigma,
            robotRotationSigma=self.robot_rotation_sigma,
            allowMissed=True,
        )
        assert covariances is not None
        return points, covariances

    def measure(
        self,
        pixels: Sequence[FloatArray],
        covariances: Sequence[FloatArray],
        views: Sequence[int],
        point_ids: Sequence[int],
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Points (P, 3) m in the base frame and covariances (P, 3, 3) m^2, from N pixels (2,) and their covariances
        (2, 2) px^2, each of the point `point_ids` seen in `views`; and (N,) how far each contradicts its point.

        Raises `cah.error` (StsOutOfRange) for pixels whose ray does not meet the light plane in front of the camera.
        """
        points, spread, disagreements = cah.measureStripePoints(
            self.dataset.R_gripper2base,
            self.dataset.t_gripper2base,
            pixels,
            views,
            point_ids,
            self.calibration.camera_matrix,
            self.calibration.distortion_coefficients,
            self.light_plane,
            self.calibration.R_cam2gripper,
            self.calibration.t_cam2gripper,
            calibrationCovariance=self.calibration.covariance,
            pixelCovariances=covariances,
            robotTranslationSigma=self.robot_translation_sigma,
            robotRotationSigma=self.robot_rotation_sigma,
        )
        return points, spread, disagreements.reshape(-1)


LEAST_COLUMNS = 20
"""Of a straight piece."""


def profiler(
    dataset: Dataset, calibration: Calibration, reporter: Reporter, least_columns: int = LEAST_COLUMNS
) -> Profiler:
    """`FileFormatError` for a calibration without light plane, of version 1, or for images of another size."""
    levels = noise_levels_for(dataset, calibration, reporter)
    if calibration.light_plane is None:
        raise FileFormatError(
            "calibration: needs a light plane, has none; record laser images (laser_image) and calibrate again"
        )
    translation, rotation = levels.robot_translation.level, levels.robot_rotation.level
    return Profiler(dataset, calibration, calibration.light_plane, translation, rotation, least_columns)


def find_profiles(tool: Profiler, views: list[int], reporter: Reporter) -> list[Profile]:
    """The profiles of those of the `views` that have a laser image; `InsufficientDataError` when none has."""
    views = [view for view in views if tool.dataset.views[view].laser_image is not None]
    if not views:
        raise InsufficientDataError(f"{tool.dataset.folder}: needs views with an image taken with the laser on, has 0")
    if len(views) > 2 and _all_at_one_place(tool.dataset, views):
        reporter.note("all laser images have the same robot pose; was the pose recorded at every stop?")
    progress = reporter.step(f"finding the stripe in {len(views)} images")
    found: list[Profile] = []
    for done, view in enumerate(views, start=1):
        profile = tool.profile(view)
        assert profile is not None
        found.append(profile)
        progress(done, len(views))
    return found


def _all_at_one_place(dataset: Dataset, views: list[int]) -> bool:
    R, t = dataset.R_gripper2base[views], dataset.t_gripper2base[views]
    return bool((R[0] == R).all() and (t == t[0]).all())


def _intensity(image: Image, pixels: FloatArray) -> NDArray[np.float32]:
    u, v = np.rint(pixels).astype(np.int64).reshape(-1, 2).T
    grey = image[v, u]
    return np.asarray(grey.mean(axis=1) if grey.ndim == 2 else grey, np.float32)
