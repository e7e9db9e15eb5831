# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The true parameters of a simulated cell: a file of its own, never inside a data set."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import yaml
from pydantic import BaseModel, BeforeValidator, ConfigDict, PlainSerializer

from ..files import (
    FloatArray,
    Rotation,
    Vector3,
    check_schema_version,
    finite_array,
    read_yaml,
    validate,
    write_atomic,
)

_MARKER = "dataset.yaml"


_LISTED = PlainSerializer(lambda array: array.tolist())


def _shape(*shape: int) -> BeforeValidator:
    return BeforeValidator(lambda value: finite_array(value, shape))


class TrueView(BaseModel):
    """The pose the flange really had at one stop, metres."""

    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=True)

    R_gripper2base: Rotation
    t_gripper2base: Vector3


class Truth(BaseModel):
    """What a calibration of the cell should find. camera_matrix (3, 3) px; distortion_coefficients (5,);
    R_cam2gripper (3, 3), t_cam2gripper (3,) m; light_plane (nx, ny, nz, d), n.X = d in the camera frame, m;
    views: the true poses of the recording, in its order."""

    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=True)

    schema_version: Literal[1] = 1
    units: Literal["m"] = "m"
    seed: int
    camera_matrix: Annotated[FloatArray, _shape(3, 3), _LISTED]
    distortion_coefficients: Annotated[FloatArray, _shape(5), _LISTED]
    R_cam2gripper: Rotation
    t_cam2gripper: Vector3
    light_plane: Annotated[FloatArray, _shape(4), _LISTED]
    views: tuple[TrueView, ...] = ()

    def save(self, path: str | Path) -> None:
        """Writes YAML; ValueError if `path` lies in a data set, where a calibration could come across it."""
        target = Path(path).resolve()
        for folder in target.parents:
            if (folder / _MARKER).exists():
                raise ValueError(f"path: the truth must stay outside data sets, but {target} lies in that of {folder}")
        text = yaml.safe_dump(self.model_dump(), sort_keys=False, default_flow_style=None, width=200)
        write_atomic(target, text.encode())

    @classmethod
    def load(cls, path: str | Path) -> Truth:
        """Reads a file of `save`; `FileFormatError` names what cannot be read."""
        content = read_yaml(Path(path), "truth")
        check_schema_version(Path(path), content, "truth", 1)
        return validate(cls, content, Path(path))
