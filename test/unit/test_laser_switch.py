# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The laser switch: who switches, and that the laser is off afterwards in every way of leaving."""

from __future__ import annotations

import time
from typing import Any

import pytest
from pydantic import TypeAdapter

from cv_active_handeye.cameras.laser_switch import (
    CameraLineConfig,
    LaserError,
    LaserSwitchConfig,
    NoLaserConfig,
    OperatorConfig,
    RobotOutputConfig,
    SettlingSwitch,
    laser_switch,
)
from cv_active_handeye.dataset_format import CameraInfo


class Station:
    """A camera with a line and a robot with outputs, as far as a laser switch sees them."""

    def __init__(self, moving_polls: int = 0, broken: tuple[str, ...] = ()) -> None:
        self.switched: list[tuple[str, bool]] = []
        self.info = CameraInfo(width=64, height=48, name="camera 7")
        self.name = "robot 5"
        self._moving_polls, self.broken = moving_polls, broken

    def set_line(self, on: bool) -> None:
        self._switch("line", on)

    def set_output(self, pin: int, on: bool) -> None:
        self._switch(f"output {pin}", on)

    def ask(self, sentence: str) -> None:
        self._switch(sentence, "ON" in sentence)

    def is_steady(self) -> bool:
        self._moving_polls -= 1
        return self._moving_polls < 0

    def _switch(self, name: str, on: bool) -> None:
        if ("on" if on else "off") in self.broken:
            raise OSError("no contact.")
        self.switched.append((name, on))

    def switch(self, config: LaserSwitchConfig) -> Any:
        parts: Any = self
        return laser_switch(config, camera=parts, robot=parts, ask=self.ask)


@pytest.mark.parametrize(
    ("config", "names"),
    [
        (CameraLineConfig(settle_s=0), ("line", "line")),
        (RobotOutputConfig(pin=3, settle_s=0), ("output 3", "output 3")),
        (
            OperatorConfig(settle_s=0),
            (
                "Switch the laser OFF, then press Enter.",
                "Switch the laser ON, keep out of its light, then press Enter.",
            ),
        ),
    ],
)
def test_switch_is_off_on_entering_switches_only_changes_and_leaves_off(
    config: LaserSwitchConfig, names: tuple[str, str]
) -> None:
    station = Station()
    with station.switch(config) as laser:
        assert laser.present
        assert station.switched == [(names[0], False)]
        laser.switch(True)
        laser.switch(True)
    assert station.switched == [(names[0], False), (names[1], True), (names[0], False)]


@pytest.mark.parametrize("leaving", [RuntimeError, KeyboardInterrupt, SystemExit])
def test_laser_is_off_after_every_way_of_leaving(leaving: type[BaseException]) -> None:
    station = Station()

    def capture() -> None:
        with station.switch(CameraLineConfig(settle_s=0)) as laser:
            laser.switch(True)
            raise leaving

    with pytest.raises(leaving):
        capture()
    assert station.switched[-1] == ("line", False)


def test_interrupt_while_it_switches_off_does_not_leave_it_on() -> None:
    """The person presses Ctrl-C again while the first one is being dealt with."""
    states: list[bool] = []
    interrupts = [KeyboardInterrupt()]

    def action(on: bool) -> None:
        if not on and states and interrupts:
            raise interrupts.pop()
        states.append(on)

    with pytest.raises(KeyboardInterrupt), SettlingSwitch(action, 0.0, "line") as laser:
        laser.switch(True)
    assert states == [False, True, False]


def test_interrupt_between_switching_and_knowing_it_is_switched_off_too() -> None:
    states: list[bool] = []

    def action(on: bool) -> None:
        states.append(on)
        if on:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), SettlingSwitch(action, 0.0, "line") as laser:
        laser.switch(True)
    assert states == [False, True, False]


def test_switch_waits_for_light_and_robot() -> None:
    station = Station(moving_polls=5)
    with station.switch(RobotOutputConfig(pin=1, settle_s=0.05)) as laser:
        began = time.monotonic()
        laser.switch(True)
        assert 0.05 <= time.monotonic() - began < 1.0
    station = Station(moving_polls=10**9)
    with pytest.raises(LaserError, match=r"output 1 of robot 5.*did not come to rest within 0\.1 s\. It may be on"):
        station.switch(RobotOutputConfig(pin=1, steady_timeout_s=0.1)).switch(True)


def test_failure_is_told_with_what_it_means_for_the_eyes() -> None:
    laser = Station(broken=("on",)).switch(CameraLineConfig(settle_s=0))
    with (
        laser,
        pytest.raises(LaserError, match=r"line of camera 7.* could not be switched on: no contact\. It may be on"),
    ):
        laser.switch(True)


def test_failure_to_switch_off_is_told_beside_the_error_that_led_there() -> None:
    station = Station()

    def capture() -> None:
        with station.switch(CameraLineConfig(settle_s=0)) as laser:
            laser.switch(True)
            station.broken = ("off",)
            raise ValueError("the first error")

    with pytest.raises(LaserError, match="could not be switched off") as told:
        capture()
    assert any("the first error" in str(link) for link in chain(told.value))


def chain(error: BaseException | None) -> list[BaseException]:
    links: list[BaseException] = []
    while error is not None:
        links.append(error)
        error = error.__cause__ or error.__context__
    return links


def test_station_without_laser_refuses_to_switch_it_on() -> None:
    with Station().switch(NoLaserConfig()) as laser:
        assert not laser.present
        laser.switch(False)
        with pytest.raises(LaserError, match=r"there is none in this station"):
            laser.switch(True)


def test_configuration_is_chosen_by_its_type() -> None:
    adapter: TypeAdapter[LaserSwitchConfig] = TypeAdapter(LaserSwitchConfig)
    assert adapter.validate_python({"type": "robot_output", "pin": 2}) == RobotOutputConfig(pin=2)
