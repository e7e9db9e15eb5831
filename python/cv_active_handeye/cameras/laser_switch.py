# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Who switches the line laser, and that it is off afterwards, whatever happens."""

from __future__ import annotations

import time
from collections.abc import Callable
from types import TracebackType
from typing import Annotated, Literal, Protocol

from pydantic import BaseModel, ConfigDict, Field

from ..robots.base import Robot
from .base import Camera

Ask = Callable[[str], None]
"""Shows a sentence to the person beside the robot and returns when it has been answered (Enter)."""


class LaserError(RuntimeError):
    """The laser could not be switched as asked; the text says whether it may be on."""


class _SwitchConfig(BaseModel):
    """settle_s: from switching to the next exposure, for the laser's own electronics."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    settle_s: float = Field(default=0.1, ge=0, le=10, allow_inf_nan=False)


class CameraLineConfig(_SwitchConfig):
    """By the camera's output line (its own settings say which)."""

    type: Literal["camera_line"] = "camera_line"


class RobotOutputConfig(_SwitchConfig):
    """By a digital output of the robot. steady_timeout_s: how long the robot may take to say that it stands still."""

    type: Literal["robot_output"] = "robot_output"
    pin: int = Field(ge=0)
    steady_timeout_s: float = Field(default=10.0, gt=0, le=120, allow_inf_nan=False)


class OperatorConfig(_SwitchConfig):
    """By the person beside the robot, who is asked."""

    type: Literal["operator"] = "operator"


class NoLaserConfig(BaseModel):
    """There is no laser."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    type: Literal["none"] = "none"


LaserSwitchConfig = Annotated[
    CameraLineConfig | RobotOutputConfig | OperatorConfig | NoLaserConfig, Field(discriminator="type")
]


class LaserSwitch(Protocol):
    """Use as a context manager: the laser is off when it is entered, and switched off in every way of leaving."""

    present: bool
    """Whether there is a laser."""

    def switch(self, on: bool) -> None:
        """Switches and waits until the light has settled; LaserError where that is not known to have worked."""
        ...

    def __enter__(self) -> LaserSwitch: ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None: ...


def laser_switch(config: LaserSwitchConfig, camera: Camera, robot: Robot, ask: Ask) -> LaserSwitch:
    """The switch of a configuration; `ask` is only used by "operator"."""
    if isinstance(config, CameraLineConfig):
        return SettlingSwitch(camera.set_line, config.settle_s, f"line of {camera.info.name}")
    if isinstance(config, RobotOutputConfig):
        return SettlingSwitch(_robot_output(robot, config), config.settle_s, f"output {config.pin} of {robot.name}")
    if isinstance(config, OperatorConfig):
        return SettlingSwitch(lambda on: ask(_request(on)), config.settle_s, "operator")
    return NoLaser()


class SettlingSwitch:
    """A laser behind one function, with a pause after it."""

    present = True

    def __init__(self, action: Callable[[bool], None], settle_s: float, name: str) -> None:
        """action: switches, or raises; name: of what switches, for messages."""
        self._action, self._settle_s, self._name = action, settle_s, name
        self._on: bool | None = None

    def switch(self, on: bool) -> None:
        """Switches only where the state changes or is not known; LaserError from whatever went wrong."""
        if self._on is on:
            return
        self._on = None
        try:
            self._action(on)
        except Exception as error:
            wish = "on" if on else "off"
            raise LaserError(
                f"laser ({self._name}): could not be switched {wish}: {error} It may be on: do not look into it; "
                "switch it off by hand."
            ) from error
        self._on = on
        time.sleep(self._settle_s)

    def __enter__(self) -> SettlingSwitch:
        self.switch(False)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Switches off, again where a Ctrl-C comes in between; a failure is told, beside the error that led here."""
        try:
            self._leave()
        except KeyboardInterrupt:
            self._leave()
            raise

    def _leave(self) -> None:
        if self._on is not False:
            self._on = None
            self.switch(False)


class NoLaser:
    """No laser: off is what it is, on is refused."""

    present = False

    def switch(self, on: bool) -> None:
        """LaserError for on."""
        if on:
            raise LaserError("laser: there is none in this station (type: none); name its switch in the settings")

    def __enter__(self) -> NoLaser:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Nothing to do."""


def _robot_output(robot: Robot, config: RobotOutputConfig) -> Callable[[bool], None]:
    """Some outputs also move something (a valve, a brake), so the robot has to say that it stands still again."""

    def action(on: bool) -> None:
        robot.set_output(config.pin, on)
        deadline = time.monotonic() + config.steady_timeout_s
        while not robot.is_steady():
            if time.monotonic() > deadline:
                raise LaserError(f"the robot did not come to rest within {config.steady_timeout_s:g} s.")
            time.sleep(0.01)

    return action


def _request(on: bool) -> str:
    if on:
        return "Switch the laser ON, keep out of its light, then press Enter."
    return "Switch the laser OFF, then press Enter."
