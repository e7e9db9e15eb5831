# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A camera on an emulated arm: renders what it sees from where the flange is at the moment of the exposure."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Literal

from pydantic import Field

from ..dataset import Image
from .base import Camera, CameraError, Frame
from .common import OpenCamera, StrictConfig, checked_frame

if TYPE_CHECKING:
    from ..simulation import SimulatedCell
    from ..simulation.cell import StopLight
    from ..simulation.emulators import ArmState


class SimulatedCameraConfig(StrictConfig):
    """host, port: the control port of an emulator (`cv-active-handeye emulate`), which also says which cell it is.

    laser_pin: the digital output of the robot that switches the laser; None = the camera's own line does. timeout_s:
    for an answer of the emulator.
    """

    type: Literal["sim"] = "sim"
    host: str = "127.0.0.1"
    port: int = Field(default=30020, ge=1, le=65535)
    laser_pin: int | None = Field(default=None, ge=0)
    timeout_s: float = Field(default=5.0, gt=0, le=60, allow_inf_nan=False)


def connect(config: SimulatedCameraConfig) -> Camera:
    """Connects to the emulator's control port; CameraError where there is none. Building the scene takes seconds."""
    try:
        from ..simulation import SimulatedCell
        from ..simulation.emulators import EmulatorLink, EmulatorLinkError
    except ImportError as error:
        raise CameraError(f"simulated camera: {error}; pip install 'cv_active_handeye[sim]'") from error
    try:
        link = EmulatorLink(config.host, config.port, config.timeout_s)
    except EmulatorLinkError as error:
        raise CameraError(f"simulated camera: {error}") from error
    try:
        cell = SimulatedCell(link.cell())
        return SimulatedCamera(cell, link.state, laser_pin=config.laser_pin, release=link.close)
    except (CameraError, EmulatorLinkError) as error:
        link.close()
        raise CameraError(str(error) if isinstance(error, CameraError) else f"simulated camera: {error}") from error


class SimulatedCamera(OpenCamera):
    """Same cell, same stop, same number of exposures at it: same bytes. A moving arm is seen where it is, unblurred."""

    def __init__(
        self,
        cell: SimulatedCell,
        state: Callable[[], ArmState],
        *,
        laser_pin: int | None = None,
        release: Callable[[], None] = lambda: None,
    ) -> None:
        """state: the arm's, now (`EmulatedArm.state`, `EmulatorLink.state`); release: called once by `close`.

        Builds the scene, which takes some seconds, so that no exposure has to.
        """
        self._eye = StopEye(cell)
        super().__init__(cell.camera_info, retries=0)
        self._state, self._laser_pin, self._release = state, laser_pin, release
        self._line = False
        self._lock = threading.Lock()
        pins = state().outputs
        if laser_pin is not None and laser_pin not in pins:
            raise CameraError(f"simulated camera: laser_pin: the robot has the outputs {list(pins)}, given {laser_pin}")

    def _expose(self) -> Frame:
        from ..simulation.emulators import EmulatorLinkError

        requested = time.monotonic()
        try:
            state = self._state()
        except EmulatorLinkError as error:
            raise CameraError(f"simulated camera: {error}") from error
        on = self._line if self._laser_pin is None else state.outputs[self._laser_pin]
        with self._lock:
            return checked_frame(self._eye.expose(state, laser_on=on), None, requested)

    def set_line(self, on: bool) -> None:
        """Switches the laser; CameraError where an output of the robot does, or where there is none."""
        if self._laser_pin is not None:
            raise CameraError(f"simulated camera: its laser is switched by the robot's output {self._laser_pin}")
        if on and not self._eye.cell.config.laser:
            raise CameraError("simulated camera: its cell has no laser")
        self._line = on

    def close(self) -> None:
        """Switches the laser off and disconnects."""
        self._line = False
        release, self._release = self._release, lambda: None
        release()


class StopEye:
    """Casts the rays of a stop once, however many exposures are made there."""

    def __init__(self, cell: SimulatedCell) -> None:
        """Builds the scene."""
        self.cell = cell
        self._light: StopLight = cell.light(cell.start(), 0)
        self._seen: tuple[int, bytes] | None = None
        self._exposures: dict[int, int] = {}

    def expose(self, state: ArmState, *, laser_on: bool) -> Image:
        """The image (H, W) at the true pose of `state`, with the next noise of this stop."""
        count = self._exposures.get(state.stop_index, 0)
        self._exposures[state.stop_index] = count + 1
        return self.image(state, count, laser_on=laser_on)

    def image(self, state: ArmState, count: int, *, laser_on: bool) -> Image:
        """The image of exposure number `count` at the stop of `state`."""
        stop, pose = state.stop_index, state.T_true
        if self._seen != (stop, pose.tobytes()):
            self._light = self.cell.light(pose, stop)
            self._seen = (stop, pose.tobytes())
        off, on = self._light
        return self.cell.expose(on if laser_on and on is not None else off, stop, count)
