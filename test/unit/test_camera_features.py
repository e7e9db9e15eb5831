# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Settings of GenICam cameras, on a node map of our own: what old and new cameras call them, and what they refuse."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from cv_active_handeye.cameras.base import CameraError
from cv_active_handeye.cameras.features import FeatureValue, GenicamConfig, configure


class Nodes:
    """A node map; `rounding` multiplies every float that is written, `deaf` names ignore what is written."""

    def __init__(self, values: dict[str, FeatureValue], rounding: float = 1.0, deaf: Sequence[str] = ()) -> None:
        self.values, self.rounding, self.deaf = dict(values), rounding, deaf
        self.written: list[str] = []

    def has(self, name: str) -> bool:
        return name in self.values

    def get(self, name: str) -> FeatureValue:
        return self.values[name]

    def set(self, name: str, value: FeatureValue) -> None:
        self.written.append(name)
        if name not in self.deaf:
            self.values[name] = value * self.rounding if isinstance(value, float) else value

    def choices(self, name: str) -> Sequence[str]:
        return ("BayerRG8", "Mono8", "Mono12p", "RGB8")


CAMERA: dict[str, FeatureValue] = {
    "Width": 640,
    "Height": 480,
    "PixelFormat": "Mono8",
    "ExposureAuto": "Continuous",
    "GainAuto": "Once",
    "TriggerSelector": "AcquisitionStart",
    "TriggerMode": "Off",
    "TriggerSource": "Line1",
    "Gain": 3.0,
}


def test_automatics_go_off_before_the_values_and_the_trigger_is_ours() -> None:
    nodes = Nodes({**CAMERA, "ExposureTime": 1000.0})
    assert configure(nodes, GenicamConfig(exposure_us=500.0, gain_db=1.0), "camera") == "Mono8"
    assert nodes.values["ExposureTime"] == 500.0
    assert nodes.values["Gain"] == 1.0
    for automatic, value in (("ExposureAuto", "ExposureTime"), ("GainAuto", "Gain")):
        assert nodes.values[automatic] == "Off"
        assert nodes.written.index(automatic) < nodes.written.index(value)
    trigger = [nodes.values[name] for name in ("TriggerSelector", "TriggerMode", "TriggerSource")]
    assert trigger == ["FrameStart", "On", "Software"]


def test_what_is_not_asked_for_stays_and_older_names_are_found() -> None:
    nodes = Nodes({**CAMERA, "ExposureTimeAbs": 1000.0})
    configure(nodes, GenicamConfig(trigger="none"), "camera")
    assert (nodes.values["ExposureAuto"], nodes.values["TriggerMode"]) == ("Continuous", "Off")
    configure(nodes, GenicamConfig(exposure_us=500.0, trigger="none"), "camera")
    assert nodes.values["ExposureTimeAbs"] == 500.0


def test_colour_takes_the_format_that_needs_the_least_work() -> None:
    nodes = Nodes(CAMERA)
    assert configure(nodes, GenicamConfig(pixel_format="bgr8"), "camera") == "RGB8"


def test_rounding_by_the_camera_is_taken_up_to_one_percent() -> None:
    values = {**CAMERA, "ExposureTime": 1000.0}
    configure(Nodes(values, rounding=1.009), GenicamConfig(exposure_us=500.0), "camera")
    with pytest.raises(CameraError, match=r"camera: ExposureTime was set to 500\.0, the camera says 505\."):
        configure(Nodes(values, rounding=1.011), GenicamConfig(exposure_us=500.0), "camera")


@pytest.mark.parametrize(
    ("config", "told"),
    [
        (GenicamConfig(width=320), r"camera: Width was set to 320, the camera says 640"),
        (GenicamConfig(pixel_format="mono12"), r"pixel_format mono12 is not among what it offers: BayerRG8, Mono8, "),
        (GenicamConfig(features={"Speed": 1}), r"camera: has no feature Speed; leave it out of the settings"),
        (GenicamConfig(exposure_us=5.0), r"camera: has no feature ExposureTimeAbs"),
    ],
)
def test_what_the_camera_does_not_do_is_told(config: GenicamConfig, told: str) -> None:
    with pytest.raises(CameraError, match=told):
        configure(Nodes(CAMERA, deaf=("Width",)), config, "camera")


def test_software_trigger_needs_a_camera_with_a_trigger() -> None:
    without = {name: value for name, value in CAMERA.items() if not name.startswith("Trigger")}
    with pytest.raises(CameraError, match=r"camera: has no trigger; choose trigger: none"):
        configure(Nodes(without), GenicamConfig(), "camera")
    configure(Nodes(without), GenicamConfig(trigger="none"), "camera")
