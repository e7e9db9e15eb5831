# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Shows a camera emulator of another maker what a camera on the emulated arm would see: an image file, kept up to date.

Made for pylon's camera emulator, which reads its image file anew at the first frame of every acquisition. The file is
replaced, never written to, so a frame is the old image or the new one. That it is the right one is up to the arm: it
holds, i.e. it counts as steady only when the file shows its present stop with its present outputs (the laser's).
"""

from __future__ import annotations

import os
import threading
from contextlib import suppress
from pathlib import Path

import cv2

from ...cameras.simulated import StopEye
from ...dataset_format import CameraInfo
from ..cell import SimulatedCell
from .link import EmulatorLink, EmulatorLinkError
from .state import ArmState

FILE_NAME = "frame.png"
_POLL = 0.01  # s


def pylon_features(folder: Path) -> dict[str, str]:
    """What pylon's camera emulator must be set to (`features` of a Basler camera's settings)."""
    return {"ImageFilename": str(folder), "ImageFileMode": "On", "TestImageSelector": "Off"}


class CameraFeed:
    """Follows one arm. While it moves, the file shows its last stop."""

    def __init__(self, link: EmulatorLink, cell: SimulatedCell, folder: Path, laser_pin: int) -> None:
        """cell: the emulator's (`link.cell()`); folder: must exist and should hold nothing else; laser_pin: the output
        that switches the laser, one that the arm has.

        Builds the scene, which takes some seconds.
        """
        self._link, self._laser_pin = link, laser_pin
        self._file = folder / FILE_NAME
        self._eye = StopEye(cell)
        self._shown: tuple[int, int, bytes] | None = None

    @property
    def info(self) -> CameraInfo:
        """Size and pixel format of the images."""
        return self._eye.cell.camera_info

    def begin(self) -> None:
        """Holds the arm and shows the present stop, or nothing yet where the arm moves."""
        self._link.hold(True)
        self.follow()

    def run(self, end: threading.Event) -> None:
        """Follows until `end`; EmulatorLinkError when the emulator is gone. Lets go of the arm in every case."""
        try:
            while not end.is_set():
                if not self.follow():
                    end.wait(_POLL)
        finally:
            with suppress(EmulatorLinkError):
                self._link.hold(False)

    def follow(self) -> bool:
        """Brings the file up to date; returns whether there was something to do."""
        state = self._link.state()
        view = (state.stop_index, state.switchings, state.T_true.tobytes())
        if state.moving or view == self._shown:
            return False
        self._write(state)
        self._shown = view
        self._link.rendered(state.stop_index, state.switchings)
        return True

    def _write(self, state: ArmState) -> None:
        """Replaces the file; no fsync, it is only looked at."""
        image = self._eye.image(state, state.switchings, laser_on=state.outputs[self._laser_pin])
        temporary = self._file.with_suffix(".tmp")
        temporary.write_bytes(cv2.imencode(".png", image, [cv2.IMWRITE_PNG_COMPRESSION, 1])[1].tobytes())
        os.replace(temporary, self._file)
