# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The parts of `calibration.yaml`, each explained in doc/files.md."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, field_validator

from .files import FloatArray, finite_array
from .opencv_yaml import unpack

LensName = Literal["none", "k1", "k1-k2", "tangential", "k3"]
LENS_NAMES: tuple[LensName, ...] = ("none", "k1", "k1-k2", "tangential", "k3")
"""In the order of cah.LENS_FIXED to cah.LENS_K3; every model has the coefficients of the one before it, too."""


class Part(BaseModel):
    """A map of the file: keys that are not listed are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=True)


def matrix(check: Callable[[Any], Any]) -> BeforeValidator:
    """Takes an OpenCV matrix map or an array, and lets `check` refuse it; None stays None."""
    return BeforeValidator(lambda value: None if value is None else check(unpack(value)))


def numbers(*shape: int | None) -> Callable[[Any], FloatArray]:
    """A check for arrays of `shape` (None = any length; vectors may be n x 1) that may hold infinities and NaN."""

    def check(value: Any) -> FloatArray:
        array = _array(value)
        array = array.reshape(-1) if len(shape) == 1 and array.size in array.shape else array
        if array.ndim != len(shape) or any(n not in (None, m) for n, m in zip(shape, array.shape, strict=True)):
            raise ValueError(f"needs shape {_shape_text(shape)}, given {_shape_text(array.shape)}")
        array.flags.writeable = False
        return array

    return check


def _array(value: Any) -> FloatArray:
    """`value`, or an OpenCV matrix map, as a new array; else ValueError."""
    content = unpack(value)
    try:
        return np.array(content, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ValueError(f"needs numbers, given {value!r:.80}") from error


def _shape_text(shape: tuple[int | None, ...]) -> str:
    return " x ".join("n" if n is None else str(n) for n in shape) or "a single value"


def check_camera_matrix(value: Any) -> FloatArray:
    """`value` (3, 3, or an OpenCV matrix map) as a read-only camera matrix; ValueError says what it lacks."""
    K = finite_array(unpack(value), (3, 3))
    if K[2].tolist() != [0, 0, 1] or K[1, 0] != 0 or K[0, 0] <= 0 or K[1, 1] <= 0:
        raise ValueError(f"needs [[fx, skew, cx], [0, fy, cy], [0, 0, 1]] with positive fx, fy, given {K.tolist()}")
    return K


def check_distortion(value: Any) -> FloatArray:
    """`value` (or an OpenCV matrix map) as a read-only vector of OpenCV distortion coefficients; else ValueError."""
    coefficients = finite_array(_array(value).reshape(-1), (None,))
    if len(coefficients) not in (4, 5, 8, 12, 14):
        raise ValueError(f"needs 4, 5, 8, 12 or 14 numbers (zeros = no distortion), given {len(coefficients)}")
    return coefficients


def check_light_plane(value: Any) -> FloatArray | None:
    """`value` as a read-only light plane (nx, ny, nz, d), or None; else ValueError."""
    if value is None:
        return None
    plane = finite_array(_array(value).reshape(-1), (4,))
    length = float(np.linalg.norm(plane[:3]))
    if abs(length - 1) > 1e-6 or plane[3] <= 0:
        raise ValueError(f"needs (nx, ny, nz, d) with |n| = 1 and d > 0, given |n| = {length:.6g}, d = {plane[3]:.6g}")
    return plane


def check_covariance(value: Any) -> FloatArray:
    """`value` as a read-only square matrix without NaN; variances may be infinite; else ValueError."""
    C = _array(value)
    if C.ndim != 2 or C.shape[0] != C.shape[1] or np.isnan(C).any() or (np.diag(C) < 0).any():
        raise ValueError(f"needs a square matrix without NaN or negative variances, given shape {C.shape}")
    C.flags.writeable = False
    return C


class Rms(Part):
    """Root mean square residuals in pixels: of the image points and stripes, or in version 1 of the steps that ran."""

    points_px: float | None = None
    stripes_px: float | None = None
    translations_px: float | None = None
    rotation_px: float | None = None
    light_plane_px: float | None = None


class NoiseLevel(Part):
    """A standard deviation with its 95 % interval; both ends equal the level where it was given."""

    level: float = Field(ge=0)
    lower: float = Field(ge=0)
    upper: float = Field(ge=0)
    estimated: bool


class NoiseLevels(Part):
    """Pixels, metres and rad, one axis each. `stated_points_px`: median of the standard deviations that the tracker
    stated, of which `image_points` estimates the size; None where the points came without."""

    image_points: NoiseLevel
    stripes: NoiseLevel | None = None
    robot_translation: NoiseLevel
    robot_rotation: NoiseLevel
    stated_points_px: float | None = Field(default=None, gt=0)


class Lens(Part):
    """Which distortion coefficients were estimated; `chosen`: by the test whose rows (`RefineSummary::lensTests`) are
    `tests`: Wald statistic of the coefficients that none, k1, k1-k2, tangential and k3 lack, their number, p-value,
    information criterion."""

    model: LensName
    chosen: bool
    tests: Annotated[FloatArray, matrix(numbers(len(LENS_NAMES), 4))]


class ChiSquare(Part):
    """Test of the noise levels that were given."""

    value: float
    degrees_of_freedom: float
    p_value: float


class Verdict(Part):
    """Whether the result may be used, and what was left out."""

    usable: bool
    message: str
    stop_reason: str = ""
    rejected_views: tuple[int, ...] = ()
    rejected_observations: int = Field(default=0, ge=0)
    rejected_segments: tuple[int, ...] = ()
    culprits: tuple[str, ...] = ()
    weak_directions: tuple[str, ...] = ()

    @field_validator("message", "stop_reason", "culprits", "weak_directions")
    @classmethod
    def _printable(cls, value: str | tuple[str, ...]) -> str | tuple[str, ...]:
        for text in (value,) if isinstance(value, str) else value:
            check_printable(text)
        return value


class Tool(Part):
    """What the calibration's errors are worth at the working distance (m), in the gripper frame.

    `accuracy`: half of the 95 % interval in the worst direction, m, infinite where the data do not determine it;
    `covariance` (3, 3) m^2.
    """

    working_distance: float
    accuracy: float
    covariance: Annotated[FloatArray, matrix(numbers(3, 3))]


def check_printable(text: str) -> str:
    """`text` if it can stand on one line of a file; else ValueError."""
    if not text.isprintable():
        raise ValueError(f"needs printable text, given {text!r}")
    return text
