# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Basler cameras, against the emulator inside of pylon, unmodified."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.camera_emulation import HEIGHT, WIDTH, basler_config, picture, show

from cv_active_handeye.cameras import basler
from cv_active_handeye.cameras.base import Camera, CameraError
from cv_active_handeye.cameras.common import vendor_module

pytestmark = pytest.mark.timeout(60)


def features(camera: Camera) -> Any:
    """The camera's own node map, to look behind the settings."""
    assert isinstance(camera, basler.BaslerCamera)
    return camera._device.GetNodeMap()


def test_grab_gives_the_image_of_now_bit_by_bit(tmp_path: Path) -> None:
    show(tmp_path, picture(0))
    with basler.connect(basler_config(tmp_path)) as camera:
        assert (camera.info.width, camera.info.height, camera.info.pixel_format) == (WIDTH, HEIGHT, "mono8")
        for seed in range(1, 4):
            show(tmp_path, picture(seed))
            before = time.monotonic()
            frame = camera.grab()
            np.testing.assert_array_equal(frame.image, picture(seed))
            assert before <= frame.requested <= frame.received <= time.monotonic()
            assert frame.camera_time is None  # the emulator has no clock


@pytest.mark.parametrize(("pixels", "bits"), [("mono10", 10), ("mono12", 12), ("mono16", 16)])
def test_more_than_8_bits_arrive_as_16_with_equal_full_scale(tmp_path: Path, pixels: str, bits: int) -> None:
    show(tmp_path, picture(5, np.uint16))
    with basler.connect(basler_config(tmp_path, pixel_format=pixels)) as camera:
        image = camera.grab().image
    assert camera.info.pixel_format == "mono16"
    np.testing.assert_array_equal(image, picture(5, np.uint16) >> (16 - bits) << (16 - bits))


def test_colour_keeps_the_order_blue_green_red(tmp_path: Path) -> None:
    show(tmp_path, picture(6, channels=3))
    with basler.connect(basler_config(tmp_path, pixel_format="bgr8")) as camera:
        np.testing.assert_array_equal(camera.grab().image, picture(6, channels=3))
    assert camera.info.pixel_format == "bgr8"


def test_settings_reach_the_camera(tmp_path: Path) -> None:
    show(tmp_path, picture(0))
    config = basler_config(tmp_path, exposure_us=2500.0, gain_db=6.0, line="Line2", user_output="UserOutput3")
    with basler.connect(config) as camera:
        nodes = features(camera)
        nodes.GetNode("LineSelector").SetValue("Line2")
        given = {name: nodes.GetNode(name).GetValue() for name in ("ExposureTime", "Gain", "LineMode", "LineSource")}
        assert given["ExposureTime"] == pytest.approx(2500)
        assert given["Gain"] == pytest.approx(6, rel=0.01)
        assert (given["LineMode"], given["LineSource"]) == ("Output", "UserOutput3")


def test_set_line_switches_the_output_which_is_off_before_and_after(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    show(tmp_path, picture(0))
    written: list[tuple[str, object]] = []
    write = basler._PylonFeatures.set

    def recorded(self: basler._PylonFeatures, name: str, value: bool | int | float | str) -> None:
        write(self, name, value)
        written.append((name, value))

    monkeypatch.setattr(basler._PylonFeatures, "set", recorded)
    camera = basler.connect(basler_config(tmp_path, line="Line2"))
    outputs = [(name, value) for name, value in written if name in ("UserOutputValue", "LineSource")]
    assert outputs == [("UserOutputValue", False), ("LineSource", "UserOutput1")]
    camera.set_line(True)
    assert features(camera).GetNode("UserOutputValue").GetValue() is True
    camera.close()
    assert written[-1] == ("UserOutputValue", False)


def test_set_line_without_a_line_in_the_settings_is_refused(tmp_path: Path) -> None:
    show(tmp_path, picture(0))
    with basler.connect(basler_config(tmp_path)) as camera, pytest.raises(CameraError, match=r"has no output line"):
        camera.set_line(True)


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        ({"serial": "12345678"}, r"basler 12345678: is not found; cameras found: 0815-0000, 0815-0001\."),
        ({"width": 100000}, r"Width cannot be set to 100000: "),
        ({"exposure_us": 1e9}, r"ExposureTime cannot be set to 1000000000\.0: "),
        ({"features": {"Warp": 3}}, r"has no feature Warp; "),
        ({"line": "Line9"}, r"LineSelector cannot be set to 'Line9': "),
    ],
)
def test_settings_the_camera_refuses_are_told(tmp_path: Path, settings: dict[str, object], told: str) -> None:
    with pytest.raises(CameraError, match=told):
        basler.connect(basler_config(tmp_path, **settings))


def test_serial_number_chooses_the_camera(tmp_path: Path) -> None:
    show(tmp_path, picture(0))
    with basler.connect(basler_config(tmp_path, serial="0815-0001")) as camera:
        assert camera.info.name == "basler Emulation 0815-0001"


def test_damaged_frames_are_taken_again_and_told_when_there_are_too_many(tmp_path: Path) -> None:
    show(tmp_path, picture(3))
    with basler.connect(basler_config(tmp_path, retries=2)) as camera:
        nodes = features(camera)
        nodes.GetNode("ForceFailedBufferCount").SetValue(2)
        nodes.GetNode("ForceFailedBuffer").Execute()
        np.testing.assert_array_equal(camera.grab().image, picture(3))
        nodes.GetNode("ForceFailedBufferCount").SetValue(3)
        nodes.GetNode("ForceFailedBuffer").Execute()
        with pytest.raises(CameraError, match=r"0815-0000: no usable frame in 3 tries: .*incompletely grabbed"):
            camera.grab()
        np.testing.assert_array_equal(camera.grab().image, picture(3))


def test_missing_frames_end_after_the_stated_time(tmp_path: Path) -> None:
    show(tmp_path, picture(3))
    with basler.connect(basler_config(tmp_path, retries=1, timeout_s=0.2, trigger="none")) as camera:
        camera.grab()
        features(camera).GetNode("TriggerMode").SetValue("On")  # nobody triggers
        began = time.monotonic()
        with pytest.raises(CameraError, match=r"no usable frame in 2 tries: no frame within 0\.2 s\."):
            camera.grab()
        assert 0.35 < time.monotonic() - began < 1.5


class Unplugged:
    """A camera that is pulled out after it was triggered, around a real one."""

    def __init__(self, device: Any, error: type[Exception]) -> None:
        self._device, self._error = device, error

    def __getattr__(self, name: str) -> Any:
        return getattr(self._device, name)

    def RetrieveResult(self, *_: object) -> None:
        raise self._error("the device is not connected")

    def StopGrabbing(self) -> None:
        self._device.StopGrabbing()
        raise self._error("the device is not connected")

    def IsCameraDeviceRemoved(self) -> bool:
        return True


def test_camera_that_is_pulled_out_is_told(tmp_path: Path) -> None:
    pylon = vendor_module("pypylon.pylon", "basler")
    show(tmp_path, picture(3))
    with basler.connect(basler_config(tmp_path)) as camera:
        assert isinstance(camera, basler.BaslerCamera)
        camera._device = Unplugged(camera._device, pylon.RuntimeException)
        with pytest.raises(CameraError, match=r"was unplugged or lost its power; connect it and open it anew"):
            camera.grab()


def test_frame_of_another_size_is_refused(tmp_path: Path) -> None:
    show(tmp_path, picture(3)[: HEIGHT // 2].astype(np.uint8))
    with (
        basler.connect(basler_config(tmp_path)) as camera,
        pytest.raises(CameraError, match=r"gave a frame of 64 x 24 mono8 instead of 64 x 48 mono8"),
    ):
        camera.grab()


def test_image_that_cannot_be_read_is_told(tmp_path: Path) -> None:
    with (
        basler.connect(basler_config(tmp_path, retries=0)) as camera,
        pytest.raises(CameraError, match=r"no usable frame in 1 tries: Failed to load image file"),
    ):
        camera.grab()


def test_camera_opens_again_after_it_was_closed(tmp_path: Path) -> None:
    show(tmp_path, picture(1))
    for _ in range(3):
        with basler.connect(basler_config(tmp_path)) as camera:
            camera.grab()
        camera.close()  # again, harmless
