# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Emulated DENSO controllers for tests: in this process, or as the command line runs them."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from cv_active_handeye.robots.bcap import BcapClient, BcapError
from cv_active_handeye.robots.bcap_codes import Function
from cv_active_handeye.robots.bcap_packets import Value
from cv_active_handeye.robots.denso import DensoConfig, DensoRobot
from cv_active_handeye.robots.denso_link import PROVIDERS, Controller
from cv_active_handeye.robots.denso_pose import numbers
from cv_active_handeye.simulation import CellConfig
from cv_active_handeye.simulation.emulators import EmulatedArm, EmulatorLink, EventLog, Faults, read_events
from cv_active_handeye.simulation.emulators.denso import DENSO_FAULTS, DensoEmulator
from cv_active_handeye.simulation.emulators.log import Event

Array = NDArray[np.float64]


@dataclass
class Emulated:
    """An emulated controller in this process."""

    arm: EmulatedArm
    port: int

    def config(self, **options: Any) -> DensoConfig:
        """A loaded machine may take longer than a controller's network does, hence the long freshness limit."""
        return DensoConfig.model_validate({"host": "127.0.0.1", "port": self.port, "freshness_s": 0.5, **options})

    def commands(self) -> list[str]:
        return [event["name"] for event in self.arm.log.of_kind("command")]

    def violations(self) -> list[str]:
        return [event["text"] for event in self.arm.log.of_kind("violation")]


@contextmanager
def emulated_denso(speedup: float = 20.0, **options: Any) -> Iterator[Emulated]:
    log = EventLog()
    arm = EmulatedArm(CellConfig(), speedup=speedup, log=log, faults=Faults(log, DENSO_FAULTS))
    before = set(threading.enumerate())
    with DensoEmulator(arm, port=0, **options) as emulator:
        yield Emulated(arm, emulator.port)
    arm.close()
    assert set(threading.enumerate()) <= before, "the emulator left threads behind"


class RawSession:
    """A client that does what it is told, in any order."""

    def __init__(self, port: int, controller: Controller = "rc8", silence_s: float = 1.0) -> None:
        self.client = BcapClient("127.0.0.1", port, silence_s=silence_s)
        try:
            provider = PROVIDERS[controller]
            self.controller = self.client.call(Function.CONTROLLER_CONNECT, "", provider, "localhost", "")
            self.robot = self.client.call(Function.CONTROLLER_GET_ROBOT, self.controller, "Arm", "")
        except BcapError:
            self.client.close()
            raise

    def execute(self, command: str, parameter: Value = None) -> Value:
        return self.client.call(Function.ROBOT_EXECUTE, self.robot, command, parameter)

    def numbers(self, command: str, parameter: Value = None) -> Array:
        return numbers(self.execute(command, parameter), 1, command)

    def move(self, pose: Value, interpolation: int = 2, option: str = "") -> Value:
        return self.client.call(Function.ROBOT_MOVE, self.robot, interpolation, pose, option, deadline_s=20.0)

    def halt(self) -> None:
        self.client.call(Function.ROBOT_HALT, self.robot, "")

    def ready(self, percent: float = 5.0) -> None:
        self.execute("TakeArm", [0, 0])
        self.execute("ExtSpeed", [percent, percent, percent])
        self.execute("Motor", [1, 0])

    def __enter__(self) -> RawSession:
        return self

    def __exit__(self, *_: object) -> None:
        self.client.close()


@dataclass
class Running:
    """An emulated controller in another process."""

    port: int
    link: EmulatorLink
    log: Path
    process: subprocess.Popen[str]

    def config(self, **options: Any) -> DensoConfig:
        return DensoConfig.model_validate({"host": "127.0.0.1", "port": self.port, "freshness_s": 0.5, **options})

    def events(self) -> list[Event]:
        return read_events(self.log)


@contextmanager
def denso_process(folder: Path, *options: str, ends_well: bool = True) -> Iterator[Running]:
    """`cv-active-handeye emulate denso` on free ports; `ends_well`: ends within 10 s after SIGTERM, with status 0."""
    log = folder / "events.jsonl"
    program = [sys.executable, "-c", "from cv_active_handeye.cli import app; app()"]
    command = [*program, "emulate", "denso", "--port", "0", "--control-port", "0"]
    environment = {**os.environ, "COLUMNS": "200"}
    process = subprocess.Popen(
        [*command, "--log", str(log), *options], stdout=subprocess.PIPE, text=True, env=environment
    )
    assert process.stdout is not None
    try:
        ready = next(line for line in process.stdout if line.startswith("ready "))
        ports = re.search(r"port (\d+), .*control 127\.0\.0\.1:(\d+)", ready)
        assert ports, ready
        drain = threading.Thread(target=process.stdout.read, daemon=True)
        drain.start()
        with EmulatorLink(port=int(ports[2])) as link:
            yield Running(int(ports[1]), link, log, process)
        process.send_signal(signal.SIGTERM)
        assert (process.wait(10) == 0) == ends_well
        drain.join(5)
    finally:
        process.kill()
        process.wait()
        process.stdout.close()


def moved(pose: Array, mm: tuple[float, float, float], rotvec_deg: tuple[float, float, float] = (0, 0, 0)) -> Array:
    """A flange pose shifted in the base frame and turned about its own axes."""
    out = pose.copy()
    out[:3, 3] += np.array(mm) / 1000
    out[:3, :3] = pose[:3, :3] @ Rotation.from_rotvec(np.radians(rotvec_deg)).as_matrix()
    return out


def start_of(robot: DensoRobot) -> Array:
    return robot.pose().T_gripper2base
