# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The C++ sample ur_live on the unmodified ur_rtde against the emulated controller; `make ur-sample` builds it."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from support.ur_emulator import UrEmulatorProcess

from cv_active_handeye.simulation.emulators import moves_after_stop

PROGRAM = Path(__file__).parents[2] / "build/ur_sample/bin/ur_live"
TOOL = [0.0, 0.0, 0.1, 0.0, 0.0, 0.0]
pytestmark = [
    pytest.mark.timeout(120),
    pytest.mark.skipif(not PROGRAM.exists(), reason=f"{PROGRAM}: `make ur-sample` builds it"),
]


@pytest.fixture(scope="module")
def emulator(tmp_path_factory: pytest.TempPathFactory) -> Iterator[UrEmulatorProcess]:
    with UrEmulatorProcess(tmp_path_factory.mktemp("ur"), 7, "--speedup", "4") as process:
        yield process


def sample(emulator: UrEmulatorProcess, *options: str, typed: str = "") -> subprocess.CompletedProcess[str]:
    command = [str(PROGRAM), emulator.host, *options]
    return subprocess.run(command, input=typed, capture_output=True, text=True, timeout=90)


def positions(printed: str, name: str) -> NDArray[np.float64]:
    """x, y, z [mm] of the lines that begin with `name`."""
    return np.array([line.split()[1:4] for line in printed.splitlines() if line.startswith(name)], np.float64)


def test_without_live_it_prints_the_tool_and_starts_no_program(emulator: UrEmulatorProcess) -> None:
    emulator.begin()
    done = sample(emulator)
    flange = emulator.link.state().T_reported
    assert done.returncode == 0, done.stderr
    np.testing.assert_allclose(positions(done.stdout, "tool")[0], 1000 * (flange @ [0, 0, 0.1, 1])[:3], atol=6e-4)
    assert "Nothing was moved" in done.stdout
    assert {"setTcp", "moveL"}.isdisjoint(emulator.commands())


@pytest.mark.parametrize("typed", ["yes\n", ""])
def test_without_the_typed_word_nothing_moves(typed: str, emulator: UrEmulatorProcess) -> None:
    emulator.begin()
    done = sample(emulator, "--live", typed=typed)
    assert (done.returncode, "Nothing was moved" in done.stdout) == (1, True)
    assert {"setTcp", "moveL"}.isdisjoint(emulator.commands())


def test_live_it_moves_along_the_flanges_axes_and_restores_the_tool(emulator: UrEmulatorProcess) -> None:
    emulator.begin()
    start = emulator.link.state().T_reported
    done = sample(emulator, "--live", typed="move\n")
    assert done.returncode == 0, done.stderr
    R, t = start[:3, :3], start[:3, 3]
    expected = 1000 * np.array([t + 0.02 * R[:, 0], t + 0.02 * R[:, 1], t - 0.02 * R[:, 2], t])
    np.testing.assert_allclose(positions(done.stdout, "reached"), expected, atol=0.1)
    tools = [event["args"] for event in emulator.events() if event["kind"] == "command" and event["name"] == "setTcp"]
    assert (tools[0], tools[-1]) == ([0.0] * 6, TOOL)
    assert [event for event in emulator.events() if event["kind"] == "violation"] == []


def test_protective_stop_in_a_move_ends_the_program_and_is_told(emulator: UrEmulatorProcess) -> None:
    emulator.begin()
    emulator.link.plan_fault(f"protective_stop@move{emulator.link.state().stop_index + 2}")
    done = sample(emulator, "--live", typed="move\n")
    assert done.returncode == 4
    assert re.search(r"error: .*(protective stop|see the pendant)", done.stderr), done.stderr
    assert len(positions(done.stdout, "reached")) == 1
    assert moves_after_stop(emulator.events()) == []
