# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What is asked of a calibration before it is used on another data set."""

from __future__ import annotations

from ..calibration import Calibration
from ..calibration_format import NoiseLevels
from ..dataset import Dataset
from ..files import FileFormatError
from .reporter import Reporter


def noise_levels_for(dataset: Dataset, calibration: Calibration, reporter: Reporter) -> NoiseLevels:
    """The noise levels of a calibration that fits the data set's images; tells of a calibration that was not usable.

    Raises `FileFormatError` for a result of version 1, which has none, and for images of another size.
    """
    if calibration.noise_levels is None:
        raise FileFormatError(
            "calibration: needs covariance and noise levels (schema_version 2), given version 1; calibrate again"
        )
    size = (calibration.image_width, calibration.image_height)
    if size != (dataset.camera.width, dataset.camera.height):
        given = f"{dataset.camera.width} x {dataset.camera.height}"
        raise FileFormatError(f"{dataset.folder}: needs images of {size[0]} x {size[1]} as calibrated, has {given}")
    if calibration.verdict is not None and not calibration.verdict.usable:
        reporter.note(f"the calibration itself was {calibration.verdict.message}")
    return calibration.noise_levels
