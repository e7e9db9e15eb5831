# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Cameras without hardware: pylon's camera emulator, the GenTL test producer, a network stream, and images to show."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from cv_active_handeye.cameras.basler import BaslerCameraConfig
from cv_active_handeye.dataset import Image
from cv_active_handeye.simulation.emulators.camera_feed import pylon_features

os.environ["PYLON_CAMEMU"] = "2"  # read when pylon first looks for cameras

WIDTH, HEIGHT = 64, 48


def picture(seed: int, dtype: type = np.uint8, channels: int = 1) -> Image:
    """Random pixels (HEIGHT, WIDTH[, 3])."""
    shape = (HEIGHT, WIDTH) if channels == 1 else (HEIGHT, WIDTH, channels)
    values = np.random.default_rng(seed).integers(0, np.iinfo(dtype).max, shape, endpoint=True)
    return values.astype(np.uint8) if dtype is np.uint8 else values.astype(np.uint16)


def show(folder: Path, image: Image) -> None:
    """Replaces the image of an emulated camera."""
    temporary = folder / "frame.tmp"
    temporary.write_bytes(cv2.imencode(".png", image)[1].tobytes())
    temporary.replace(folder / "frame.png")


def basler_config(folder: Path, **settings: object) -> BaslerCameraConfig:
    """pylon's emulator, showing the image of `folder`."""
    given = {"width": WIDTH, "height": HEIGHT, "features": pylon_features(folder), "timeout_s": 1.0, **settings}
    return BaslerCameraConfig.model_validate(given)


def counted_frame(seconds: float) -> NDArray[np.uint8]:
    """A frame (HEIGHT, WIDTH, 3) whose 24 blocks of 8 x 16 pixels say a time in ms, black for 0 and white for 1."""
    bits = [(int(seconds * 1000) >> bit) & 1 for bit in range(24)]
    blocks = np.array(bits, np.uint8).reshape(6, 4) * 255
    grey = np.kron(blocks, np.ones((8, 16), np.uint8))
    return np.repeat(grey[:, :, None], 3, axis=2)


def time_in(image: Image) -> float:
    """The time of a `counted_frame`, s."""
    grey = image if image.ndim == 2 else image[:, :, 0]
    bits = (grey[4::8, 8::16] > 127).ravel()
    return float(sum(int(bit) << i for i, bit in enumerate(bits))) / 1000


class StreamServer:
    """A network camera on this machine: motion JPEG over HTTP, every frame says when it was made.

    `silent` set: connected clients get nothing more.
    """

    def __init__(self, clock: Callable[[], float], period: float = 0.04) -> None:
        self.silent = threading.Event()
        self.ended = threading.Event()
        stream = self

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                self.send_response(200)
                self.send_header("Content-Type", "multipart/x-mixed-replace; boundary=frame")
                self.end_headers()
                try:
                    while not stream.ended.wait(period):
                        if not stream.silent.is_set():
                            self._send(counted_frame(clock()))
                except OSError:
                    return  # the client is gone

            def _send(self, frame: NDArray[np.uint8]) -> None:
                data = cv2.imencode(".jpg", frame)[1].tobytes()
                head = f"--frame\r\nContent-Type: image/jpeg\r\nContent-Length: {len(data)}\r\n\r\n"
                self.wfile.write(head.encode() + data + b"\r\n")

            def log_message(self, *_: object) -> None:
                """Nothing on the terminal."""

        self._server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self._server.daemon_threads = True
        self.address = f"http://127.0.0.1:{self._server.server_port}/video.mjpg"
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.05,), daemon=True)
        self._thread.start()

    def close(self) -> None:
        self.ended.set()
        self._server.shutdown()
        self._server.server_close()


def seconds_of(action: Callable[[], object]) -> float:
    """How long a call takes, s."""
    began = time.monotonic()
    action()
    return time.monotonic() - began
