# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""All forms by their name, and what is asked of a calibration before others build on it."""

from __future__ import annotations

import math
from collections.abc import Callable

from ..calibration import Calibration
from . import plain, ros
from .frames import Frames

FORMATS: dict[str, Callable[[Calibration, Frames, str], str]] = {
    "opencv": plain.opencv_yaml,
    "json": plain.plain_json,
    "ros1": ros.ros1_command,
    "ros2": ros.ros2_command,
    "easy-handeye2": ros.easy_handeye2,
    "camera-info": ros.camera_info,
    "urdf": ros.urdf,
}

_CAMERA = ("fx", "fy", "cx", "cy")
_HAND_EYE = ("rx", "ry", "rz", "tx", "ty", "tz")


class NotUsableError(ValueError):
    """A calibration that nobody should build on; the text says why."""


def export(calibration: Calibration, form: str, frames: Frames, *, name: str = "camera", force: bool = False) -> str:
    """The text of `form` (a key of `FORMATS`).

    name: of the camera or the calibration, where the form has a place for one. NotUsableError as `check_usable` says,
    unless `force`; ValueError where the form cannot hold what was calibrated.
    """
    if form not in FORMATS:
        raise ValueError(f"form: needs one of {', '.join(FORMATS)}; given {form!r}")
    if not force:
        check_usable(calibration)
    return FORMATS[form](calibration, frames, name)


def check_usable(calibration: Calibration) -> None:
    """NotUsableError for a closed form, a verdict that says so, or a parameter the data did not determine."""
    if calibration.verdict is None:
        raise NotUsableError("it is a closed form, which nothing has checked against its data; calibrate refines it")
    if not calibration.verdict.usable:
        raise NotUsableError(f"its verdict is: {calibration.verdict.message}")
    names = [name for name in (*_CAMERA, *_HAND_EYE) if name in calibration.parameter_names]
    unknown = [name for name in names if not math.isfinite(calibration.standard_deviation(name))]
    if unknown:
        weak = "; ".join(calibration.verdict.weak_directions)
        raise NotUsableError(f"its data do not determine {', '.join(unknown)}" + (f" ({weak})" if weak else ""))
