# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""GenICam cameras, against the GenTL test producer that comes with the package genicam: a game with a bouncing ball."""

from __future__ import annotations

import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cv_active_handeye.cameras import genicam
from cv_active_handeye.cameras.base import CameraError
from cv_active_handeye.cameras.common import vendor_module
from cv_active_handeye.cameras.genicam import GenicamCameraConfig

pytestmark = pytest.mark.timeout(60)


@pytest.fixture(scope="module")
def producer() -> Path:
    return Path(vendor_module("genicam", "genicam").__file__).with_name("viky.cti")


def config(producer: Path, **settings: object) -> GenicamCameraConfig:
    given = {"producers": (producer,), "pixel_format": "bgr8", "trigger": "none", **settings}
    return GenicamCameraConfig.model_validate(given)


def test_grab_starts_anew_and_gives_colour(producer: Path) -> None:
    with genicam.connect(config(producer, device="VikyTL_DEV_green")) as camera:
        assert camera.info.name == "genicam Machine Vision Games Ltd. Viky VikyTL_DEV_green"
        assert (camera.info.width, camera.info.height, camera.info.pixel_format) == (400, 400, "bgr8")
        first = camera.grab()
        assert first.image.shape == (400, 400, 3)
        assert first.image.dtype == np.uint8
        assert len(np.unique(first.image.reshape(-1, 3), axis=0)) > 1
        time.sleep(0.3)
        before = time.monotonic()
        second = camera.grab()
        assert before <= second.requested < second.received


def test_device_colours_are_blue_green_red(producer: Path) -> None:
    """The red camera of the game differs from the blue one in the channels that its name says."""
    means = {}
    for colour in ("red", "blue"):
        with genicam.connect(config(producer, device=f"VikyTL_DEV_{colour}")) as camera:
            means[colour] = camera.grab().image.reshape(-1, 3).mean(axis=0)
    difference = means["red"] - means["blue"]
    assert difference[2] > 0 > difference[0]


def test_search_path_finds_the_producer(producer: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GENICAM_GENTL64_PATH", str(producer.parent))
    with genicam.connect(GenicamCameraConfig(pixel_format="bgr8", trigger="none")) as camera:
        assert camera.info.name.endswith("VikyTL_DEV_red")
    monkeypatch.setenv("GENICAM_GENTL64_PATH", "")
    with pytest.raises(CameraError, match=r"no GenTL producer; install that of the camera's maker"):
        genicam.connect(GenicamCameraConfig())


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        ({"device": "Viky9"}, r"genicam Viky9: is not found; cameras found: VikyTL_DEV_red, VikyTL_DEV_green, "),
        ({"producers": ("nowhere.cti",)}, r"there is no producer file nowhere\.cti"),
        ({"pixel_format": "mono12"}, r"pixel_format mono12 is not among what it offers: .*RGBa8"),
        ({"trigger": "software"}, r"has no trigger; choose trigger: none"),
        ({"exposure_us": 100.0}, r"has no feature ExposureTime"),
    ],
)
def test_settings_the_camera_refuses_are_told(producer: Path, settings: dict[str, object], told: str) -> None:
    with pytest.raises(CameraError, match=told):
        genicam.connect(config(producer, **settings))


def test_file_that_is_no_producer_is_told(tmp_path: Path) -> None:
    (tmp_path / "broken.cti").write_bytes(b"no library")
    with pytest.raises(CameraError, match=r"genicam camera: cannot be opened: .*broken\.cti: "):
        genicam.connect(config(tmp_path / "broken.cti"))


class FailingAcquirer:
    """An acquirer whose first frames are damaged or missing, around a real one."""

    def __init__(self, real: Any, faults: list[str]) -> None:
        self._real, self._faults = real, faults

    def __getattr__(self, name: str) -> object:
        return getattr(self._real, name)

    @staticmethod
    def _lost() -> None:
        raise OSError("no such device")

    def try_fetch(self, *, timeout: float) -> object:
        fault = self._faults.pop(0) if self._faults else ""
        if fault == "missing":
            return None
        if fault == "unplugged":
            self.stop = self._lost
            raise OSError("device lost")
        buffer = self._real.try_fetch(timeout=timeout)
        return SimpleNamespace(is_complete=lambda: False, queue=buffer.queue) if fault == "damaged" else buffer


def test_damaged_and_missing_frames_are_taken_again_then_told(producer: Path) -> None:
    with genicam.connect(config(producer, retries=2)) as camera:
        assert isinstance(camera, genicam.GenicamCamera)
        real = camera._acquirer
        camera._acquirer = FailingAcquirer(real, ["damaged", "missing"])
        assert camera.grab().image.shape == (400, 400, 3)
        camera._acquirer = FailingAcquirer(real, ["damaged"] * 3)
        with pytest.raises(CameraError, match=r"no usable frame in 3 tries: an incomplete frame arrived\."):
            camera.grab()
        camera._acquirer = FailingAcquirer(real, ["unplugged"])
        with pytest.raises(CameraError, match=r"device lost\. Check power and cable"):
            camera.grab()
        real.stop()
        camera._acquirer = real
        assert camera.grab().image.shape == (400, 400, 3)


def test_software_trigger_comes_after_the_start_of_the_acquisition(
    producer: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The test producer has no trigger, so what would be executed is only written down."""
    calls: list[str] = []
    with genicam.connect(config(producer)) as camera:
        assert isinstance(camera, genicam.GenicamCamera)
        start = camera._acquirer.start

        def recorded() -> None:
            calls.append("start")
            start()

        monkeypatch.setattr(camera._acquirer, "start", recorded)
        monkeypatch.setattr(camera._features, "execute", calls.append)
        monkeypatch.setattr(camera, "_config", config(producer, trigger="software"))
        camera.grab()
    assert calls == ["start", "TriggerSoftware"]
