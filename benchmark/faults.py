# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Captures on emulated controllers that fail at random moments: nothing moves after a stop, and no view is lost.

Every trial is a controller in one process and `cv-active-handeye capture` in another, as a user starts them. The fault
sets in at a random moment; the capture has to end within its time, name the cause, and leave every view on disk. Then a
person clears the fault, and `capture --resume` has to complete the data set. The controller's own log is the judge.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from threading import Thread
from typing import Any

import cv2
import numpy as np
import yaml

from cv_active_handeye.dataset import FILE_NAME, Dataset
from cv_active_handeye.plan_file import Plan, PlannedPose, PlannedStop
from cv_active_handeye.robots.workspace import Box, Workspace
from cv_active_handeye.simulation.emulators import EmulatorLink, EmulatorLinkError, moves_after_stop
from cv_active_handeye.simulation.emulators import read_events as controller_events
from cv_active_handeye.workflow.event_log import read_events

from .emulator import PROGRAM, Emulator
from .report import Cell, Measure, Report, Table, finish, parser

TRIALS = 240
SPEEDUP = 10.0
STOPS = 5
DEADLINE_S = 90.0
"""For one capture on two busy cores; without a fault it takes some 10 s."""
GRACE_S = 0.25
"""A clock that stands still, or a line that is silent, cannot be told from a slow one before 0.2 s have passed."""
LATEST_S = 1.5
"""After the first motion has begun; a capture is over after about as long."""

NAMED = {
    "protective_stop": "protective stop",
    "emergency_stop": "emergency stop",
    "unreachable": "reach|no joint solution|refuse",
    "drop_link": "link lost|connection|closed",
    "frozen_timestamp": "stale pose|link lost|stands still",
    "silent_port": "link lost|stale pose|answer|silent",
    "not_remote": "remote control|automatic|Auto",
    "slow_settling": "not arrived|come to rest|steady",
    "pose_noise": "not arrived|come to rest|off the path",
    "slow_motion": "deadline|not arrived",
    "program_stopped": "program stopped|program",
    "register_conflict": "registers",
}
"""What the person has to read, by fault; `pose_bias` is one that nobody can see at the robot."""
VALUES = {"slow_settling": 300.0, "slow_motion": 0.002}
"""Sizes in emulator time that a capture cannot wait for."""
BEFORE = ("not_remote", "register_conflict", "silent_port")
"""Faults that are also tried on a controller that has them from the beginning."""


@dataclass(frozen=True)
class Trial:
    """One fault: what it was, and what of the promises was broken (empty: nothing)."""

    device: str
    fault: str
    moment: str
    ended: str
    views: int
    seconds: float
    broken: tuple[str, ...]


@dataclass(frozen=True)
class Capture:
    """One call of the program."""

    status: int | None
    output: str
    seconds: float


def trial(seed: int, folder: Path) -> Trial:
    """One fault at one moment; everything follows from the seed."""
    rng = np.random.default_rng([seed, 5])
    device = ("ur", "denso")[seed % 2]
    known = [name for name in [*NAMED, "pose_bias"] if device == "ur" or name != "register_conflict"]
    fault = known[(seed // 2) % len(known)]
    moment = _moment(rng, fault)
    host = f"127.0.{1 + seed // 200}.{1 + seed % 200}"
    folder.mkdir(parents=True)
    value = f"={VALUES[fault]:g}" if fault in VALUES else ""
    later = moment.endswith("later")
    faults = [] if later else ["--fault", f"{fault}{value}{moment}"]
    options = ["--speedup", f"{SPEEDUP:g}", *faults]
    with Emulator(device, host, folder / "controller.jsonl", options) as emulator:
        _prepare(folder, device, host, emulator.link)
        if later:
            Thread(target=_fault_later, args=(emulator.address, fault, float(moment.split()[0])), daemon=True).start()
        first = _capture(folder, resume=False)
        broken = _judged(folder, first, fault)
        views = _views(folder)
        kept = _bytes(folder)
        if device == "ur":
            emulator.link.fault("program_stopped")  # as the message after a lost connection asks
        emulator.link.clear()
        if first.status != 0:
            second = _capture(folder, resume=(folder / "set" / FILE_NAME).is_file())
            broken += _judged_again(folder, second, kept)
    broken += _judged_by_controller(folder / "controller.jsonl")
    return Trial(device, fault, moment or "from the beginning", _ended(first), views, first.seconds, tuple(broken))


def _moment(rng: np.random.Generator, fault: str) -> str:
    """In the middle of a motion, when the arm comes to a stand, some time after the first motion began, or before."""
    kinds = ["@move", "@stop", "later"] + [""] * (fault in BEFORE)
    kind = kinds[rng.integers(len(kinds))]
    if kind == "later":
        return f"{rng.uniform(0, LATEST_S):.2f} s later"
    return kind and f"{kind}{rng.integers(1, STOPS + 1)}"


def _fault_later(address: tuple[str, int], fault: str, seconds: float) -> None:
    """Lets a fault set in some time after the first motion has begun."""
    try:
        with EmulatorLink(*address, 10.0) as link:
            while not link.state().moving:
                time.sleep(0.02)
            time.sleep(seconds)
            link.fault(fault, VALUES.get(fault))
    except EmulatorLinkError:
        return  # the trial is over


def _prepare(folder: Path, device: str, host: str, link: EmulatorLink) -> None:
    """A plan of short translations about where the arm is, images for the camera, and the station file."""
    T = link.state().T_reported
    middle = 1000 * T[:3, 3]
    lower, upper = ((float(x), float(y), float(z)) for x, y, z in (middle - 100, middle + 100))
    ways = 0.02 * np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, 0, -1]])
    stops = [
        PlannedStop(R_gripper2base=T[:3, :3], t_gripper2base=T[:3, 3] + way, group=0, laser=False) for way in ways
    ]
    model = link.cell().robot
    start = PlannedPose(R_gripper2base=T[:3, :3], t_gripper2base=T[:3, 3])
    workspace = Workspace(box=Box(lower_mm=lower, upper_mm=upper))
    Plan(robot=device, model=model, start=start, workspace=workspace, stops=tuple(stops)).save(folder / "plan.yaml")
    (folder / "images").mkdir()
    rng = np.random.default_rng(1)
    image = cv2.GaussianBlur(rng.uniform(0, 255, (48, 64)).astype(np.float32), (0, 0), 2).astype(np.uint8)
    for number in range(4 * STOPS):
        cv2.imwrite(str(folder / "images" / f"{number:03d}.png"), image)
    station: dict[str, Any] = {
        "schema_version": 1,
        "robot": {"type": device, "host": host, "model": model},
        "camera": {"type": "folder", "folder": str(folder / "images")},
        "capture": {"settle": {"dwell_s": 0.05, "deadline_s": 4.0}, "least_free_mb": 1},
    }
    (folder / "station.yaml").write_text(yaml.safe_dump(station))


def _capture(folder: Path, *, resume: bool) -> Capture:
    options = ["--resume"] if resume else ["--plan", str(folder / "plan.yaml")]
    command = [*PROGRAM, "capture", str(folder / "set"), "--station", str(folder / "station.yaml"), "--live"]
    begun = time.monotonic()
    process = subprocess.Popen(
        [*command, *options],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env={**os.environ, "COLUMNS": "300", "XDG_STATE_HOME": str(folder / "state")},
    )
    try:
        output, _ = process.communicate("move\n", timeout=DEADLINE_S)
        return Capture(process.returncode, output, time.monotonic() - begun)
    except subprocess.TimeoutExpired:
        process.kill()
        return Capture(None, process.communicate()[0], DEADLINE_S)


def _judged(folder: Path, capture: Capture, fault: str) -> list[str]:
    broken = _ended_well(capture)
    events = read_events(folder / "set" / "events.jsonl") if (folder / "set" / "events.jsonl").is_file() else []
    stored = sum(event["event"] == "stored" for event in events)
    if stored != _views(folder):
        broken.append(f"lost views: {stored} were stored, {_views(folder)} can be read")
    if capture.status == 0 and _views(folder) != STOPS:
        broken.append("an incomplete capture ended as a complete one")
    if capture.status not in (0, None) and not re.search(NAMED.get(fault, "$^"), capture.output, re.IGNORECASE):
        broken.append(f"not named: {capture.output.strip()[-300:]}")
    return broken


def _judged_again(folder: Path, capture: Capture, kept: dict[str, bytes]) -> list[str]:
    broken = [f"resumed: {text}" for text in _ended_well(capture)]
    if capture.status != 0 or _views(folder) != STOPS:
        broken.append(f"resumed: not completed, {_views(folder)} views: {capture.output.strip()[-300:]}")
    now = _bytes(folder)
    changed = [name for name, content in kept.items() if now.get(name) != content]
    if changed:
        broken.append(f"resumed: changed views {changed}")
    return broken


def _ended_well(capture: Capture) -> list[str]:
    broken = []
    if capture.status is None:
        broken.append(f"hang: not over after {DEADLINE_S:g} s")
    elif capture.status not in (0, 6) or "Traceback" in capture.output:
        broken.append(f"exception, status {capture.status}: {capture.output.strip()[-300:]}")
    return broken


def _judged_by_controller(log: Path) -> list[str]:
    """Motions that were asked for after a stop condition and before a person cleared it."""
    return [f"moved after a stop: {event}" for event in moves_after_stop(controller_events(log), GRACE_S)]


def _views(folder: Path) -> int:
    """Views that can be read back, with their images."""
    if not (folder / "set" / FILE_NAME).is_file():
        return 0
    dataset = Dataset.open(folder / "set")
    return sum(dataset.image(view) is not None for view in range(len(dataset)))


def _bytes(folder: Path) -> dict[str, bytes]:
    named = {f"{view:04d}.png" for view in range(_views(folder))}
    images = (folder / "set" / "images").glob("*.png")
    return {file.name: file.read_bytes() for file in images if file.name in named}


def _ended(capture: Capture) -> str:
    return {0: "completed", 6: "stopped", None: "hang"}.get(capture.status, f"status {capture.status}")


def report_of(trials: Sequence[Trial]) -> Report:
    """Counts of broken promises, and a row a fault and device."""
    broken = Counter(text.removeprefix("resumed: ").split(":")[0] for one in trials for text in one.broken)
    kinds = sorted({(one.device, one.fault) for one in trials})
    rows = []
    for device, fault in kinds:
        of = [one for one in trials if (one.device, one.fault) == (device, fault)]
        ended = Counter(one.ended for one in of)
        views = [one.views for one in of if one.ended == "stopped"]
        kept = f"{min(views)} to {max(views)}" if views else "-"
        row: list[Cell] = [device, fault, len(of), ended["stopped"], ended["completed"]]
        rows.append([*row, max(one.seconds for one in of), kept, sum(bool(one.broken) for one in of)])
    columns = ("controller", "fault", "trials", "stopped", "completed", "longest [s]", "views kept", "broken promises")
    texts = [[f"{one.device} {one.fault} {one.moment}", "; ".join(one.broken)] for one in trials if one.broken]
    tables = [Table("Faults of emulated controllers", columns, rows, _NOTE)]
    if texts:
        tables.append(Table("Broken promises", ("trial", "what"), texts))
    measures = [
        Measure("fault trials", len(trials), 200, at_least=True),
        Measure("moves after a stop condition", _count(broken, "moved"), 0),
        Measure("lost or changed views", _count(broken, "lost", "changed", "an incomplete"), 0),
        Measure("hangs", _count(broken, "hang"), 0),
        Measure("unhandled exceptions", _count(broken, "exception"), 0),
        Measure("faults that were not named", _count(broken, "not named"), 0),
        Measure("captures that could not be completed afterwards", _count(broken, "not completed"), 0),
    ]
    return Report("Faults during a capture", _SETUP, tables, measures)


_SETUP = (
    "Every trial: an emulated UR or DENSO controller in one process, `cv-active-handeye capture --live` with the "
    "product's driver (ur_rtde as it is; the own b-CAP client) in another, five stops. A seeded fault sets in at a "
    "random moment. The controller's log judges whether anything moved after a stop condition; then a person clears "
    f"the fault, and `--resume` completes the data set. The emulators run {SPEEDUP:g} times as fast as an arm."
)
_NOTE = (
    "completed: the fault came after the last stop or does not hinder (a pose bias cannot be seen at the robot; one "
    "unreachable target more than the plan has). Deadline of a capture: "
    f"{DEADLINE_S:g} s."
)


def _count(broken: Counter[str], *words: str) -> int:
    return sum(number for text, number in broken.items() if text.startswith(words))


def measure(trials: int = TRIALS, workers: int = 2, first: int = 0) -> Report:
    """Runs the campaign; progress on standard error."""
    with tempfile.TemporaryDirectory() as temporary, ThreadPoolExecutor(workers) as pool:
        done = []
        for one in pool.map(lambda seed: trial(seed, Path(temporary) / str(seed)), range(first, first + trials)):
            done.append(one)
            state = "; ".join(one.broken) or "ok"
            print(f"{len(done)}/{trials} {one.device} {one.fault} {one.moment}: {one.ended}, {state}", file=sys.stderr)
    return report_of(done)


def main() -> int:
    """Command line."""
    arguments = parser(__doc__ or "")
    arguments.add_argument("--trials", type=int, default=TRIALS)
    arguments.add_argument("--workers", type=int, default=2)
    arguments.add_argument("--first", type=int, default=0, help="first seed")
    given = arguments.parse_args()
    return finish(measure(given.trials, given.workers, given.first), given.output)


if __name__ == "__main__":
    raise SystemExit(main())
