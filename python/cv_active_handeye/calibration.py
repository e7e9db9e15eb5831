# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The result of a calibration and its file `calibration.yaml`, which `cv::FileStorage` and PyYAML both read.

Lengths are metres, angles radians. `R_cam2gripper`, `t_cam2gripper` map a point in the camera frame into the gripper
frame; the light plane is (nx, ny, nz, d) in the camera frame with n.X = d, |n| = 1, d > 0. Every key: doc/files.md.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any, Literal

import cv2
import numpy as np
from pydantic import BeforeValidator, Field, field_validator, model_validator

from .calibration_format import (
    ChiSquare,
    Lens,
    NoiseLevels,
    Part,
    Rms,
    Tool,
    Verdict,
    check_camera_matrix,
    check_covariance,
    check_distortion,
    check_light_plane,
    check_printable,
    matrix,
    numbers,
)
from .files import (
    FileFormatError,
    FloatArray,
    check_schema_version,
    read_yaml,
    rotation_matrix,
    validate,
    vector3,
    write_atomic,
)
from .opencv_yaml import emit

__all__ = ["PARAMETERS", "REFINED_KEYS", "Calibration", "Rms", "read_camera"]

SCHEMA_VERSIONS = (1, 2)

PARAMETERS = (
    *("fx", "fy", "cx", "cy", "skew", "k1", "k2", "p1", "p2", "k3"),
    *("rx", "ry", "rz", "tx", "ty", "tz", "nx", "ny", "nz", "d"),
)
"""Names of the covariance's rows; rx, ry, rz is the rotation error vector in the gripper frame (rad)."""

REFINED_KEYS = ("degrees_of_freedom", "intervals_95", "noise_levels", "lens", "verdict", "tool")
"""What a refined result has and one of version 1 has not."""


class Calibration(Part):
    """Everything a measuring program needs; `save` and `load` keep every number bit for bit.

    Schema version 2 is what `refineHandEye` gives: one joint covariance, intervals, noise levels and a verdict. Version
    1 (method "closed_form") has none of `REFINED_KEYS`; its covariance is block diagonal, each block conditional on
    the ones before it.
    """

    schema_version: Literal[1, 2] = 2
    software_version: str
    dataset_sha256: str = ""
    units: Literal["m"] = "m"
    method: Literal["closed_form", "refined"] = "refined"
    constraints: tuple[str, ...] = ()
    image_width: int = Field(gt=0)
    image_height: int = Field(gt=0)
    camera_matrix: Annotated[FloatArray, BeforeValidator(check_camera_matrix)]
    distortion_coefficients: Annotated[FloatArray, BeforeValidator(check_distortion)]
    R_cam2gripper: Annotated[FloatArray, matrix(rotation_matrix)]
    t_cam2gripper: Annotated[FloatArray, matrix(vector3)]
    light_plane: Annotated[FloatArray | None, BeforeValidator(check_light_plane)] = None
    verdict: Verdict | None = None
    tool: Tool | None = None
    noise_levels: NoiseLevels | None = None
    lens: Lens | None = None
    chi_square: ChiSquare | None = None
    rms: Rms
    views: int = Field(ge=0)
    points: int = Field(ge=0)
    observations: int = Field(ge=0)
    stripe_segments: int = Field(default=0, ge=0)
    parameter_names: tuple[str, ...]
    covariance: Annotated[FloatArray, BeforeValidator(check_covariance)]
    degrees_of_freedom: Annotated[FloatArray | None, matrix(numbers(None))] = None
    intervals_95: Annotated[FloatArray | None, matrix(numbers(None, 2))] = None

    @field_validator("software_version", "dataset_sha256")
    @classmethod
    def _plain_text(cls, text: str) -> str:
        return check_printable(text)

    @model_validator(mode="before")
    @classmethod
    def _version_of_a_closed_form(cls, content: Any) -> Any:
        """A program that gives nothing refined means version 1."""
        if isinstance(content, dict) and "schema_version" not in content and not set(content) & set(REFINED_KEYS):
            return {**content, "schema_version": 1, "method": "closed_form"}
        return content

    @model_validator(mode="after")
    def _keys_of_the_version(self) -> Calibration:
        refined = self.schema_version == 2
        if self.method != ("refined" if refined else "closed_form"):
            raise ValueError(f"method '{self.method}' does not belong to schema_version {self.schema_version}")
        for key in (*REFINED_KEYS, "chi_square"):
            if not refined and getattr(self, key) is not None:
                raise ValueError(f"key '{key}' is unknown in schema_version 1")
            if refined and getattr(self, key) is None and key != "chi_square":
                raise ValueError(f"key '{key}' is missing")
        for key in ("points_px",) if refined else ("translations_px", "rotation_px"):
            if getattr(self.rms, key) is None:
                raise ValueError(f"key 'rms.{key}' is missing")
        return self

    @model_validator(mode="after")
    def _names_match(self) -> Calibration:
        count = len(self.parameter_names)
        for key in ("covariance", "degrees_of_freedom", "intervals_95"):
            rows = getattr(self, key)
            if rows is not None and len(rows) != count:
                raise ValueError(
                    f"parameter_names and {key} need the same length, given {count} names, {len(rows)} rows"
                )
        return self

    def standard_deviation(self, name: str) -> float:
        """Square root of the variance of one parameter, in its own unit; KeyError for a name that was not estimated."""
        i = self._row(name)
        return math.sqrt(self.covariance[i, i])

    def interval(self, name: str) -> tuple[float, float] | None:
        """95 % interval of one parameter, in its own unit (rotation: of the error, around 0); None in version 1."""
        i = self._row(name)
        return None if self.intervals_95 is None else (float(self.intervals_95[i, 0]), float(self.intervals_95[i, 1]))

    def _row(self, name: str) -> int:
        if name not in self.parameter_names:
            raise KeyError(f"{name}: is not among the parameters {', '.join(self.parameter_names)}")
        return self.parameter_names.index(name)

    def save(self, path: str | Path) -> None:
        """Writes `calibration.yaml`, atomic and durable."""
        write_atomic(Path(path), self.to_yaml().encode())

    def to_yaml(self) -> str:
        """The text `save` writes."""
        return emit(self)

    @classmethod
    def load(cls, path: str | Path) -> Calibration:
        """Reads what `save` wrote; `FileFormatError` names the key of whatever is unknown, missing or wrong."""
        file = Path(path)
        content = read_yaml(file, "calibration")
        check_schema_version(file, content, "calibration", *SCHEMA_VERSIONS)
        return validate(cls, content, file)


def read_camera(path: str | Path) -> tuple[FloatArray, FloatArray]:
    """Camera matrix (3, 3) and distortion (n,) of a file `cv::FileStorage` reads, ours or by OpenCV's tools."""
    if not Path(path).is_file():
        raise FileFormatError(f"{path}: there is no such file")
    try:
        storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
        K: Any = storage.getNode("camera_matrix").mat()
        D: Any = storage.getNode("distortion_coefficients").mat()
    except cv2.error as error:
        raise FileFormatError(f"{path}: cv::FileStorage cannot read it: {error}") from error
    if K is None:
        raise FileFormatError(f"{path}: key 'camera_matrix' is missing")
    try:
        return check_camera_matrix(K), check_distortion(np.zeros(5) if D is None else D)
    except ValueError as error:
        raise FileFormatError(f"{path}: {error}") from error
