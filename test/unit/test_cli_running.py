# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What `run` works on, and what it goes on with."""

from __future__ import annotations

from pathlib import Path

from cv_active_handeye.cameras.simulated import SimulatedCameraConfig
from cv_active_handeye.cli.running import planned
from cv_active_handeye.cli.station import station_of
from cv_active_handeye.plan_file import Plan, PlannedPose, PlannedStop
from cv_active_handeye.robots.registry import open_robot
from cv_active_handeye.robots.workspace import Box, Workspace
from cv_active_handeye.station import load_station


def test_resumed_run_keeps_to_the_workspace_of_its_plan(tmp_path: Path) -> None:
    """The simulated cell's own box is drawn around where the arm stands now."""
    station = load_station(None, {"robot": {"type": "sim"}, "camera": {"type": "sim"}})
    with open_robot(station.robot, live=False) as robot:
        T = robot.pose().T_gripper2base
        name, model = robot.name, robot.model
    pose = {"R_gripper2base": T[:3, :3].tolist(), "t_gripper2base": T[:3, 3].tolist()}
    plan = Plan(
        robot=name,
        model=model,
        start=PlannedPose.model_validate(pose),
        workspace=Workspace(box=Box(lower_mm=(0, -400, 50), upper_mm=(600, 400, 700)), max_step_mm=60),
        stops=(PlannedStop.model_validate({**pose, "group": 0}),),
    )
    plan.save(tmp_path / "plan.yaml")
    settings, again = planned(tmp_path, station, {}, resume=True)
    assert again.sha256() == plan.sha256()
    assert settings.workspace == plan.workspace


def test_simulated_camera_looks_at_the_emulator_that_the_host_names(tmp_path: Path) -> None:
    """Also where the robot's kind stands in the file."""
    (tmp_path / "station.yaml").write_text(
        "schema_version: 1\nrobot: {type: denso, host: 192.168.0.1}\ncamera: {type: opencv, source: 0}\n"
    )
    station = station_of(tmp_path / "station.yaml", None, "127.0.0.9", None, "sim", None, None)
    assert station.robot.model_dump()["host"] == "127.0.0.9"
    assert isinstance(station.camera, SimulatedCameraConfig)
    assert station.camera.host == "127.0.0.9"
