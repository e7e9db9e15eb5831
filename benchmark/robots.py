# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""`cv-active-handeye run` on emulated controllers in other processes: errors of the calibration against the truth.

UR: the controller emulator, ur_rtde as it is, and pylon's camera emulator (pypylon as it is) fed with rendered frames,
laser by an output of the robot. DENSO: the controller emulator, the own b-CAP client, the simulated camera. 24 stops
each, planned from where the arm stands. Another seed is another cell.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from cv_active_handeye.calibration import Calibration
from cv_active_handeye.report import calibration_errors, inside_intervals
from cv_active_handeye.simulation import CellConfig, SimulatedCell, nominal_planning
from cv_active_handeye.simulation.emulators import moves_after_stop, read_events
from cv_active_handeye.simulation.emulators.camera_feed import pylon_features

from .demo import LIMITS
from .emulator import PROGRAM, Emulator
from .report import Measure, Report, Table, finish, parser

STOPS = 24
SEEDS = 3
SPEEDUP = 4.0
MODELS = {"ur": "ur5e", "denso": "denso_vp6242"}
CAMERAS = {"ur": "ur_rtde, pypylon", "denso": "b-CAP, simulated camera"}

_CAMERA_LINE: dict[str, Any] = {"type": "camera_line"}
_ROBOT_OUTPUT: dict[str, Any] = {"type": "robot_output", "pin": 0}


@dataclass(frozen=True)
class Run:
    """One run; errors are NaN where it failed."""

    device: str
    seed: int
    status: int
    rotation_deg: float
    translation_mm: float
    fx_percent: float
    held: int
    intervals: int
    seconds: float
    violations: int


def run(device: str, seed: int, folder: Path) -> Run:
    """Emulator, camera feed where there is one, and the command, each in its process."""
    folder.mkdir(parents=True)
    host = f"127.0.{10 + seed}.{1 + (device == 'ur')}"
    options = ["--seed", str(seed), "--speedup", f"{SPEEDUP:g}", "--robot", MODELS[device]]
    with Emulator(device, host, folder / "controller.jsonl", options) as emulator:
        config = emulator.link.cell()
        camera, laser = _simulated_camera(emulator), _CAMERA_LINE
        if device == "ur":
            camera, laser = _pylon_camera(folder / "frames", config), _ROBOT_OUTPUT
        station = _station(device, host, camera, laser, config, emulator.link.state().T_reported)
        (folder / "station.yaml").write_text(yaml.safe_dump(station))
        with _feed(emulator, folder / "frames") if device == "ur" else _nothing():
            begun = time.monotonic()
            status = _command(folder)
    events = read_events(folder / "controller.jsonl")
    broken = len(moves_after_stop(events)) + sum(event["kind"] == "violation" for event in events)
    return _judged(device, seed, status, folder, config, time.monotonic() - begun, broken)


def _judged(
    device: str, seed: int, status: int, folder: Path, config: CellConfig, seconds: float, broken: int
) -> Run:
    if status != 0:
        print((folder / "run.log").read_text()[-2000:], file=sys.stderr)
        return Run(device, seed, status, np.nan, np.nan, np.nan, 0, 0, seconds, broken)
    calibration, truth = Calibration.load(folder / "run" / "calibration.yaml"), SimulatedCell(config).truth
    errors, inside = calibration_errors(calibration, truth), inside_intervals(calibration, truth)
    return Run(
        *(device, seed, status, errors.rotation_deg, errors.translation_mm, errors.fx_percent),
        *(sum(inside.values()), len(inside), seconds, broken),
    )


def _station(
    device: str, host: str, camera: dict[str, Any], laser: dict[str, Any], config: CellConfig, T: Any
) -> dict[str, Any]:
    planning = nominal_planning(config, T)
    planning["workspace"] = planning["workspace"].model_dump(mode="json")
    return {
        "schema_version": 1,
        "robot": {"type": device, "host": host, "model": MODELS[device]},
        "camera": camera,
        "laser": laser,
        "planning": {**planning, "light_plane_mm": list(planning["light_plane_mm"]), "stops": STOPS},
    }


def _simulated_camera(emulator: Emulator) -> dict[str, Any]:
    return {"type": "sim", "host": emulator.address[0], "port": emulator.address[1]}


def _pylon_camera(frames: Path, config: CellConfig) -> dict[str, Any]:
    size = {"width": config.width, "height": config.height}
    return {"type": "basler", **size, "features": dict(pylon_features(frames))}


@contextmanager
def _feed(emulator: Emulator, frames: Path) -> Iterator[None]:
    """`emulate camera`: renders what pylon's emulator shows."""
    control = f"{emulator.address[0]}:{emulator.address[1]}"
    command = [*PROGRAM, "emulate", "camera", "--control", control, "--folder", str(frames)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            if not any(line.startswith("ready") for line in process.stdout):
                raise RuntimeError("the camera feed did not start")
            yield
        finally:
            process.terminate()
            process.stdout.read()


@contextmanager
def _nothing() -> Iterator[None]:
    yield


def _command(folder: Path) -> int:
    command = [*PROGRAM, "run", str(folder / "run"), "--station", str(folder / "station.yaml"), "--live"]
    environment = {**os.environ, "PYLON_CAMEMU": "1", "XDG_STATE_HOME": str(folder / "state")}
    with (folder / "run.log").open("w") as output:
        given: dict[str, Any] = {"stdout": output, "stderr": subprocess.STDOUT, "text": True, "timeout": 1200}
        return subprocess.run(command, input="move\n", env=environment, **given).returncode


def report_of(runs: Sequence[Run]) -> Report:
    """A row a run; medians against the limits of the simulated cell's recordings with 24 stops."""
    columns = ("controller", "seed", "R [deg]", "t [mm]", "fx [%]", "intervals that hold", "seconds", "violations")
    rows = [
        (
            *(f"{r.device}: {CAMERAS[r.device]}", r.seed, r.rotation_deg, r.translation_mm, r.fx_percent),
            *(f"{r.held} of {r.intervals}", r.seconds, r.violations),
        )
        for r in runs
    ]
    measures = []
    for device in dict.fromkeys(r.device for r in runs):
        for name, limit in LIMITS["24 stops"].items():
            errors = [getattr(r, name) for r in runs if r.device == device]
            median = float(np.median(np.nan_to_num(errors, nan=np.inf)))
            measures.append(Measure(f"{device}: median {name}", median, limit))
    measures.append(Measure("violations of the protocol, moves after a stop", sum(r.violations for r in runs), 0))
    setup = (__doc__ or "").split("\n\n", 1)[1]
    return Report("`run` on emulated controllers", setup, [_table(columns, rows)], measures)


def _table(columns: Sequence[str], rows: Sequence[Sequence[Any]]) -> Table:
    note = f"The emulators run {SPEEDUP:g} times as fast as an arm; the time is that of planning, motion and all."
    return Table("Errors against the truth", columns, rows, note)


def measure(seeds: int = SEEDS) -> Report:
    """Runs both devices on every seed."""
    runs = []
    with tempfile.TemporaryDirectory() as temporary:
        for seed in range(seeds):
            for device in MODELS:
                runs.append(run(device, seed, Path(temporary) / f"{device}{seed}"))
                print(runs[-1], file=sys.stderr)
    return report_of(runs)


def main() -> int:
    """Command line."""
    arguments = parser(__doc__ or "")
    arguments.add_argument("--seeds", type=int, default=SEEDS)
    given = arguments.parse_args()
    return finish(measure(given.seeds), given.output)


if __name__ == "__main__":
    raise SystemExit(main())
