# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Cameras by cv2.VideoCapture: files written here, and a network stream of this machine."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
from pydantic import ValidationError
from support.camera_emulation import HEIGHT, WIDTH, StreamServer, picture, time_in

from cv_active_handeye.cameras import opencv
from cv_active_handeye.cameras.base import CameraError
from cv_active_handeye.cameras.opencv import OpencvCameraConfig

pytestmark = pytest.mark.timeout(60)
BEGAN = time.monotonic()


def video(file: Path, frames: int, dtype: type = np.uint8) -> Path:
    """A lossless video of `picture(0)`, `picture(1)`, ..."""
    depth = cv2.CV_8U if dtype is np.uint8 else cv2.CV_16U
    options = [cv2.VIDEOWRITER_PROP_DEPTH, depth, cv2.VIDEOWRITER_PROP_IS_COLOR, 0]
    code = cv2.VideoWriter.fourcc(*"FFV1")
    writer = cv2.VideoWriter(str(file), cv2.CAP_FFMPEG, code, 25.0, (WIDTH, HEIGHT), options)
    assert writer.isOpened()
    for seed in range(frames):
        writer.write(picture(seed, dtype))
    writer.release()
    return file


def config(**settings: object) -> OpencvCameraConfig:
    return OpencvCameraConfig.model_validate(settings)


@pytest.fixture
def stream() -> Iterator[StreamServer]:
    server = StreamServer(lambda: time.monotonic() - BEGAN)
    yield server
    server.close()


def test_file_gives_every_frame_once_and_tells_its_end(tmp_path: Path) -> None:
    file = video(tmp_path / "video.mkv", 3)
    with opencv.connect(config(source=str(file), pixel_format="mono8")) as camera:
        assert (camera.info.width, camera.info.height, camera.info.pixel_format) == (WIDTH, HEIGHT, "mono8")
        for seed in range(3):
            frame = camera.grab()
            np.testing.assert_array_equal(frame.image, picture(seed))
            time.sleep(0.05)  # nothing is skipped while nobody asks
        with pytest.raises(CameraError, match=r"video\.mkv: ended after 3 frames; there are no more"):
            camera.grab()


def test_file_of_16_bit_stays_16_bit(tmp_path: Path) -> None:
    file = video(tmp_path / "video.mkv", 2, np.uint16)
    with opencv.connect(config(source=str(file), pixel_format="mono16")) as camera:
        assert camera.info.pixel_format == "mono16"
        for seed in range(2):
            np.testing.assert_array_equal(camera.grab().image, picture(seed, np.uint16))


def test_numbered_images_are_a_file_too(tmp_path: Path) -> None:
    for i in range(3):
        cv2.imwrite(str(tmp_path / f"img{i:02d}.png"), picture(i, channels=3))
    with opencv.connect(config(source=str(tmp_path / "img%02d.png"), backend="images")) as camera:
        for i in range(3):
            np.testing.assert_array_equal(camera.grab().image, picture(i, channels=3))


def test_stream_frames_are_exposed_after_grab_was_called(stream: StreamServer) -> None:
    """The frames say themselves when they were made; without draining they would be as old as the buffer is long."""
    with opencv.connect(config(source=stream.address, latency_s=0.3)) as camera:
        for _ in range(3):
            time.sleep(0.4)
            frame = camera.grab()
            exposed = BEGAN + time_in(frame.image)  # in whole milliseconds
            assert frame.requested - 0.001 <= exposed <= frame.received
            assert frame.received - frame.requested < 0.6


def test_stream_that_falls_silent_is_told_in_time(stream: StreamServer) -> None:
    settings = config(source=stream.address, latency_s=0.1, timeout_s=0.3, retries=1)
    with opencv.connect(settings) as camera:
        camera.grab()
        stream.silent.set()
        time.sleep(0.2)
        began = time.monotonic()
        with pytest.raises(CameraError, match=r"in 2 tries: no frame within 0\.3 s|stopped delivering"):
            camera.grab()
        assert time.monotonic() - began < 1.5


def test_stream_that_ends_is_told(stream: StreamServer) -> None:
    with opencv.connect(config(source=stream.address, latency_s=0.1, timeout_s=5.0)) as camera:
        camera.grab()
        stream.ended.set()
        with pytest.raises(CameraError, match=r"stopped delivering after \d+ frames\. Check power and cable"):
            camera.grab()


def test_stream_that_answers_nothing_does_not_hang(stream: StreamServer) -> None:
    stream.silent.set()
    began = time.monotonic()
    with pytest.raises(CameraError, match=r"opencv stream http://127\.0\.0\.1:\d+/video\.mjpg: "):
        opencv.connect(config(source=stream.address, open_timeout_s=0.5))
    assert time.monotonic() - began < 3


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        ({"source": "nowhere.avi"}, r"opencv file nowhere\.avi: cannot be opened\."),
        ({"source": 97}, r"opencv device 97: cannot be opened\."),
        ({"source": "http://127.0.0.1:9/none.mjpg", "open_timeout_s": 2.0}, r"opencv stream .*: cannot be opened\."),
    ],
)
def test_source_that_does_not_exist_is_told(settings: dict[str, object], told: str) -> None:
    with pytest.raises(CameraError, match=told):
        opencv.connect(config(**settings))


def test_file_with_other_pixels_than_wanted_is_told(tmp_path: Path) -> None:
    file = video(tmp_path / "video.mkv", 1)
    with pytest.raises(CameraError, match=r"gives mono8, not mono16; change pixel_format"):
        opencv.connect(config(source=str(file), pixel_format="mono16"))


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        ({"source": "a.avi", "exposure": 5.0}, "exposure: need a device as source, given the file 'a.avi'"),
        ({"source": "rtsp://10.0.0.2/1", "width": 640}, "width: need a device as source, given the stream"),
        ({"source": 0, "timeout_s": 0.3}, "timeout_s: needs more than the latency of 0.3 s, given 0.3"),
        ({"source": 0, "zoom": 3}, "zoom"),
    ],
)
def test_settings_that_cannot_be_are_refused_early(settings: dict[str, object], told: str) -> None:
    with pytest.raises(ValidationError) as refused:
        config(**settings)
    assert told in str(refused.value)


@pytest.mark.parametrize(
    ("source", "kind"),
    [
        (0, "device"),
        ("/dev/video2", "device"),
        ("rtsp://10.0.0.2/1", "stream"),
        ("videotestsrc ! appsink", "stream"),
        ("run.avi", "file"),
    ],
)
def test_kind_of_a_source(source: int | str, kind: str) -> None:
    assert config(source=source).kind == kind


class StubbornDevice:
    """A driver that rounds what it is told, and ignores the gain."""

    def __init__(self) -> None:
        self.values: dict[int, float] = {cv2.CAP_PROP_GAIN: 3.0}

    def open(self, *_: object) -> bool:
        return True

    def release(self) -> None:
        self.values = {}

    def set(self, number: int, value: float) -> bool:
        if number != cv2.CAP_PROP_GAIN:
            self.values[number] = value * 1.005
        return True

    def get(self, number: int) -> float:
        return self.values.get(number, 0.0)

    def read(self, *_: object) -> tuple[bool, cv2.typing.MatLike]:
        time.sleep(0.01)
        return True, picture(1, channels=3)


def test_device_settings_are_read_back(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cv2, "VideoCapture", StubbornDevice)
    with opencv.connect(config(source=0, width=64, auto_exposure=1.0, exposure=150.0)) as camera:
        assert camera.grab().image.shape == (HEIGHT, WIDTH, 3)
    with pytest.raises(CameraError, match=r"device 0: gain: 12 was asked for, the driver says 3; choose a value"):
        opencv.connect(config(source=0, gain=12.0))
