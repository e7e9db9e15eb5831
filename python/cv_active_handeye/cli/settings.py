# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What the arguments mean for the workflow; what it refuses of them is wrong usage."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from pydantic import ValidationError

from ..calibration import read_camera
from ..config import CalibrationOptions
from ..files import read_yaml, validate
from ..workflow import BoardSpec

if TYPE_CHECKING:
    from ..simulation import CellConfig


def cell_config(**settings: object) -> CellConfig:
    """The simulated cell, of which the extra `sim` is needed only now."""
    from ..simulation import CellConfig

    try:
        return CellConfig.model_validate(settings)
    except ValidationError as error:
        hints = [f"--{str(item['loc'][0]).replace('_', '-')}" for item in error.errors()]
        raise typer.BadParameter("; ".join(item["msg"] for item in error.errors()), param_hint=hints) from error


def board_spec(text: str) -> BoardSpec:
    """The board that --board names."""
    try:
        return BoardSpec.parse(text)
    except ValueError as error:
        raise typer.BadParameter(str(error), param_hint="--board") from error


def calibration_options(
    config: Path | None, camera: Path | None, distortion: Path | None, given: dict[str, Any]
) -> CalibrationOptions:
    """Settings from the file, then what the command line says on top (None = nothing)."""
    said: dict[str, Any] = {key: value for key, value in given.items() if value is not None}
    if camera is not None:
        said["camera_matrix"], said["distortion_coefficients"] = read_camera(camera)
    elif distortion is not None:
        said["distortion_coefficients"] = read_camera(distortion)[1]
    if config is not None:
        return validate(CalibrationOptions, read_yaml(config, "settings") | said, config)
    try:
        return CalibrationOptions.model_validate(said)
    except ValidationError as error:
        texts = [item["msg"].removeprefix("Value error, ") for item in error.errors()]
        raise typer.BadParameter("; ".join(texts)) from error
