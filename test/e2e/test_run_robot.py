# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""`plan`, `capture` and `run` as a user calls them, against an emulated UR controller in another process."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import yaml
from support.ur_emulator import UrEmulatorProcess

from cv_active_handeye.calibration import Calibration
from cv_active_handeye.dataset import Dataset
from cv_active_handeye.plan_file import Plan
from cv_active_handeye.report import calibration_errors, inside_intervals
from cv_active_handeye.simulation import SimulatedCell
from cv_active_handeye.simulation.emulators import moves_after_stop
from cv_active_handeye.workflow.event_log import read_events as captured

pytestmark = pytest.mark.timeout(280)
PROGRAM = [sys.executable, "-c", "import sys; from cv_active_handeye.cli import app; sys.exit(app())"]


@pytest.fixture(scope="module")
def emulator(tmp_path_factory: pytest.TempPathFactory) -> Iterator[UrEmulatorProcess]:
    with UrEmulatorProcess(tmp_path_factory.mktemp("run"), 7, "--speedup", "10") as process:
        yield process


def call(*arguments: str | Path, said: str = "") -> subprocess.CompletedProcess[str]:
    command = [*PROGRAM, *(str(argument) for argument in arguments)]
    return subprocess.run(
        command,
        input=said,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=240,
        env={**os.environ, "COLUMNS": "300"},
    )


@pytest.fixture(scope="module")
def station(emulator: UrEmulatorProcess, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A busy machine's: its clock may stand a little longer before the arm is stopped."""
    file = tmp_path_factory.mktemp("station") / "station.yaml"
    content = {
        "schema_version": 1,
        "robot": {"type": "ur", "host": emulator.host, "freshness_s": 1.0, "watchdog_s": 5.0},
        "camera": {"type": "sim", "host": emulator.host, "port": int(emulator.ready.rsplit(":", 1)[1])},
        "laser": {"type": "camera_line", "settle_s": 0.0},
        "capture": {"settle": {"dwell_s": 0.05}},
        "calibration": {"lens_model": "none"},
    }
    file.write_text(yaml.safe_dump(content))
    return file


def test_nothing_moves_without_live_nor_without_the_word(
    emulator: UrEmulatorProcess, station: Path, tmp_path: Path
) -> None:
    emulator.begin()
    looked = call("run", tmp_path / "look", "--station", station, "--stops", "10")
    assert looked.returncode == 0, looked.stdout
    assert "Nothing was moved" in looked.stdout
    assert len(Plan.load(tmp_path / "look" / "plan.yaml").stops) == 10
    plan = tmp_path / "look" / "plan.yaml"
    refused = call("capture", tmp_path / "set", "--plan", plan, "--station", station, "--live", said="yes\n")
    assert refused.returncode == 6
    assert "nothing was moved: the answer was 'yes', needed \"move\"" in refused.stdout
    assert not (tmp_path / "set").exists()
    kinds = {event["kind"] for event in emulator.events()}
    assert "motion_begin" not in kinds
    assert not [name for name in emulator.commands() if name in ("moveL", "moveJ", "setTcp")]


def test_run_calibrates_the_emulated_robot_as_well_as_it_says(
    emulator: UrEmulatorProcess, station: Path, tmp_path: Path
) -> None:
    emulator.begin()
    done = call("run", tmp_path / "run", "--station", station, "--stops", "12", "--live", said="move\n")
    assert done.returncode == 0, done.stdout
    folder = tmp_path / "run"
    calibration, truth = Calibration.load(folder / "calibration.yaml"), SimulatedCell(emulator.link.cell()).truth
    errors, inside = calibration_errors(calibration, truth), inside_intervals(calibration, truth)
    assert errors.rotation_deg < 0.03
    assert errors.translation_mm < 0.3
    assert np.mean(list(inside.values())) > 0.6
    assert len(Dataset.open(folder / "dataset")) == 12
    assert Dataset.open(folder / "dataset").problems() == []
    assert len(Dataset.open(folder / "check")) >= 3
    assert "Valid:" in done.stdout
    kinds = [event["event"] for event in captured(folder / "events.jsonl")]
    assert "plan" in kinds  # the rest was chosen anew from what had been seen
    assert kinds.count("stored") == 12 + len(Dataset.open(folder / "check"))
    assert (folder / "report.html").stat().st_size > 10_000
    events = emulator.events()
    assert moves_after_stop(events) == []
    assert [event for event in events if event["kind"] == "violation"] == []
