# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Pylon's camera emulator, unmodified, sees what the emulated arm's camera would see."""

from __future__ import annotations

import itertools
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from support.camera_emulation import basler_config
from support.command_line import run

from cv_active_handeye.cameras import basler
from cv_active_handeye.cameras.simulated import StopEye
from cv_active_handeye.dataset import Image
from cv_active_handeye.simulation import CellConfig, SimulatedCell
from cv_active_handeye.simulation.emulators import ArmState, ControlPort, EmulatedArm, EmulatorLink, EventLog
from cv_active_handeye.simulation.emulators.camera_feed import CameraFeed

pytestmark = pytest.mark.timeout(60)
CELL = CellConfig(robot="ur5e", seed=4, width=64, height=48, focal_px=141.0, texel_mm=1.0)
SCENE = SimulatedCell(CELL)
PIN = 3


@pytest.fixture
def arm() -> Iterator[EmulatedArm]:
    arm = EmulatedArm(CELL, speedup=100, log=EventLog())
    yield arm
    arm.close()


@pytest.fixture
def port(arm: EmulatedArm) -> Iterator[int]:
    control = ControlPort(arm, "127.0.0.1", 0, lambda: None)
    yield control.port
    control.close()


@pytest.fixture
def feed(port: int, tmp_path: Path) -> Iterator[CameraFeed]:
    link, end = EmulatorLink(port=port), threading.Event()
    feed = CameraFeed(link, SCENE, tmp_path, PIN)
    feed.begin()
    thread = threading.Thread(target=feed.run, args=(end,))
    thread.start()
    yield feed
    end.set()
    thread.join(5)
    link.close()


def wait_for(condition: Callable[[], bool], seconds: float = 20.0) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.001)


def step(arm: EmulatedArm, millimetres: float) -> None:
    target = arm.reported_pose()
    target[2, 3] += millimetres / 1000
    arm.move_linear(target, 0.25, 1.0, threading.Event())


def expected(arm: EmulatedArm) -> Image:
    """What a rendering of the present stop gives."""
    state = arm.state()
    off, on = SCENE.light(state.T_true, state.stop_index)
    assert on is not None
    return SCENE.expose(on if state.outputs[PIN] else off, state.stop_index, state.switchings)


def test_frame_of_pylon_is_the_rendering_of_the_stop_bit_by_bit(
    arm: EmulatedArm, feed: CameraFeed, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every stop with the laser off and on, grabbed as soon as the arm says that it is steady.

    Rendering takes its time, so that whoever does not wait for it sees the frame before.
    """
    render = StopEye.image

    def slow(self: StopEye, state: ArmState, count: int, *, laser_on: bool) -> Image:
        time.sleep(0.1)
        return render(self, state, count, laser_on=laser_on)

    monkeypatch.setattr(StopEye, "image", slow)
    seen: list[Image] = []
    with basler.connect(basler_config(tmp_path)) as camera:
        for millimetres in (4.0, -6.0, 3.0, 5.0):
            step(arm, millimetres)
            for on in (False, True):
                arm.set_output(PIN, on)
                wait_for(arm.steady)
                seen.append(camera.grab().image)
                np.testing.assert_array_equal(seen[-1], expected(arm))
            arm.set_output(PIN, False)
    assert all((a != b).any() for a, b in itertools.pairwise(seen))


def test_another_output_and_an_emulated_fault_are_followed_too(
    arm: EmulatedArm, feed: CameraFeed, tmp_path: Path
) -> None:
    with basler.connect(basler_config(tmp_path)) as camera:
        arm.set_output(PIN + 1, True)
        wait_for(arm.steady)
        np.testing.assert_array_equal(camera.grab().image, expected(arm))
        arm.faults.set("pose_bias", 5.0)
        wait_for(lambda: bool((camera.grab().image == expected(arm)).all()))


def test_feed_that_ends_lets_go_of_the_arm(arm: EmulatedArm, port: int, tmp_path: Path) -> None:
    with EmulatorLink(port=port) as link:
        feed = CameraFeed(link, SCENE, tmp_path, PIN)
        feed.begin()
        step(arm, 1.0)
        assert not arm.steady()
        end = threading.Event()
        end.set()
        feed.run(end)
        wait_for(arm.steady)


def test_command_follows_an_emulator_until_it_ends(arm: EmulatedArm, tmp_path: Path) -> None:
    control = ControlPort(arm, "127.0.0.1", 0, lambda: None)
    folder = tmp_path / "frames"
    arguments = ["emulate", "camera", "--control", f"127.0.0.1:{control.port}", "--folder", str(folder)]
    program = [
        sys.executable,
        "-c",
        "from cv_active_handeye.cli import app; app()",
        *arguments,
        "--laser-pin",
        str(PIN),
    ]
    with subprocess.Popen(program, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == "ready camera 64 x 48 mono8\n"
            arm.set_output(PIN, True)
            wait_for(arm.steady)
            with basler.connect(basler_config(folder)) as camera:
                np.testing.assert_array_equal(camera.grab().image, expected(arm))
            control.close()
            output = process.stdout.read()
            process.wait(10)
        finally:
            process.kill()
    assert process.returncode == 0
    assert "ImageFileMode: On" in output
    assert output.endswith("ended\n")


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("--control", "30020"), "needs HOST:PORT, given '30020'"),
        (("--control", "127.0.0.1:1"), "is `cv-active-handeye emulate` running?"),
    ],
)
def test_command_tells_what_is_wrong_with_its_control_port(arguments: tuple[str, ...], told: str) -> None:
    outcome = run("emulate", "camera", *arguments)
    assert outcome.exit_code == 2
    assert told in outcome.output


def test_command_wants_an_output_that_the_arm_has(port: int, tmp_path: Path) -> None:
    control = ("--control", f"127.0.0.1:{port}")
    outcome = run("emulate", "camera", *control, "--folder", tmp_path / "frames", "--laser-pin", "8")
    assert outcome.exit_code == 2
    assert "--laser-pin: needs one of [0, 1, 2, 3, 4, 5, 6, 7], given 8" in " ".join(outcome.output.split())


def test_command_wants_a_folder_of_its_own(port: int, tmp_path: Path) -> None:
    (tmp_path / "holiday.png").write_bytes(b"")
    outcome = run("emulate", "camera", "--control", f"127.0.0.1:{port}", "--folder", tmp_path)
    assert outcome.exit_code == 2
    assert "needs a folder of its own, found holiday.png" in outcome.output
