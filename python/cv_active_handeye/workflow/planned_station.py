# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What to plan with at a station: its own settings, or those of the simulated cell's drawing."""

from __future__ import annotations

from typing import Any

from ..cameras.simulated import SimulatedCameraConfig
from ..files import FileFormatError, FloatArray
from ..robots.base import Robot
from ..robots.simulated import SimulatedRobot
from ..station import StationConfig
from .plan_settings import PlanSettings

DEFAULT_STOPS = 24


def planning_of(config: StationConfig, robot: Robot, said: dict[str, Any]) -> PlanSettings:
    """The settings of `plan` at a station; `said` (stops, target_sigma_mm) comes on top.

    FileFormatError where a real camera's mounting and optics are not in the station file.
    """
    if config.planning is not None:
        return PlanSettings.model_validate({**config.planning.model_dump(), "speed": config.speed, **said})
    if not isinstance(config.camera, SimulatedCameraConfig):
        raise FileFormatError(
            "station: key 'planning' is missing: it says how the camera is mounted, how far away the scene is, and "
            "where the arm may be"
        )
    asked = said if any(value is not None for value in said.values()) else {"stops": DEFAULT_STOPS}
    return PlanSettings.model_validate({**_drawing(config.camera, robot), "speed": config.speed, **asked})


def _drawing(camera: SimulatedCameraConfig, robot: Robot) -> dict[str, Any]:
    from ..simulation import nominal_planning
    from ..simulation.emulators import EmulatorLink

    pose: FloatArray = robot.pose().T_gripper2base
    if isinstance(robot, SimulatedRobot):
        return nominal_planning(robot.arm.cell, pose)
    with EmulatorLink(camera.host, camera.port, camera.timeout_s) as link:
        return nominal_planning(link.cell(), pose)
