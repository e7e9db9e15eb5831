# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The emulated arm: timing, straight lines, halting, errors of its poses, and faults."""

from __future__ import annotations

import threading
import time

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.spatial.transform import Rotation

from cv_active_handeye.robots.workspace import step_size
from cv_active_handeye.simulation import CellConfig
from cv_active_handeye.simulation.emulators import EmulatedArm, EmulatorStop, EventLog, FaultPlan, moves_after_stop
from cv_active_handeye.simulation.emulators.profile import Profile

Array = NDArray[np.float64]
pytestmark = pytest.mark.timeout(60)


def emulated(robot: str = "ur5e", speedup: float = 50.0, **errors: float) -> EmulatedArm:
    return EmulatedArm(CellConfig.model_validate({"robot": robot, **errors}), speedup=speedup, log=EventLog())


def moved(pose: Array, mm: tuple[float, float, float] = (0, 0, 0), rotvec_deg: tuple[float, ...] = (0, 0, 0)) -> Array:
    out = pose.copy()
    out[:3, 3] += np.array(mm) / 1000
    out[:3, :3] = pose[:3, :3] @ Rotation.from_rotvec(np.radians(rotvec_deg)).as_matrix()
    return out


def go(arm: EmulatedArm, pose: Array, speed: float = 0.25, acceleration: float = 1.0) -> None:
    arm.move_linear(pose, speed, acceleration, threading.Event())


@pytest.mark.parametrize(("length", "speed", "acceleration"), [(0.1, 0.05, 0.2), (0.001, 0.25, 0.5), (0.3, 0.25, 1.0)])
def test_profile_goes_its_length_within_speed_and_acceleration(
    length: float, speed: float, acceleration: float
) -> None:
    profile = Profile.trapezoid(length, speed, acceleration)
    assert profile.duration == pytest.approx(
        length / speed + speed / acceleration
        if length > speed**2 / acceleration
        else 2 * np.sqrt(length / acceleration)
    )
    times = np.linspace(0, profile.duration, 2001)
    speeds = np.array([profile.speed_at(t) for t in times])
    assert speeds.max() <= speed * (1 + 1e-12)
    assert np.abs(np.diff(speeds)).max() <= acceleration * times[1] * (1 + 1e-6)
    for t in times[::400]:
        assert profile.position(t) == pytest.approx(
            quad(profile.speed_at, 0, t, limit=200)[0], abs=1e-6 * length + 1e-9
        )
    assert profile.position(profile.duration) == length


@pytest.mark.parametrize("when", [0.0, 0.1, 0.25, 1.0, 2.2, 2.3])
def test_braked_profile_stops_within_the_deceleration_distance(when: float) -> None:
    profile = Profile.trapezoid(0.1, 0.05, 0.2)
    rest = profile.braked(when, 2.0)
    speed = profile.speed_at(when)
    assert rest.length == pytest.approx(min(speed**2 / 4.0, profile.length - profile.position(when)), abs=1e-12)
    assert rest.speed_at(0.0) == pytest.approx(speed, abs=1e-12)
    assert rest.duration <= 0.025 + 1e-12


@pytest.mark.parametrize("robot", ["ur5e", "denso_vp6242"])
def test_move_linear_keeps_to_the_line_and_its_time(robot: str) -> None:
    arm = emulated(robot, speedup=10, servo_mm=0, servo_deg=0)
    start = arm.reported_pose()
    end = moved(start, (30, -20, 40), (0, 0, 10))
    thread = threading.Thread(target=go, args=(arm, end, 0.05, 0.2))
    began = time.monotonic()
    thread.start()
    seen = []
    while thread.is_alive():
        seen.append(arm.reported_pose())
        time.sleep(0.005)
    lasted = 10 * (time.monotonic() - began)
    expected = Profile.trapezoid(step_size(start, end)[0], 0.05, 0.2).duration
    assert expected <= lasted <= expected + 2.0
    way = end[:3, 3] - start[:3, 3]
    unit = way / np.linalg.norm(way)
    for pose in seen:
        fraction = float((pose[:3, 3] - start[:3, 3]) @ unit / np.linalg.norm(way))
        line = moved(start, tuple(1000 * fraction * way), (0, 0, 10 * fraction))
        length, angle = step_size(line, pose)
        assert length < 3e-5
        assert angle < 0.01
    length, angle = step_size(end, arm.reported_pose())
    assert length < 1e-9
    assert angle < 1e-6
    assert len(seen) > 10


def test_move_linear_to_an_unreachable_pose_does_not_begin() -> None:
    arm = emulated()
    before = arm.reported_pose()
    with pytest.raises(EmulatorStop, match="UR5e") as caught:
        go(arm, moved(before, (1500, 0, 0)))
    assert caught.value.reason == "unreachable"
    np.testing.assert_array_equal(arm.reported_pose(), before)
    assert arm.stop_index == 0
    assert not arm.log.of_kind("motion_begin")


def test_move_joints_arrives_and_refuses_joints_beyond_their_limits() -> None:
    arm = emulated("denso_vp6242", servo_mm=0, servo_deg=0)
    target = arm.joints + np.radians([5, -3, 2, 1, 4, -6])
    arm.move_joints(target, 1.0, 5.0, threading.Event())
    np.testing.assert_allclose(arm.joints, target, atol=1e-12)
    with pytest.raises(EmulatorStop, match="not within the limits"):
        arm.move_joints(target + np.radians([0, 0, 90, 0, 0, 0]), 1.0, 5.0, threading.Event())


def test_cancel_halts_within_the_deceleration_distance() -> None:
    arm = emulated(speedup=1.0, servo_mm=0, servo_deg=0)
    arm.halt_deceleration = 1.0
    start, cancel, reasons = arm.reported_pose(), threading.Event(), []

    def move() -> None:
        try:
            arm.move_linear(moved(start, (0, 0, 100)), 0.1, 1.0, cancel)
        except EmulatorStop as stop:
            reasons.append(stop.reason)

    thread = threading.Thread(target=move)
    thread.start()
    time.sleep(0.4)
    asked = step_size(start, arm.reported_pose())[0]
    cancel.set()
    thread.join(5)
    stood = step_size(start, arm.reported_pose())[0]
    assert reasons == ["cancelled"]
    assert 0.0 < stood - asked < 0.1**2 / 2 / 1.0 + 0.1 * 0.1
    assert not arm.moving
    assert arm.stop_index == 1


def test_true_pose_scatters_about_the_reported_one_as_the_cell_says() -> None:
    arm = emulated(speedup=1000.0, repeatability_mm=0.02, repeatability_deg=0.005, servo_mm=0.01, servo_deg=0.001)
    a = arm.reported_pose()
    b = moved(a, (0.5, 0, 0))
    reported, true, turned = [], [], []
    for i in range(300):
        target = a if i % 2 else b
        go(arm, target, 0.25, 1.0)
        assert (arm.reported_pose() == arm.reported_pose()).all()
        reported.append(1000 * (arm.reported_pose() - target)[:3, 3])
        true.append(1000 * (arm.true_pose() - arm.reported_pose())[:3, 3])
        turn = Rotation.from_matrix(arm.true_pose()[:3, :3] @ arm.reported_pose()[:3, :3].T)
        turned.append(np.degrees(turn.as_rotvec()))
    for sample, sigma in ((reported, 0.01), (true, 0.02), (turned, 0.005)):
        assert np.std(sample) == pytest.approx(sigma, rel=0.1)
        assert abs(np.mean(sample)) < 4 * sigma / np.sqrt(900)


def test_pose_bias_moves_the_true_pose_and_pose_noise_the_reported_one() -> None:
    arm = emulated()
    true, reported = arm.true_pose(), arm.reported_pose()
    arm.faults.set("pose_bias", 0.7)
    assert 1000 * np.linalg.norm((arm.true_pose() - true)[:3, 3]) == pytest.approx(0.7)
    np.testing.assert_array_equal(arm.reported_pose(), reported)
    arm.faults.set("pose_bias", 0)
    arm.faults.set("pose_noise", 0.3)
    noise = [1000 * (arm.reported_pose() - reported)[:3, 3] for _ in range(500)]
    assert np.std(noise) == pytest.approx(0.3, rel=0.1)
    np.testing.assert_array_equal(arm.true_pose(), true)


def test_steady_comes_after_settling_later_with_the_fault_and_after_rendering_when_held() -> None:
    arm = emulated(speedup=10.0)
    assert arm.steady()
    go(arm, moved(arm.reported_pose(), (1, 0, 0)))
    assert not arm.steady()
    time.sleep(0.07)
    assert arm.steady()
    arm.faults.set("slow_settling", 1.5)
    assert not arm.steady()
    time.sleep(0.1)
    assert arm.steady()
    arm.hold(True)
    assert not arm.steady()
    arm.rendered(0, 0)
    assert not arm.steady()
    arm.rendered(1, 0)
    assert arm.steady()


@pytest.mark.parametrize("name", ["protective_stop", "emergency_stop"])
def test_stop_in_the_middle_of_a_motion_keeps_the_arm_until_it_is_cleared(name: str) -> None:
    arm = emulated(speedup=5)
    start = arm.reported_pose()
    end = moved(start, (0, 0, 60))
    arm.faults.plan(FaultPlan.parse(f"{name}@move1"))
    with pytest.raises(EmulatorStop) as caught:
        go(arm, end)
    assert caught.value.reason == name.replace("_", " ")
    assert 0.02 < step_size(start, arm.reported_pose())[0] < 0.055
    assert not moves_after_stop(arm.log.events)
    with pytest.raises(EmulatorStop, match="cleared"):
        go(arm, start)
    assert [event["kind"] for event in moves_after_stop(arm.log.events)] == ["violation"]
    arm.clear()
    go(arm, start)
    kinds = [event["kind"] for event in arm.log.events]
    assert kinds == [
        *("motion_begin", "fault", "stop_condition", "motion_end", "violation", "cleared"),
        *("motion_begin", "motion_end"),
    ]
    assert [event["arrived"] for event in arm.log.of_kind("motion_end")] == [False, True]


def test_motion_that_was_cancelled_before_it_began_leaves_no_trace() -> None:
    arm, cancel = emulated(), threading.Event()
    cancel.set()
    with pytest.raises(EmulatorStop, match="cancelled: before the motion began"):
        arm.move_linear(moved(arm.reported_pose(), (0, 0, 5)), 0.1, 1.0, cancel)
    assert arm.stop_index == 0
    assert not arm.log.events


def test_moves_after_stop_finds_a_motion_that_begins_after_a_lost_link() -> None:
    arm = emulated()
    arm.faults.set("drop_link")
    go(arm, moved(arm.reported_pose(), (1, 0, 0)))
    assert len(moves_after_stop(arm.log.events)) == 1
    assert not moves_after_stop(arm.log.events, grace=60.0)


def test_unreachable_refuses_as_many_targets_as_it_says() -> None:
    arm = emulated()
    arm.faults.set("unreachable", 2)
    near = moved(arm.reported_pose(), (1, 0, 0))
    for _ in range(2):
        with pytest.raises(EmulatorStop, match="no joint solution"):
            go(arm, near)
    go(arm, near)


def test_slow_motion_stretches_the_time() -> None:
    arm = emulated(speedup=20)
    arm.faults.set("slow_motion", 0.1)
    began = time.monotonic()
    go(arm, moved(arm.reported_pose(), (10, 0, 0)), 0.1, 1.0)
    assert 20 * (time.monotonic() - began) >= Profile.trapezoid(0.01, 0.01, 1.0).duration


def test_fault_plan_comes_after_its_seconds_and_at_its_stop() -> None:
    arm = emulated()
    arm.faults.plan(FaultPlan.parse("pose_bias=2@0.05"))
    arm.faults.plan(FaultPlan.parse("slow_settling=7@stop1"))
    assert not arm.faults.value("pose_bias")
    time.sleep(0.2)
    assert arm.faults.value("pose_bias") == 2.0
    assert not arm.faults.value("slow_settling")
    go(arm, moved(arm.reported_pose(), (1, 0, 0)))
    assert arm.faults.value("slow_settling") == 7.0
    arm.close()


@pytest.mark.parametrize("text", ["collision", "drop_link@", "drop_link@yesterday", "drop_link=", "", "pose_bias=-1"])
def test_fault_plan_that_cannot_be_read_is_refused_with_the_names(text: str) -> None:
    with pytest.raises(ValueError, match=r"needs NAME.*protective_stop.*given"):
        FaultPlan.parse(text)


def test_set_output_switches_logs_changes_and_refuses_other_pins() -> None:
    arm = emulated()
    arm.set_output(3, True)
    arm.set_output(3, True)
    assert arm.outputs[3]
    assert [(event["pin"], event["on"]) for event in arm.log.of_kind("output")] == [(3, True)]
    with pytest.raises(ValueError, match="pin: needs 0 to 7, given 8"):
        arm.set_output(8, True)


def test_moves_after_stop_counts_from_when_a_motion_was_asked_for() -> None:
    stop = {"time": 10.0, "kind": "stop_condition", "reason": "stale pose"}
    before = {"time": 10.2, "kind": "motion_begin", "motion": 1, "asked": 9.9}
    after = {"time": 10.2, "kind": "motion_begin", "motion": 2, "asked": 10.1}
    cleared = {"time": 10.3, "kind": "cleared"}
    later = {"time": 10.4, "kind": "motion_begin", "motion": 3, "asked": 10.4}
    assert moves_after_stop([stop, before, after, cleared, later]) == [after]
    assert moves_after_stop([stop, before, after], grace=0.15) == []
