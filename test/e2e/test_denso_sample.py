# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The C++ sample denso_live against the emulated controller: it reads, refuses, moves when told to, and halts."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from support.denso_emulator import Running, denso_process, moved
from support.direct_calls import BUILD

from cv_active_handeye.plan_file import Plan, PlannedPose, PlannedStop
from cv_active_handeye.robots.workspace import Box, Workspace
from cv_active_handeye.simulation.emulators import moves_after_stop

PROGRAM = BUILD / "bin/denso_live"
pytestmark = [
    pytest.mark.timeout(60),
    pytest.mark.skipif(not PROGRAM.exists(), reason=f"{PROGRAM}: `make test-cpp` builds it where yaml-cpp is"),
]


@pytest.fixture(scope="module")
def emulated(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    with denso_process(tmp_path_factory.mktemp("emulator"), "--speedup", "20") as running:
        yield running


def sample(emulated: Running, *arguments: str | Path, typed: str = "") -> subprocess.CompletedProcess[str]:
    command = [str(PROGRAM), f"127.0.0.1:{emulated.port}", *map(str, arguments)]
    return subprocess.run(command, input=typed, capture_output=True, text=True, timeout=40)


def plan_file(folder: Path, start: NDArray[np.float64], *stops: NDArray[np.float64]) -> Path:
    def planned(pose: NDArray[np.float64]) -> dict[str, list[object]]:
        return {"R_gripper2base": pose[:3, :3].tolist(), "t_gripper2base": pose[:3, 3].tolist()}

    plan = Plan(
        robot="sample",
        model=None,
        start=PlannedPose.model_validate(planned(start)),
        workspace=Workspace(box=Box(lower_mm=(100, -200, 100), upper_mm=(400, 300, 400))),
        stops=tuple(PlannedStop.model_validate({**planned(stop), "group": 0}) for stop in stops),
    )
    plan.save(folder / "plan.yaml")
    return folder / "plan.yaml"


def numbers(text: str) -> list[float]:
    return [float(number) for number in re.findall(r"-?\d+\.\d+", text)]


def test_without_a_plan_it_prints_where_the_flange_is(emulated: Running) -> None:
    done = sample(emulated)
    pose = emulated.link.state().T_reported
    assert done.returncode == 0, done.stderr
    expected = [*(1000 * pose[:3, 3]), *pose[:3, 1], *pose[:3, 2]]
    np.testing.assert_allclose(numbers(done.stdout), expected, atol=6e-4)


@pytest.mark.parametrize(("options", "typed"), [((), ""), (("--live",), "yes\n"), (("--live",), "")])
def test_without_live_and_the_typed_word_nothing_moves(
    options: tuple[str, ...], typed: str, emulated: Running, tmp_path: Path
) -> None:
    before = emulated.link.state()
    plan = plan_file(tmp_path, before.T_reported, moved(before.T_reported, (10, 0, 0)))
    done = sample(emulated, plan, *options, typed=typed)
    assert "stop 1" in done.stdout
    assert "Nothing was moved" in done.stdout
    assert emulated.link.state().stop_index == before.stop_index
    assert [event for event in emulated.events() if event.get("name") in ("TakeArm", "Motor")] == []


@pytest.mark.parametrize(
    ("mm", "told"), [((0, 120, 0), "more than 100 mm"), ((0, 0, -200), "outside of the plan's box")]
)
def test_plan_beyond_its_box_or_the_longest_step_is_refused(
    mm: tuple[float, float, float], told: str, emulated: Running, tmp_path: Path
) -> None:
    start = emulated.link.state().T_reported
    done = sample(emulated, plan_file(tmp_path, start, moved(start, mm)), "--live", typed="move\n")
    assert (done.returncode, told in done.stderr) == (4, True), done.stderr


def test_live_it_makes_the_moves_and_leaves_the_controller_as_it_was(emulated: Running, tmp_path: Path) -> None:
    start = emulated.link.state().T_reported
    stops = [moved(start, (10, 0, 0)), moved(start, (10, 5, 0), (0, 4, 0))]
    done = sample(emulated, plan_file(tmp_path, start, *stops), "--live", typed="move\n")
    assert done.returncode == 0, done.stderr
    reached = [numbers(line) for line in re.findall(r"reached .*", done.stdout)]
    for values, stop in zip(reached, stops, strict=True):
        np.testing.assert_allclose(values[:3], 1000 * stop[:3, 3], atol=0.05)
        np.testing.assert_allclose(values[3:], [*stop[:3, 1], *stop[:3, 2]], atol=2e-4)
    assert [event for event in emulated.events() if event["kind"] == "violation"] == []
    names = [event["name"] for event in emulated.events() if event["kind"] == "command"]
    assert names[-2:] == ["Motor", "GiveArm"]


def test_fault_in_a_move_is_told_and_ends_the_program(emulated: Running, tmp_path: Path) -> None:
    start = emulated.link.state().T_reported
    emulated.link.plan_fault(f"protective_stop@move{emulated.link.state().stop_index + 1}")
    stops = [moved(start, (0, 20, 0)), start]
    done = sample(emulated, plan_file(tmp_path, start, *stops), "--live", typed="move\n")
    assert done.returncode == 4
    assert "error: " in done.stderr
    assert "reached" not in done.stdout
    assert moves_after_stop(emulated.events()) == []
    emulated.link.clear()


def test_nobody_listening_is_told(tmp_path: Path) -> None:
    done = subprocess.run([PROGRAM, "127.0.0.1:1"], capture_output=True, text=True, timeout=20)
    assert (done.returncode, "cannot be reached" in done.stderr) == (4, True)
