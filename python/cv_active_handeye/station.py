# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""`station.yaml`: which robot, camera and laser there are, where the arm may be, and how it is to be planned for.

Every key is described in doc/files.md. Keys that are not listed are refused.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

from .cameras.laser_switch import LaserSwitchConfig, NoLaserConfig
from .cameras.registry import CameraConfig
from .config import CalibrationOptions
from .dataset_format import LaserInfo, Strict
from .files import check_schema_version, read_yaml, validate
from .robots.base import Speed
from .robots.registry import RobotConfig
from .workflow.capture import CaptureSettings
from .workflow.plan_settings import PlanSettings

SCHEMA_VERSION = 1


class StationConfig(Strict):
    """What stands there.

    laser: who switches it; stripe: how it lies in the image. speed, capture: how the arm is moved and when it rests.
    planning: workspace, and what is known of camera and scene beforehand; a simulated camera knows its own.
    calibration: as in `calibrate --config`.
    """

    schema_version: Literal[1] = 1
    robot: RobotConfig
    camera: CameraConfig
    laser: LaserSwitchConfig = NoLaserConfig()
    stripe: LaserInfo = LaserInfo()
    speed: Speed = Speed()
    capture: CaptureSettings = CaptureSettings()
    planning: PlanSettings | None = None
    calibration: CalibrationOptions = CalibrationOptions()


def load_station(path: Path | None, said: dict[str, Any]) -> StationConfig:
    """The station of a file (None = only what is said); `said` comes on top, key by key.

    FileFormatError names every key that is unknown, missing or wrong.
    """
    content: dict[str, Any] = {"schema_version": SCHEMA_VERSION}
    if path is not None:
        content = read_yaml(path, "station")
        check_schema_version(path, content, "station", SCHEMA_VERSION)
    return validate(StationConfig, merged(content, said), path or Path("station"))


def merged(content: dict[str, Any], said: dict[str, Any]) -> dict[str, Any]:
    """`content` with the values of `said`; maps are merged, unless `said` names another `type`."""
    out = dict(content)
    for key, value in said.items():
        old = out.get(key)
        if isinstance(old, dict) and isinstance(value, dict) and value.get("type") in (None, old.get("type")):
            out[key] = merged(old, value)
        else:
            out[key] = value
    return out
