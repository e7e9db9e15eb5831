# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Opens what a station file names, and leaves it safe: laser off, arm stopped, tool restored."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from ..cameras.base import Camera
from ..cameras.laser_switch import Ask, laser_switch
from ..cameras.registry import open_camera
from ..cameras.simulated import SimulatedCamera, SimulatedCameraConfig
from ..robots.base import Robot
from ..robots.guard import Event, GuardedRobot
from ..robots.registry import open_robot
from ..robots.simulated import SimulatedRobot
from ..robots.workspace import Workspace
from ..station import StationConfig
from .capture import Station
from .reporter import Reporter


@contextmanager
def open_station(
    config: StationConfig, workspace: Workspace, *, live: bool, event: Event, ask: Ask, reporter: Reporter
) -> Iterator[Station]:
    """A station whose robot keeps to `workspace`, and moves only with `live`.

    event: hears of moves and stops; ask: see `LaserSwitch`. Raises RobotUnavailableError or CameraError.
    """
    progress = reporter.step("connecting to robot and camera")
    with open_robot(config.robot, live=live) as robot, GuardedRobot(robot, workspace, config.speed, event) as guard:
        progress(1, 2)
        with _camera(config, robot) as camera, laser_switch(config.laser, camera, robot, ask) as laser:
            progress(2, 2)
            yield Station(guard, camera, laser, config.stripe)


def _camera(config: StationConfig, robot: Robot) -> Camera:
    """The simulated camera of a simulated robot looks at its arm; every other camera is on its own."""
    if isinstance(config.camera, SimulatedCameraConfig) and isinstance(robot, SimulatedRobot):
        from ..simulation import SimulatedCell

        return SimulatedCamera(SimulatedCell(robot.arm.cell), robot.arm.state, laser_pin=config.camera.laser_pin)
    return open_camera(config.camera)
