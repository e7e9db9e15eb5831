# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The command where the extras are not installed."""

from __future__ import annotations

import subprocess
import sys

HIDE = "import sys; sys.modules[{name!r}] = None; sys.argv = {argv!r}; from cv_active_handeye.cli import app; app()"


def run_without(module: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """The command in an interpreter where `import module` fails."""
    code = HIDE.format(name=module, argv=["cv-active-handeye", *arguments])
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)


def test_command_without_the_extra_workflow_names_it_and_exits_2() -> None:
    result = run_without("typer", "--help")
    assert result.returncode == 2
    assert result.stderr == "cv-active-handeye needs typer; pip install 'cv_active_handeye[workflow,sim]'\n"


def test_simulate_without_the_extra_sim_names_it_and_exits_2(tmp_path: object) -> None:
    result = run_without("trimesh", "simulate", f"{tmp_path}/set")
    assert result.returncode == 2
    assert "trimesh" in result.stderr
    assert "pip install 'cv_active_handeye[workflow,sim]'" in " ".join(result.stderr.split())
    assert "Traceback" not in result.stderr


def test_calibrate_does_not_need_the_extra_sim() -> None:
    result = run_without("trimesh", "calibrate", "/nowhere")
    assert result.returncode == 4
    assert "is not a data set" in result.stderr
