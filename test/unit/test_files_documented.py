# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The keys of the files as the pages name them, and as the models take them."""

from __future__ import annotations

import re
from pathlib import Path
from typing import get_args

import pytest
from pydantic import BaseModel

from cv_active_handeye.cameras.laser_switch import LaserSwitchConfig
from cv_active_handeye.cameras.registry import CameraConfig
from cv_active_handeye.config import CalibrationOptions
from cv_active_handeye.dataset_format import Content, View
from cv_active_handeye.plan_file import Plan, PlannedStop, Prediction
from cv_active_handeye.robots.base import Speed
from cv_active_handeye.robots.denso_config import DensoConfig
from cv_active_handeye.robots.recorded import RecordedConfig
from cv_active_handeye.robots.registry import RobotConfig
from cv_active_handeye.robots.simulated import SimulatedRobotConfig
from cv_active_handeye.robots.ur import UrConfig
from cv_active_handeye.robots.workspace import Box, Workspace
from cv_active_handeye.station import StationConfig, load_station
from cv_active_handeye.workflow.capture import CaptureSettings
from cv_active_handeye.workflow.plan_settings import PlanSettings
from cv_active_handeye.workflow.settle import SettleSettings

ROOT = Path(__file__).parents[2]
ROBOTS: dict[str, type[BaseModel]] = {
    "ur": UrConfig,
    "denso": DensoConfig,
    "sim": SimulatedRobotConfig,
    "recorded": RecordedConfig,
}
MODELS: dict[str, type[BaseModel]] = {
    "key of dataset.yaml": Content,
    "key of a view": View,
    "key of station.yaml": StationConfig,
    **{f"key of a robot of type `{name}`": model for name, model in ROBOTS.items()},
    "key of `speed`": Speed,
    "key of `capture`": CaptureSettings,
    "key of `settle`": SettleSettings,
    "key of `planning`": PlanSettings,
    "key of `workspace`": Workspace,
    "key of `box`": Box,
    "key of `calibration`": CalibrationOptions,
    "key of plan.yaml": Plan,
    "key of a stop": PlannedStop,
    "key of a prediction": Prediction,
}
ADDED = {"key of plan.yaml": {"sha256"}}


def first_column(head: str) -> set[str]:
    """The names in code font in the first column of the table of doc/files.md with this head."""
    lines = (ROOT / "doc/files.md").read_text(encoding="utf-8").splitlines()
    begin = next(i for i, line in enumerate(lines) if line.startswith(f"| {head} |")) + 2
    names: set[str] = set()
    for line in lines[begin:]:
        if not line.startswith("|"):
            break
        names.update(re.findall(r"`([^`]+)`", line.split("|")[1]))
    return names


@pytest.mark.parametrize("head", list(MODELS))
def test_page_names_the_keys_that_the_model_takes(head: str) -> None:
    assert first_column(head) == set(MODELS[head].model_fields) | ADDED.get(head, set())


def test_every_robot_has_a_table() -> None:
    assert set(ROBOTS.values()) == set(get_args(get_args(RobotConfig)[0]))


@pytest.mark.parametrize("union", [CameraConfig, LaserSwitchConfig], ids=["cameras", "lasers"])
def test_page_of_cameras_names_every_key(union: object) -> None:
    named = set(re.findall(r"`(\w+)`", (ROOT / "doc/hardware/cameras.md").read_text(encoding="utf-8")))
    for model in get_args(get_args(union)[0]):
        assert set(model.model_fields) - named == set(), model.__name__


def test_page_names_the_events_that_the_code_logs() -> None:
    sources = [*(ROOT / "python/cv_active_handeye/workflow").glob("*.py")]
    sources.append(ROOT / "python/cv_active_handeye/robots/guard.py")
    pattern = re.compile(r"(?:\blog|self\._log|self\._event)\(\"(\w+)\"")
    logged = {name for path in sources for name in pattern.findall(path.read_text(encoding="utf-8"))}
    assert first_column("event") == logged


def test_station_files_of_the_tutorial_are_accepted(tmp_path: Path) -> None:
    page = (ROOT / "doc/tutorials/first_calibration.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```yaml station.yaml\n(.*?)```", page, re.DOTALL)
    stations = []
    for block in blocks:
        (tmp_path / "station.yaml").write_text(block, encoding="utf-8")
        stations.append(load_station(tmp_path / "station.yaml", {}))
    assert [station.robot.type for station in stations] == ["ur", "denso"]
    assert all(station.planning is not None for station in stations)
