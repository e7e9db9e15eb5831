# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The command `emulate camera`: what a camera on an emulated arm would see, for the camera emulator of pylon."""

from __future__ import annotations

import signal
import threading
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .application import Settings, print_lines
from .console import told_errors
from .emulate import command

if TYPE_CHECKING:
    from ..simulation.emulators import EmulatorLink

Control = Annotated[str, typer.Option(help="Control port of the emulated robot, as it prints it: HOST:PORT.")]
Folder = Annotated[Path, typer.Option(help="Folder for the image, with nothing else in it; made if there is none.")]
LaserPin = Annotated[int, typer.Option(min=0, help="Digital output of the robot that switches the laser.")]


@command("emulate camera --folder out/frames", "emulate camera --control 127.0.0.1:30020 --folder out/frames")
def camera(control: Control = "127.0.0.1:30020", folder: Folder = Path("frames"), laser_pin: LaserPin = 0) -> None:
    """Renders what a camera on an emulated arm sees into an image file that pylon's camera emulator shows.

    Start it after `emulate ur` or `emulate denso`, with the environment variable PYLON_CAMEMU=1 for the program that
    grabs. The arm counts as steady only when the image shows its present stop, laser on or off as it is. While the arm
    moves, the image is that of the stop before. Ctrl-C ends it; it ends with the robot's emulator, too.
    """
    with told_errors(Settings.debug):
        link = _linked(control)
        ended = threading.Event()
        previous = {number: signal.signal(number, lambda *_: ended.set()) for number in (signal.SIGINT, signal.SIGTERM)}
        try:
            _follow(link, folder, laser_pin, ended)
        finally:
            link.close()
            for number, handler in previous.items():
                signal.signal(number, handler)
    print_lines("ended")


def _follow(link: EmulatorLink, folder: Path, laser_pin: int, ended: threading.Event) -> None:
    from ..simulation import SimulatedCell
    from ..simulation.emulators import EmulatorLinkError
    from ..simulation.emulators.camera_feed import CameraFeed, pylon_features

    _check_folder(folder)
    lines = [f"{name}: {value}" for name, value in pylon_features(folder).items()]
    try:
        pins = link.state().outputs
        if laser_pin not in pins:
            raise typer.BadParameter(f"needs one of {list(pins)}, given {laser_pin}", param_hint="--laser-pin")
        feed = CameraFeed(link, SimulatedCell(link.cell()), folder, laser_pin)
        info = feed.info
        feed.begin()
        print_lines(f"ready camera {info.width} x {info.height} {info.pixel_format}", *lines)
        feed.run(ended)
    except EmulatorLinkError as error:
        print_lines(str(error))


def _check_folder(folder: Path) -> None:
    from ..simulation.emulators.camera_feed import FILE_NAME

    folder.mkdir(parents=True, exist_ok=True)
    others = sorted(file.name for file in folder.iterdir() if file.stem != Path(FILE_NAME).stem)
    if others:
        raise typer.BadParameter(f"{folder}: needs a folder of its own, found {others[0]}", param_hint="--folder")


def _linked(control: str) -> EmulatorLink:
    from ..simulation.emulators import EmulatorLink, EmulatorLinkError

    host, _, port = control.rpartition(":")
    if not host or not port.isdigit():
        raise typer.BadParameter(f"needs HOST:PORT, given {control!r}", param_hint="--control")
    try:
        return EmulatorLink(host, int(port))
    except EmulatorLinkError as error:
        raise typer.BadParameter(str(error), param_hint="--control") from error
