# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The keys of `dataset.yaml`, each explained in doc/files.md."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, field_validator

from .files import Rotation, Vector3

PixelFormat = Literal["mono8", "mono16", "bgr8", "bgr16"]


class Strict(BaseModel):
    """A map of a data set file: keys that are not listed are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=True)


class CameraInfo(Strict):
    """What is known of the camera without calibrating it: image size in pixels, pixel format, a name."""

    width: int = Field(gt=0)
    height: int = Field(gt=0)
    pixel_format: PixelFormat = "mono8"
    name: str = ""


class LaserInfo(Strict):
    """`stripe`: "horizontal" = along the image rows (one point a column), "vertical" = along the columns.

    sigma_px: Gaussian half width of the stripe in the image, px; a stripe of half to twice this width is found.
    """

    stripe: Literal["horizontal", "vertical"] = "horizontal"
    sigma_px: float = Field(default=1.5, ge=0.5, le=20)
    name: str = ""


class View(Strict):
    """One stop of the robot. File names are relative to the data set's folder; `timestamp` is in seconds since 1970."""

    index: int = Field(ge=0)
    R_gripper2base: Rotation
    t_gripper2base: Vector3
    image: str | None = None
    laser_image: str | None = None
    surface_id: int | None = None
    timestamp: float | None = Field(default=None, allow_inf_nan=False)

    @field_validator("image", "laser_image")
    @classmethod
    def _stay_inside(cls, name: str | None) -> str | None:
        return _inside(name)


class Content(Strict):
    """`dataset.yaml` as it stands in the file."""

    schema_version: Literal[1] = 1
    units: Literal["m"] = "m"
    description: str = ""
    camera: CameraInfo
    laser: LaserInfo | None = None
    planned_views: int | None = Field(default=None, ge=0)
    image_points: str | None = None
    board_points: str | None = None
    views: tuple[View, ...] = ()

    @field_validator("views")
    @classmethod
    def _indices_in_order(cls, views: tuple[View, ...]) -> tuple[View, ...]:
        for position, view in enumerate(views):
            if view.index != position:
                raise ValueError(f"needs index {position} at position {position}, given {view.index}")
        return views

    @field_validator("image_points", "board_points")
    @classmethod
    def _stay_inside(cls, name: str | None) -> str | None:
        return _inside(name)


def _inside(name: str | None) -> str | None:
    if name is not None and (Path(name).is_absolute() or ".." in Path(name).parts or not name):
        raise ValueError(f"needs a file name inside the data set's folder, given {name!r}")
    return name
