# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Settings of `calibrate`; unknown keys are refused."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from .calibration_format import LensName, check_camera_matrix, check_distortion
from .files import FloatArray
from .tracking import TrackingConfig


def optional(check: Callable[[Any], FloatArray]) -> BeforeValidator:
    """`check` for values other than None."""
    return BeforeValidator(lambda value: None if value is None else check(value))


class CalibrationOptions(BaseModel):
    """What is known beforehand, and what is asked.

    camera_matrix (3, 3): given = known and kept. distortion_coefficients (k1, k2, p1, p2[, k3]): given = known and
    kept; otherwise `lens_model` says which of them are estimated: "auto" = the smallest model that the data do not
    contradict (none with a known camera matrix). zero_skew holds for every camera with a solid-state sensor.
    robot_translation_mm, robot_rotation_deg: known standard deviations of the reported poses per axis; 0 = the robot is
    exact, None = estimated. allow_partial: answer what a robot that turns about one axis or none can answer.
    track_images: track the images also where the data set brings image points of its own.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=True)

    camera_matrix: Annotated[FloatArray | None, optional(check_camera_matrix)] = None
    distortion_coefficients: Annotated[FloatArray | None, optional(check_distortion)] = None
    lens_model: Literal["auto"] | LensName = "auto"
    zero_skew: bool = True
    square_pixels: bool = False
    robot_translation_mm: float | None = Field(default=None, ge=0, allow_inf_nan=False)
    robot_rotation_deg: float | None = Field(default=None, ge=0, allow_inf_nan=False)
    allow_partial: bool = False
    orientation_tolerance_deg: float = Field(default=0.05, gt=0, lt=10)
    use_laser: bool = True
    track_images: bool = False
    tracking: TrackingConfig = TrackingConfig()

    @model_validator(mode="after")
    def _consistent(self) -> CalibrationOptions:
        if self.camera_matrix is not None and self.square_pixels:
            raise ValueError("square_pixels: needs an unknown camera matrix, but camera_matrix is given")
        if self.distortion_coefficients is not None and self.lens_model != "auto":
            raise ValueError(f"lens_model: needs unknown distortion for {self.lens_model!r}, but it is given")
        if self.distortion_coefficients is not None and len(self.distortion_coefficients) > 5:
            raise ValueError("distortion_coefficients: needs k1, k2, p1, p2[, k3]; other lens models are not supported")
        if (self.robot_translation_mm == 0) != (self.robot_rotation_deg == 0):
            raise ValueError("robot_translation_mm, robot_rotation_deg: need both 0 (an exact robot) or neither")
        return self

    def constraints(self) -> tuple[str, ...]:
        """Names of what is kept instead of estimated, for the result file."""
        known = self.camera_matrix is not None
        unknown_lens = self.distortion_coefficients is None
        names = {
            "known_camera_matrix": known,
            "zero_skew": self.zero_skew and not known,
            "square_pixels": self.square_pixels,
            "no_distortion": unknown_lens and (self.lens_model == "none" or (known and self.lens_model == "auto")),
            "known_distortion": not unknown_lens,
            "exact_robot": self.robot_translation_mm == 0,
            "known_robot_translation_noise": bool(self.robot_translation_mm),
            "known_robot_rotation_noise": bool(self.robot_rotation_deg),
        }
        return tuple(name for name, holds in names.items() if holds)
