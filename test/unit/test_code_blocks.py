# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Every block of code of every page: executed, or at least understood by the program that it is for.

CI_EXTENDED=1 also executes doc/start.md as a newcomer types it, which takes some minutes.
"""

from __future__ import annotations

import contextlib
import importlib.util
import io
import itertools
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation
from support import code_blocks
from support.code_blocks import ROOT, Block
from support.command_line import run
from support.exact_recording import exact_recording
from support.groove_recording import groove_dataset
from support.recordings import noisy_dataset
from support.stripe_recording import calibration_of_truth
from typer.main import get_command

from benchmark.__main__ import NAMES as BENCHMARKS
from cv_active_handeye.calibration import Calibration
from cv_active_handeye.cli.commands import app
from cv_active_handeye.plan_file import Plan
from cv_active_handeye.station import load_station
from cv_active_handeye.workflow.plan_settings import PlanSettings

KINDS = {"sh", "python", "cpp", "yaml", "text"}
DIRECTIVES = {"{toctree}", "{eval-rst}", "{doxygengroup}"}
"""Of doc/site, which the site executes."""


def name_of(block: Block) -> str:
    return f"{block.page}:{block.line}"


def blocks(*kinds: str) -> pytest.MarkDecorator:
    return pytest.mark.parametrize("block", code_blocks.blocks(*kinds), ids=name_of)


@blocks()
def test_block_says_what_it_is(block: Block) -> None:
    allowed = KINDS | (DIRECTIVES if block.page.startswith("doc/site/") else set())
    assert block.kind in allowed, f"{name_of(block)}: of the kind {block.kind!r}; known: {sorted(allowed)}"


# --- shell -----------------------------------------------------------------------------------------------------------


def understand_own_command(words: list[str]) -> None:
    """The parser of the command line takes the words; nothing runs."""
    command, context = get_command(app), None
    while words[1:] != ["--help"]:
        context = command.make_context(words[0], words[1:], parent=context)
        if not hasattr(command, "resolve_command"):
            return
        rest = [*getattr(context, "_protected_args", []), *context.args]
        _, command, arguments = command.resolve_command(context, rest)
        words = [command.name, *arguments]


def understand_make(words: list[str]) -> None:
    rules = re.findall(r"^([\w -]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    assert set(words[1:]) <= {target for rule in rules for target in rule.split()}


def understand_pip(words: list[str]) -> None:
    pyproject = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    for package in words[2:]:
        asked = re.fullmatch(r"(?:cv_active_handeye|\.)(?:\[(.*)\])?", package)
        assert asked, f"{package} is not ours"
        for extra in filter(None, (asked[1] or "").split(",")):
            assert re.search(rf"^{extra} = \[", pyproject, re.MULTILINE), f"no extra {extra}"


def understand_python(words: list[str]) -> None:
    if words[1] != "-m":
        assert (ROOT / words[1]).is_file()
        return
    assert importlib.util.find_spec(words[2]) is not None
    if words[2] == "benchmark":
        assert {word for word in words[3:] if re.fullmatch(r"[a-z]\w*", word)} <= {*BENCHMARKS, "8"}


def understand_cmake(words: list[str]) -> None:
    files = "".join(
        path.read_text(encoding="utf-8") for path in (ROOT / "CMakeLists.txt", ROOT / "samples/cpp/CMakeLists.txt")
    )
    presets = {
        preset["name"] for preset in json.loads((ROOT / "CMakePresets.json").read_text("utf-8"))["configurePresets"]
    }
    for before, word in itertools.pairwise(words):
        option = re.fullmatch(r"-D(ACTIVE_HANDEYE_\w+)=\w+", word)
        assert not option or option[1] in files
        assert before != "--preset" or word in presets
        assert before != "--target" or word in files


def understand_sample(words: list[str]) -> None:
    name = Path(words[0]).name
    assert (ROOT / f"samples/cpp/{name}.cpp").is_file()


def nothing_to_understand(words: list[str]) -> None:
    """A command of the system."""


PROGRAMS: dict[str, Callable[[list[str]], None]] = {
    r"(\.venv/bin/)?cv-active-handeye": understand_own_command,
    r"make": understand_make,
    r"(\.venv/bin/)?pip": understand_pip,
    r"(\.venv/bin/)?python": understand_python,
    r"cmake|ctest": understand_cmake,
    r"build/samples/bin/\w+": understand_sample,
    r"\.ci/run|\.venv/bin/pre-commit|\.|cd|git": nothing_to_understand,
}


def understand(words: list[str]) -> None:
    while re.fullmatch(r"[A-Z_]+=\S*", words[0]):
        words = words[1:]
    words = [word for word in words if word != "&"]
    checks = [check for pattern, check in PROGRAMS.items() if re.fullmatch(pattern, words[0])]
    assert checks, f"no program {words[0]} is known here"
    checks[0](words)


@blocks("sh")
def test_shell_block_is_understood(block: Block) -> None:
    found = code_blocks.commands(block)
    assert found
    for command in found:
        understand(command.words)


def test_misspelt_commands_are_not_understood() -> None:
    for line in (
        "cv-active-handeye calibrat DATASET",
        "cv-active-handeye calibrate DATASET --no-such-option",
        "cv-active-handeye calibrate",
        "cv-active-handeye verify DATASET --calibration",
        "cv-active-handeye emulate denso --speedup fast",
        "make demos",
        "pip install 'cv_active_handeye[every]'",
        "python samples/python/99_none.py",
        "python -m benchmark foes",
        "cmake --preset none",
        "build/samples/bin/none",
        "frobnicate",
    ):
        (command,) = code_blocks.commands(Block("", 1, "sh", "", line))
        with pytest.raises((AssertionError, Exception)) as caught:
            understand(command.words)
        assert not isinstance(caught.value, (NameError, AttributeError, KeyError)), line


# --- shell, executed -------------------------------------------------------------------------------------------------


def data_of_the_readme() -> None:
    """Small data sets under the names that the page uses."""
    noisy_dataset(Path("DATASET"))
    noisy_dataset(Path("NEW_VIEWS"), seed=8, views=range(5))
    groove_dataset(Path("SCAN"), (-0.01, 0.0, 0.01))
    pixel = exact_recording().stripePoints[0][20]
    Path("points.csv").write_text(f"name,view,u,v\nP,0,{pixel[0]:.3f},{pixel[1]:.3f}\n")


def with_light_plane() -> None:
    """The calibration of DATASET was made without a laser; what follows measures with one."""
    calibration_of_truth().save("calibration.yaml")


def data_of_the_tutorial() -> None:
    Path("out/first").mkdir(parents=True)
    calibration_of_truth().save("out/first/calibration.yaml")
    noisy_dataset(Path("out/week2"), seed=8, views=range(5))


EXECUTED: dict[str, tuple[Callable[[], None], set[str]]] = {
    "README.md": (data_of_the_readme, {"calibrate", "verify", "scan", "seam", "--help"}),
    "doc/tutorials/first_calibration.md": (data_of_the_tutorial, {"verify", "export"}),
}
"""What is prepared for a page, and which of its commands are executed; others need a robot, a board or minutes."""


@pytest.mark.parametrize("page", list(EXECUTED))
def test_commands_of_the_page_do_what_it_says(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    prepare, names = EXECUTED[page]
    monkeypatch.chdir(tmp_path)
    prepare()
    executed = set()
    for command in (c for b in code_blocks.blocks("sh") if b.page == page for c in code_blocks.commands(b)):
        if command.words[0] == "cv-active-handeye" and command.words[1] in names:
            if "cloud.ply" in command.words:
                with_light_plane()
            outcome = run(*command.words[1:])
            assert outcome.exit_code == command.status, f"{command.words}\n{outcome.output}"
            executed.add(command.words[1])
    assert executed == names


def without_numbers(text: str) -> str:
    """The words, whatever the width of the terminal and the last digits."""
    return " ".join(re.sub(r"\d+(?:\.\d+)?", "#", text).split())


@pytest.mark.skipif(os.environ.get("CI_EXTENDED") != "1", reason="takes minutes; CI_EXTENDED=1")
@pytest.mark.timeout(1200)
def test_newcomer_types_the_first_page_in_an_empty_folder(tmp_path: Path) -> None:
    page = code_blocks.blocks_of(ROOT / "doc/start.md")
    program = Path(sys.executable).with_name("cv-active-handeye")
    for command in (c for block in page if block.kind == "sh" for c in code_blocks.commands(block)):
        if command.words[0] == "cv-active-handeye":
            done = subprocess.run([program, *command.words[1:]], cwd=tmp_path, capture_output=True, text=True)
            assert done.returncode == command.status, f"{command.words}\n{done.stdout}{done.stderr}"
            if command.words[1] == "demo":
                shown = [without_numbers(block.text) for block in page if block.kind == "text"]
                assert shown
                assert all(text in without_numbers(done.stdout) for text in shown)
    files = re.findall(r"^\| `(\w[\w./]*)`(?:, `([\w.]+)`)*", (ROOT / "doc/start.md").read_text("utf-8"), re.MULTILINE)
    assert all((tmp_path / "out/demo" / name).exists() for names in files for name in names if name)
    assert Calibration.load(tmp_path / "out/calibration.yaml").verdict


# --- Python ----------------------------------------------------------------------------------------------------------


def recorded_arrays() -> dict[str, Any]:
    """Poses and image points under the names that the pages use, with a little noise."""
    recording, rng = exact_recording(), np.random.default_rng(4)
    points = recording.imagePoints + 0.05 * rng.normal(size=recording.imagePoints.shape)
    turned = [recording.R_cam2gripper.T @ R.T for R in recording.R_gripper2base]  # the target's frame is the base
    shifts = [
        -R @ t - recording.R_cam2gripper.T @ recording.t_cam2gripper + 1e-4 * rng.normal(size=3)
        for R, t in zip(turned, recording.t_gripper2base, strict=True)
    ]
    return {
        "R_target2cam": [R @ Rotation.from_rotvec(1e-4 * rng.normal(size=3)).as_matrix() for R in turned],
        "t_target2cam": shifts,
        "R_gripper2base": recording.R_gripper2base,
        "t_gripper2base": recording.t_gripper2base,
        "imagePoints": points,
    }


PYTHON_PAGES = sorted({block.page for block in code_blocks.blocks("python")})


@pytest.mark.parametrize("page", PYTHON_PAGES)
def test_python_blocks_of_the_page_run_in_their_order(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("out").mkdir()
    calibration_of_truth().save("out/calibration.yaml")
    names = recorded_arrays()
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        for block in code_blocks.blocks_of(ROOT / page):
            if block.kind == "python":
                exec(compile("\n" * block.line + block.text, str(ROOT / page), "exec"), names)
    assert printed.getvalue().strip()


# --- C++ and files ---------------------------------------------------------------------------------------------------


def test_cpp_blocks_compile(tmp_path: Path) -> None:
    compiler = shutil.which("c++")
    found = code_blocks.blocks("cpp")
    if compiler is None or not found:
        pytest.skip("no compiler" if compiler is None else "no page has a block of C++")
    source = tmp_path / "blocks.cpp"
    source.write_text("".join(f'#line {b.line + 1} "{b.page}"\n{b.text}\n' for b in found))
    headers = [f"-I{folder}" for folder in (ROOT / "modules/active_handeye/include", *OPENCV_FOLDERS)]
    subprocess.run([compiler, "-std=c++11", "-fsyntax-only", *headers, source], check=True)


OPENCV_FOLDERS = [folder for folder in map(Path, ("/usr/include/opencv4", "/usr/include/opencv5")) if folder.is_dir()]


def load_plan(path: Path) -> None:
    Plan.load(path)


def load_settings(path: Path) -> None:
    PlanSettings.model_validate(yaml.safe_load(path.read_text(encoding="utf-8")))


def load_station_file(path: Path) -> None:
    assert load_station(path, {}).robot is not None


LOADERS: dict[str, Callable[[Path], None]] = {
    "station.yaml": load_station_file,
    "settings.yaml": load_settings,
    "plan.yaml": load_plan,
}


@blocks("yaml")
def test_file_of_the_page_is_accepted(block: Block, tmp_path: Path) -> None:
    assert block.name in LOADERS, f"{name_of(block)}: which file is it? Known: {sorted(LOADERS)}"
    path = tmp_path / block.name
    path.write_text(block.text, encoding="utf-8")
    LOADERS[block.name](path)
