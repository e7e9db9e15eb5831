# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Settings of `calibrate`; unknown keys are refused."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from .calibration import check_camera_matrix, check_distortion
from .files import FloatArray
from .tracking import TrackingConfig


def optional(check: Callable[[Any], FloatArray]) -> BeforeValidator:
    """`check` for values other than None."""
    return BeforeValidator(lambda value: None if value is None else check(value))


class CalibrationOptions(BaseModel):
    """What is known beforehand and how the closed forms are asked.

    `camera_matrix` (3, 3) given = known and kept; `distortion_coefficients` are always taken as given (none = no
    distortion: the closed forms do not estimate it). `zero_skew` holds for every camera with a solid-state sensor.
    `track_images` tracks the images also where the data set brings image points of its own.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=True)

    camera_matrix: Annotated[FloatArray | None, optional(check_camera_matrix)] = None
    distortion_coefficients: Annotated[FloatArray | None, optional(check_distortion)] = None
    zero_skew: bool = True
    square_pixels: bool = False
    method: Literal["metric", "foe"] = "metric"
    orientation_tolerance_deg: float = Field(default=0.05, gt=0, lt=10)
    use_laser: bool = True
    track_images: bool = False
    tracking: TrackingConfig = TrackingConfig()

    @model_validator(mode="after")
    def _consistent(self) -> CalibrationOptions:
        if self.camera_matrix is not None and self.square_pixels:
            raise ValueError("square_pixels: needs an unknown camera matrix, but camera_matrix is given")
        return self

    def constraints(self) -> tuple[str, ...]:
        """Names of what is kept instead of estimated, for the result file."""
        known = self.camera_matrix is not None
        names = {
            "known_camera_matrix": known,
            "zero_skew": self.zero_skew and not known,
            "square_pixels": self.square_pixels,
            "no_distortion": self.distortion_coefficients is None,
            "known_distortion": self.distortion_coefficients is not None,
        }
        return tuple(name for name, holds in names.items() if holds)
