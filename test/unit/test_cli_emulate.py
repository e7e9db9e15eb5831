# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The command `emulate`: what it refuses, what it prints, and how it ends."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.command_line import run
from support.ur_emulator import UrEmulatorProcess

from cv_active_handeye.cli.console import Exit
from cv_active_handeye.simulation.emulators import FAULTS, read_events

pytestmark = pytest.mark.timeout(60)


def test_list_faults_names_all_with_their_default_values() -> None:
    result = run("emulate", "ur", "--list-faults")
    assert result.exit_code == Exit.USABLE
    for name, (value, _) in FAULTS.items():
        assert f"{name}={value:g}" in result.output


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--host", "192.168.1.20"], "can be reached by others"),
        (["--host", "robot"], "needs an address such as 127.0.0.1"),
        (["--version", "5.99"], "needs one of 3.15"),
        (["--fault", "earthquake"], "protective_stop"),
        (["--robot", "denso_vp6242"], "needs ur5e, given denso_vp6242"),
        (["--speedup", "0"], "0.1"),
    ],
)
def test_emulate_refuses_wrong_usage_and_names_it(arguments: list[str], message: str) -> None:
    result = run("emulate", "ur", *arguments)
    assert result.exit_code == Exit.USAGE
    assert message in " ".join(result.output.replace("│", " ").split())


def test_emulate_says_ready_tells_events_and_ends_on_two_signals_at_once(tmp_path: Path) -> None:
    with UrEmulatorProcess(tmp_path, 30, "--version", "10.11", "--fault", "pose_bias=2") as emulator:
        assert f"ready UR controller 10.11 on {emulator.host}, UR5e, control {emulator.host}:" in emulator.ready
        emulator.link.fault("protective_stop")
        output = emulator.end()
        assert "fault protective_stop 1" in output
        assert "STOP: protective stop" in output
        assert output.endswith("ended\n")
        assert emulator.process.returncode == 0
        assert [event["kind"] for event in read_events(emulator.log) if event["kind"] == "fault"] == ["fault"] * 2


def test_emulate_on_a_taken_address_says_so(tmp_path: Path) -> None:
    with UrEmulatorProcess(tmp_path, 31) as emulator:
        result = run("emulate", "ur", "--host", emulator.host)
        assert result.exit_code == Exit.USAGE
        told = " ".join(result.output.replace("│", " ").split())
        assert f"{emulator.host}: port 30004 (rtde) is in use, by another emulator perhaps" in told
        assert "give another --host, 127.0.0.2 for example" in told


def test_log_that_cannot_be_written_is_a_wrong_use(tmp_path: Path) -> None:
    result = run("emulate", "ur", "--log", str(tmp_path / "none" / "x.jsonl"))
    assert result.exit_code == Exit.USAGE
    told = " ".join(result.output.replace("│", " ").split())
    assert "Invalid value for --log" in told
    assert "cannot be written: No such file or directory" in told
