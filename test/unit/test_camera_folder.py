# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A folder of images as a camera, and what all cameras share."""

from __future__ import annotations

import threading
import time
from pathlib import Path

import cv2
import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError
from support.camera_emulation import picture

from cv_active_handeye.cameras import folder
from cv_active_handeye.cameras.base import Camera, CameraError
from cv_active_handeye.cameras.basler import BaslerCameraConfig
from cv_active_handeye.cameras.common import vendor_module, within
from cv_active_handeye.cameras.folder import FolderCameraConfig
from cv_active_handeye.cameras.registry import CameraConfig, open_camera


@pytest.mark.parametrize(("dtype", "channels", "format_"), [(np.uint8, 3, "bgr8"), (np.uint16, 1, "mono16")])
def test_images_come_in_the_order_of_their_names_then_it_ends(
    tmp_path: Path, dtype: type, channels: int, format_: str
) -> None:
    for name, seed in (("b.png", 2), ("a.png", 1), ("c.tif", 3)):
        cv2.imwrite(str(tmp_path / name), picture(seed, dtype, channels))
    (tmp_path / "notes.txt").write_text("no image")
    with open_camera(FolderCameraConfig(folder=tmp_path)) as camera:
        assert isinstance(camera, Camera)
        assert camera.info.pixel_format == format_
        for seed in (1, 2, 3):
            np.testing.assert_array_equal(camera.grab().image, picture(seed, dtype, channels))
        with pytest.raises(CameraError, match=r"all 3 images have been shown; add images or open it anew"):
            camera.grab()


def test_image_of_another_size_or_format_is_refused(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "a.png"), picture(1))
    cv2.imwrite(str(tmp_path / "b.png"), picture(2)[:, :32])
    (tmp_path / "c.png").write_bytes(b"no image")
    with folder.connect(FolderCameraConfig(folder=tmp_path)) as camera:
        camera.grab()
        with pytest.raises(CameraError, match=r"gave a frame of 32 x 48 mono8 instead of 64 x 48 mono8"):
            camera.grab()
        with pytest.raises(CameraError, match=r"c\.png is not an image OpenCV can read; remove or replace it"):
            camera.grab()


def test_empty_and_missing_folders_are_told(tmp_path: Path) -> None:
    with pytest.raises(CameraError, match=r"has no image; needed: files that end with \.png"):
        folder.connect(FolderCameraConfig(folder=tmp_path))
    with pytest.raises(CameraError, match=r"nowhere: cannot be listed: No such file"):
        folder.connect(FolderCameraConfig(folder=tmp_path / "nowhere"))


def test_camera_without_line_refuses_to_switch_one(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "a.png"), picture(1))
    with (
        folder.connect(FolderCameraConfig(folder=tmp_path)) as camera,
        pytest.raises(CameraError, match=r"has no output line to switch on; choose another laser switch"),
    ):
        camera.set_line(True)


def test_configuration_is_chosen_by_its_type() -> None:
    adapter: TypeAdapter[CameraConfig] = TypeAdapter(CameraConfig)
    assert adapter.validate_python({"type": "basler", "serial": "1"}) == BaslerCameraConfig(serial="1")
    with pytest.raises(ValidationError, match="Input tag 'webcam' found using 'type' does not match"):
        adapter.validate_python({"type": "webcam"})
    for content in ({"type": "basler", "serail": "1"}, {"type": "folder", "folder": ".", "retries": 1}):
        with pytest.raises(ValidationError, match="Extra inputs are not permitted"):
            adapter.validate_python(content)


def test_missing_vendor_library_is_told_with_its_extra() -> None:
    with pytest.raises(CameraError, match=r"no_such_sdk: cannot .*pip install 'cv_active_handeye\[basler\]'"):
        vendor_module("no_such_sdk", "basler")


def test_device_that_opens_too_late_is_told_and_released() -> None:
    released = threading.Event()

    def slowly() -> str:
        time.sleep(0.3)
        return "device"

    began = time.monotonic()
    with pytest.raises(CameraError, match=r"slow camera: did not open within 0\.1 s\. Check power, cable and address"):
        within(0.1, slowly, "slow camera", lambda _: released.set())
    assert time.monotonic() - began < 0.25
    assert released.wait(2)


def test_device_that_fails_to_open_is_told_at_once() -> None:
    def fails() -> str:
        raise OSError("bus error")

    with pytest.raises(CameraError, match=r"bad camera: cannot be opened: bus error\. Check that no other program"):
        within(5.0, fails, "bad camera", lambda _: None)
