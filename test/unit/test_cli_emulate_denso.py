# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The command `emulate denso`: what it lists, refuses and becomes."""

from __future__ import annotations

import socket
from pathlib import Path

import pytest
from support.command_line import run
from support.denso_emulator import denso_process

from cv_active_handeye.robots.denso import connect
from cv_active_handeye.simulation.emulators.denso import DENSO_FAULTS

pytestmark = pytest.mark.timeout(60)


def test_list_faults_names_those_that_a_denso_controller_can_have() -> None:
    told = run("emulate", "denso", "--list-faults")
    assert told.exit_code == 0
    assert {line.split("=")[0] for line in told.output.splitlines() if "=" in line.split(" ")[0]} == DENSO_FAULTS


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--controller", "rc5"), "needs one of rc8, rc9, rc7, given rc5"),
        (("--host", "192.0.2.1"), "can be reached by others"),
        (("--fault", "register_conflict"), "given 'register_conflict'"),
        (("--fault", "fire"), "given 'fire'"),
    ],
)
def test_options_that_cannot_work_are_refused_by_name(options: tuple[str, ...], told: str) -> None:
    result = run("emulate", "denso", "--port", "0", "--control-port", "0", *options)
    assert result.exit_code == 2
    assert told in " ".join(result.output.replace("│", " ").split())


def test_port_that_is_taken_is_told() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        for options, service in ((("--port", port, "--control-port", "0"), "b-CAP"), (("--port", "0"), "control")):
            if service == "control":
                options = (*options, "--control-port", port)
            result = run("emulate", "denso", *options)
            assert result.exit_code == 2
            told = " ".join(result.output.replace("│", " ").split())
            option = options[options.index(port) - 1]
            assert f"Invalid value for {option}: 127.0.0.1: port {port} ({service}) is in use" in told
            assert f"end what listens there, or {option} 0 chooses a free one" in told


@pytest.mark.parametrize("controller", ["rc9", "rc7"])
def test_generation_of_the_option_is_the_one_that_a_client_meets(controller: str, tmp_path: Path) -> None:
    with denso_process(tmp_path, "--controller", controller, "--fault", "pose_bias=2") as running:
        options = {"controller": controller, "experimental_rc7": True, "model": "denso_vp6242"}
        with connect(running.config(**options), live=False) as robot:
            assert robot.name.startswith(f"DENSO {controller.upper()} at 127.0.0.1:")
            assert robot.pose().T_gripper2base.shape == (4, 4)
    assert [event["name"] for event in running.events() if event["kind"] == "fault"] == ["pose_bias"]
