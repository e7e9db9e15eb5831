# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The simulated camera, on an arm in this process and through the control port of an emulator."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from cv_active_handeye.cameras.base import Camera, CameraError
from cv_active_handeye.cameras.registry import open_camera
from cv_active_handeye.cameras.simulated import SimulatedCamera, SimulatedCameraConfig
from cv_active_handeye.dataset import Image
from cv_active_handeye.simulation import CellConfig, SimulatedCell
from cv_active_handeye.simulation.emulators import ControlPort, EmulatedArm, EventLog

pytestmark = pytest.mark.timeout(60)
CELL = CellConfig(robot="ur5e", seed=4, width=64, height=48, focal_px=141.0, texel_mm=1.0)
SCENE = SimulatedCell(CELL)  # built when it is first looked at, once for all tests


@pytest.fixture
def arm() -> Iterator[EmulatedArm]:
    arm = EmulatedArm(CELL, speedup=20, log=EventLog())
    yield arm
    arm.close()


@pytest.fixture
def port(arm: EmulatedArm) -> Iterator[int]:
    control = ControlPort(arm, "127.0.0.1", 0, lambda: None)
    yield control.port
    control.close()


def step(arm: EmulatedArm, metres: float = 0.02) -> None:
    target = arm.reported_pose()
    target[0, 3] += metres
    arm.move_linear(target, 0.25, 1.0, threading.Event())


def expected(arm: EmulatedArm, count: int, laser: bool) -> Image:
    """What a rendering of the present stop gives."""
    off, on = SCENE.light(arm.true_pose(), arm.stop_index)
    assert on is not None
    return SCENE.expose(on if laser else off, arm.stop_index, count)


def test_frames_show_the_true_pose_with_noise_of_their_own(arm: EmulatedArm) -> None:
    with SimulatedCamera(SCENE, arm.state) as camera:
        assert isinstance(camera, Camera)
        assert (camera.info.width, camera.info.height, camera.info.pixel_format) == (64, 48, "mono8")
        for count in range(2):
            np.testing.assert_array_equal(camera.grab().image, expected(arm, count, False))
        step(arm)
        np.testing.assert_array_equal(camera.grab().image, expected(arm, 0, False))
        camera.set_line(True)
        np.testing.assert_array_equal(camera.grab().image, expected(arm, 1, True))
        camera.set_line(False)
        np.testing.assert_array_equal(camera.grab().image, expected(arm, 2, False))


def test_laser_by_an_output_of_the_robot(arm: EmulatedArm) -> None:
    with SimulatedCamera(SCENE, arm.state, laser_pin=2) as camera:
        arm.set_output(2, True)
        np.testing.assert_array_equal(camera.grab().image, expected(arm, 0, True))
        arm.set_output(2, False)
        np.testing.assert_array_equal(camera.grab().image, expected(arm, 1, False))
        with pytest.raises(CameraError, match=r"its laser is switched by the robot's output 2"):
            camera.set_line(True)


def test_laser_that_is_not_there_is_refused(arm: EmulatedArm, port: int) -> None:
    with pytest.raises(CameraError, match=r"laser_pin: the robot has the outputs \[0, 1, .* 7\], given 8"):
        open_camera(SimulatedCameraConfig(port=port, laser_pin=8))
    dark = SimulatedCell(CELL.model_copy(update={"laser": False}))
    dark.scene = SCENE.scene
    with SimulatedCamera(dark, arm.state) as camera, pytest.raises(CameraError, match="its cell has no laser"):
        camera.set_line(True)


def test_moving_arm_is_seen_where_it_is(arm: EmulatedArm) -> None:
    """Poses on the way from one stop to the next have the index of the stop before."""
    states = []
    for i in range(4):
        state = arm.state()
        state.T_true[0, 3] += 0.005 * i
        states.append(replace(state, moving=True))
    shown = iter([arm.state(), *states])  # the camera looks once when it is opened
    with SimulatedCamera(SCENE, lambda: next(shown)) as camera:
        frames = [camera.grab().image for _ in states]
    for i, state in enumerate(states):
        np.testing.assert_array_equal(frames[i], SCENE.expose(SCENE.light(state.T_true, 0)[0], 0, i))
    changes = [np.abs(frame.astype(float) - frames[0]).mean() for frame in frames]
    assert changes == sorted(changes)


def test_fault_that_moves_the_true_pose_is_seen_without_a_new_stop(arm: EmulatedArm) -> None:
    with SimulatedCamera(SCENE, arm.state) as camera:
        camera.grab()
        arm.faults.set("pose_bias", 5.0)
        np.testing.assert_array_equal(camera.grab().image, expected(arm, 1, False))


def test_camera_over_the_control_port_gives_the_same_bytes(arm: EmulatedArm, port: int) -> None:
    with open_camera(SimulatedCameraConfig(port=port)) as camera:
        step(arm)
        np.testing.assert_array_equal(camera.grab().image, expected(arm, 0, False))


def test_emulator_that_is_not_there_or_goes_away_is_told(arm: EmulatedArm) -> None:
    control = ControlPort(arm, "127.0.0.1", 0, lambda: None)
    camera = open_camera(SimulatedCameraConfig(port=control.port, timeout_s=0.5))
    control.close()
    with pytest.raises(CameraError, match=r"simulated camera: emulator at 127\.0\.0\.1:\d+: no answer to 'state'"):
        camera.grab()
    camera.close()
    with pytest.raises(CameraError, match=r"is `cv-active-handeye emulate` running\?"):
        open_camera(SimulatedCameraConfig(port=control.port))


def test_16_bit_cell_gives_16_bit_frames(arm: EmulatedArm) -> None:
    with SimulatedCamera(SimulatedCell(CELL.model_copy(update={"bit_depth": 16})), arm.state) as camera:
        assert camera.info.pixel_format == "mono16"
        assert camera.grab().image.max() > 255
