# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The result of a calibration and its file `calibration.yaml`, which `cv::FileStorage` and PyYAML both read.

Lengths are metres, angles radians. `R_cam2gripper`, `t_cam2gripper` map a point in the camera frame into the gripper
frame; the light plane is (nx, ny, nz, d) in the camera frame with n.X = d, |n| = 1, d > 0. Every key: doc/files.md.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import cv2
import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, field_validator, model_validator

from .files import (
    FileFormatError,
    FloatArray,
    check_schema_version,
    finite_array,
    read_yaml,
    rotation_matrix,
    validate,
    vector3,
    write_atomic,
)

SCHEMA_VERSION = 1
HEADER = "%YAML 1.2\n---\n"

CAMERA_PARAMETERS = ("fx", "fy", "cx", "cy", "skew", "rx", "ry", "rz")
TRANSLATION_PARAMETERS = ("tx", "ty", "tz")
LIGHT_PLANE_PARAMETERS = ("nx", "ny", "nz", "d")
"""Names of the covariance's rows; rx, ry, rz is the rotation error vector in the gripper frame (rad)."""


def _unpack(value: Any) -> Any:
    """An OpenCV matrix map (rows, cols, dt, data) as nested lists; anything else unchanged."""
    if not isinstance(value, Mapping):
        return value
    unknown = set(value) - {"rows", "cols", "dt", "data"}
    missing = {"rows", "cols", "dt", "data"} - set(value)
    if unknown or missing or value["dt"] != "d":
        given = ", ".join(map(str, value))
        raise ValueError(f"needs a matrix map with rows, cols, dt: d and data, given the keys {given}")
    rows, cols, data = value["rows"], value["cols"], value["data"]
    if len(data) != rows * cols:
        raise ValueError(f"needs {rows} x {cols} = {rows * cols} numbers in data, given {len(data)}")
    return np.array(data, dtype=np.float64).reshape(rows, cols)


def check_camera_matrix(value: Any) -> FloatArray:
    """`value` (3, 3, or an OpenCV matrix map) as a read-only camera matrix; ValueError says what it lacks."""
    K = finite_array(_unpack(value), (3, 3))
    if K[2].tolist() != [0, 0, 1] or K[1, 0] != 0 or K[0, 0] <= 0 or K[1, 1] <= 0:
        raise ValueError(f"needs [[fx, skew, cx], [0, fy, cy], [0, 0, 1]] with positive fx, fy, given {K.tolist()}")
    return K


def check_distortion(value: Any) -> FloatArray:
    """`value` (or an OpenCV matrix map) as a read-only vector of OpenCV distortion coefficients; else ValueError."""
    coefficients = finite_array(np.asarray(_unpack(value), dtype=np.float64).reshape(-1), (None,))
    if len(coefficients) not in (4, 5, 8, 12, 14):
        raise ValueError(f"needs 4, 5, 8, 12 or 14 numbers (zeros = no distortion), given {len(coefficients)}")
    return coefficients


def _light_plane(value: Any) -> FloatArray | None:
    if value is None:
        return None
    plane = finite_array(np.asarray(_unpack(value), dtype=np.float64).reshape(-1), (4,))
    length = float(np.linalg.norm(plane[:3]))
    if abs(length - 1) > 1e-6 or plane[3] <= 0:
        raise ValueError(f"needs (nx, ny, nz, d) with |n| = 1 and d > 0, given |n| = {length:.6g}, d = {plane[3]:.6g}")
    return plane


def _covariance(value: Any) -> FloatArray:
    C = np.array(_unpack(value), dtype=np.float64)
    if C.ndim != 2 or C.shape[0] != C.shape[1] or np.isnan(C).any() or (np.diag(C) < 0).any():
        raise ValueError(f"needs a square matrix without NaN or negative variances, given shape {C.shape}")
    C.flags.writeable = False
    return C


def _from_file(check: Any) -> Any:
    return BeforeValidator(lambda value: check(_unpack(value)))


class Rms(BaseModel):
    """Root mean square residuals in pixels of the stages that ran."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    translations_px: float
    rotation_px: float
    light_plane_px: float | None = None


class Calibration(BaseModel):
    """Everything a measuring program needs; `save` and `load` keep every number bit for bit.

    With `method` "closed_form" the covariance is block diagonal: each stage (camera and rotation; translation; light
    plane) is conditional on the stages before it, and terms between stages are not computed.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=True)

    schema_version: Literal[1] = 1
    software_version: str
    dataset_sha256: str = ""
    units: Literal["m"] = "m"
    method: Literal["closed_form"] = "closed_form"
    constraints: tuple[str, ...] = ()
    image_width: int = Field(gt=0)
    image_height: int = Field(gt=0)
    camera_matrix: Annotated[FloatArray, BeforeValidator(check_camera_matrix)]
    distortion_coefficients: Annotated[FloatArray, BeforeValidator(check_distortion)]
    R_cam2gripper: Annotated[FloatArray, _from_file(rotation_matrix)]
    t_cam2gripper: Annotated[FloatArray, _from_file(vector3)]
    light_plane: Annotated[FloatArray | None, BeforeValidator(_light_plane)] = None
    parameter_names: tuple[str, ...]
    covariance: Annotated[FloatArray, BeforeValidator(_covariance)]
    rms: Rms
    views: int = Field(ge=0)
    points: int = Field(ge=0)
    observations: int = Field(ge=0)
    stripe_segments: int = Field(default=0, ge=0)

    @field_validator("software_version", "dataset_sha256")
    @classmethod
    def _plain_text(cls, text: str) -> str:
        if not text.isprintable():
            raise ValueError(f"needs printable text, given {text!r}")
        return text

    @model_validator(mode="after")
    def _names_match(self) -> Calibration:
        if len(self.parameter_names) != len(self.covariance):
            given = f"{len(self.parameter_names)} names, {len(self.covariance)} rows"
            raise ValueError(f"parameter_names and covariance need the same length, given {given}")
        return self

    def standard_deviation(self, name: str) -> float:
        """Square root of the variance of one parameter, in its own unit; KeyError for a name that was not estimated."""
        if name not in self.parameter_names:
            raise KeyError(f"{name}: is not among the parameters {', '.join(self.parameter_names)}")
        i = self.parameter_names.index(name)
        return math.sqrt(self.covariance[i, i])

    def save(self, path: str | Path) -> None:
        """Writes `calibration.yaml`, atomic and durable."""
        write_atomic(Path(path), self.to_yaml().encode())

    def to_yaml(self) -> str:
        """The text `save` writes."""
        return HEADER + "".join(_emit(key, getattr(self, key)) for key in type(self).model_fields)

    @classmethod
    def load(cls, path: str | Path) -> Calibration:
        """Reads what `save` wrote; `FileFormatError` names the key of whatever is unknown, missing or wrong."""
        file = Path(path)
        content = read_yaml(file, "calibration")
        check_schema_version(file, content, "calibration", SCHEMA_VERSION)
        return validate(cls, content, file)


def _emit(key: str, value: Any) -> str:
    """One key of the file, in the subset of YAML that cv::FileStorage parses; a missing value leaves the key out."""
    if value is None:
        return ""
    if isinstance(value, np.ndarray):
        matrix = value.reshape(len(value), -1)
        lines = [", ".join(_number(float(x)) for x in line) for line in (matrix.T if matrix.shape[1] == 1 else matrix)]
        rows = ",\n           ".join(lines)
        return f"{key}:\n   rows: {matrix.shape[0]}\n   cols: {matrix.shape[1]}\n   dt: d\n   data: [ {rows} ]\n"
    if isinstance(value, BaseModel):
        inner = {name: getattr(value, name) for name in type(value).model_fields}
        return f"{key}:\n" + "".join("   " + _emit(name, item) for name, item in inner.items() if item is not None)
    if isinstance(value, tuple):
        return f"{key}: [ {', '.join(json.dumps(str(item)) for item in value)} ]\n"
    if isinstance(value, float):
        return f"{key}: {_number(value)}\n"
    return f"{key}: {value if isinstance(value, int) else json.dumps(value, ensure_ascii=False)}\n"


def _number(x: float) -> str:
    """Shortest text that reads back as the same double; YAML 1.1 takes 1e-05 for a string, 1.0e-05 for a number."""
    if math.isinf(x):
        return ".Inf" if x > 0 else "-.Inf"
    text = repr(x)
    mantissa, _, exponent = text.partition("e")
    return text if not exponent or "." in mantissa else f"{mantissa}.0e{exponent}"


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
