# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The hosted continuous integration calls what `.ci/run` calls, and holds no logic of its own."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

ROOT = Path(__file__).parents[2]
WORKFLOWS = sorted((ROOT / ".github/workflows").glob("*.yml"))
CIBUILDWHEEL = "pipx run cibuildwheel=={version} --output-dir build/wheel/dist"


JOBS: dict[str, dict[str, Any]] = {
    f"{workflow.stem}-{name}": job
    for workflow in WORKFLOWS
    for name, job in yaml.safe_load(workflow.read_text("utf-8"))["jobs"].items()
}


def commands(job: dict[str, Any]) -> list[str]:
    """The shell commands of a job, once for each value of matrix.target."""
    targets = job.get("strategy", {}).get("matrix", {}).get("target", [""])
    runs = [step["run"] for step in job["steps"] if "run" in step]
    return [run.replace("${{ matrix.target }}", target) for run in runs for target in targets]


def make_targets() -> set[str]:
    """What the Makefile says can be asked for."""
    makefile = (ROOT / "Makefile").read_text("utf-8").replace("\\\n", " ")
    phony = re.search(r"^\.PHONY: (.*)$", makefile, re.MULTILINE)
    assert phony
    return set(phony[1].split())


def test_workflows_keep_the_schema_of_the_service() -> None:
    assert [workflow.stem for workflow in WORKFLOWS] == ["ci", "extended", "wheels"]
    command = [sys.executable, "-m", "check_jsonschema", "--builtin-schema", "vendor.github-workflows"]
    done = subprocess.run([*command, *map(str, WORKFLOWS)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize("job", JOBS.values(), ids=JOBS)
def test_a_job_runs_targets_of_the_makefile_or_cibuildwheel(job: dict[str, Any]) -> None:
    assert commands(job)
    for command in commands(job):
        program, *arguments = shlex.split(command)
        if program == "make":
            targets = [argument for argument in arguments if "=" not in argument]
            assert targets
            assert set(targets) <= make_targets()
        else:
            version = re.search(r"cibuildwheel==([0-9.]+) ", command)
            assert version
            assert command == CIBUILDWHEEL.format(version=version[1])


@pytest.mark.parametrize("job", JOBS.values(), ids=JOBS)
def test_a_job_is_the_same_tomorrow(job: dict[str, Any]) -> None:
    runners = job["strategy"]["matrix"]["runner"] if "matrix.runner" in job["runs-on"] else [job["runs-on"]]
    assert not [runner for runner in runners if "latest" in runner]
    for step in job["steps"]:
        if "uses" in step:
            assert re.fullmatch(r"actions/[a-z-]+@(v\d+(\.\d+)*|[0-9a-f]{40})", step["uses"])
    assert job["timeout-minutes"] <= 120


@pytest.mark.parametrize("workflow", WORKFLOWS, ids=lambda path: path.stem)
def test_a_workflow_may_only_read(workflow: Path) -> None:
    assert yaml.safe_load(workflow.read_text("utf-8"))["permissions"] == {"contents": "read"}


def test_everything_that_the_local_run_calls_runs_on_the_service_too() -> None:
    script = (ROOT / ".ci/run").read_text("utf-8")
    calls = re.findall(r"^\s*make (.*)$", script, re.MULTILINE)
    local = {word for call in calls for word in call.split() if not word.startswith("--")}
    assert {"test", "lint", "sanitize"} <= local
    assert local <= {word for job in JOBS.values() for command in commands(job) for word in shlex.split(command)}


def test_wheels_are_built_for_all_pythons_of_the_project() -> None:
    pyproject = (ROOT / "pyproject.toml").read_text("utf-8")
    oldest = re.search(r'requires-python = ">=3\.(\d+)"', pyproject)
    built = re.search(r'^build = "([^"]*)"$', pyproject, re.MULTILINE)
    assert oldest
    assert built
    minors = [int(minor) for minor in re.findall(r"cp3(\d+)-", built[1])]
    assert minors == list(range(int(oldest[1]), max(minors) + 1))
    (pythons,) = re.findall(r'PYTHONS="([^"]*)"', (ROOT / ".github/workflows/ci.yml").read_text("utf-8"))
    assert pythons.split() == [f"python3.{minor}" for minor in minors]
