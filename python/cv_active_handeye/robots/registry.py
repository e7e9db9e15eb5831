# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""All kinds of robots by their `type`."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from . import denso, recorded, simulated, ur
from .base import Robot
from .denso_config import DensoConfig
from .recorded import RecordedConfig
from .simulated import SimulatedRobotConfig
from .ur import UrConfig

RobotConfig = Annotated[UrConfig | DensoConfig | SimulatedRobotConfig | RecordedConfig, Field(discriminator="type")]


def open_robot(config: RobotConfig, *, live: bool) -> Robot:
    """Connects to the robot of a configuration; RobotUnavailableError. Vendor libraries load only now.

    live: whether it may be moved. Without it there is no connection that could move it.
    """
    if isinstance(config, UrConfig):
        return ur.connect(config, live=live)
    if isinstance(config, DensoConfig):
        return denso.connect(config, live=live)
    if isinstance(config, RecordedConfig):
        return recorded.connect(config, live=live)
    return simulated.connect(config, live=live)
