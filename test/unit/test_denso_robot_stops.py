# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The DENSO driver on the emulated controller: when it stops the arm, and that this is for good."""

from __future__ import annotations

import _thread
import threading
import time

import pytest
from support.denso_emulator import Emulated, RawSession, emulated_denso, moved, start_of

from cv_active_handeye.robots.base import (
    MoveRefusedError,
    RobotStoppedError,
    Speed,
    StopReason,
)
from cv_active_handeye.robots.bcap import BcapError
from cv_active_handeye.robots.bcap_codes import Function
from cv_active_handeye.robots.bcap_packets import Value
from cv_active_handeye.robots.denso import connect
from cv_active_handeye.robots.denso_link import halt_anew
from cv_active_handeye.robots.denso_pose import p_from_matrix
from cv_active_handeye.simulation.emulators import moves_after_stop

pytestmark = pytest.mark.timeout(60)
FAST = Speed(metres_per_second=0.25, metres_per_second2=1.0)


def running(emulated: Emulated) -> float:
    """Waits until a motion is under way; its beginning."""
    end = time.monotonic() + 5
    while not emulated.arm.moving:
        assert time.monotonic() < end
        time.sleep(0.002)
    return time.monotonic()


def test_arm_that_is_faster_than_its_settings_say_is_stopped() -> None:
    options = {"full_speed_m_s": 2.0, "full_acceleration_m_s2": 10.0}
    with emulated_denso(speedup=1.0) as emulated, connect(emulated.config(**options), live=True) as robot:
        with pytest.raises(RobotStoppedError, match=r"off the path.*0\.05 m/s were commanded: full_speed_m_s = 2"):
            robot.move_linear(moved(start_of(robot), (0, 100, 0)), Speed())
        assert emulated.arm.log.of_kind("motion_end")[0]["arrived"] is False


def test_arm_that_leaves_the_line_is_halted(monkeypatch: pytest.MonkeyPatch) -> None:
    with emulated_denso(speedup=1.0) as emulated, connect(emulated.config(), live=True) as robot:
        target = moved(start_of(robot), (0, 40, 0))
        true_reading = emulated.arm.reported_pose
        monkeypatch.setattr(
            emulated.arm, "reported_pose", lambda: moved(true_reading(), (0, 0, 3 if emulated.arm.moving else 0))
        )
        with pytest.raises(RobotStoppedError, match=r"off the path: 3\.00 mm from the line"):
            robot.move_linear(target, FAST)
        assert emulated.arm.log.of_kind("motion_end")[0]["arrived"] is False


def test_motor_that_an_emergency_stop_between_moves_has_switched_off_is_not_switched_on_again() -> None:
    with emulated_denso() as emulated, connect(emulated.config(), live=True) as robot:
        start = start_of(robot)
        robot.move_linear(moved(start, (0, 2, 0)), FAST)
        emulated.arm.faults.set("emergency_stop")
        emulated.arm.clear()
        with pytest.raises(RobotStoppedError, match="program stopped: the motor was switched off"):
            robot.move_linear(start, FAST)
        assert emulated.commands().count("Motor") == 1
        assert len(emulated.arm.log.of_kind("motion_begin")) == 1


def test_close_after_a_lost_link_says_what_could_not_be_restored(caplog: pytest.LogCaptureFixture) -> None:
    with emulated_denso() as emulated:
        robot = connect(emulated.config(), live=True)
        emulated.arm.faults.set("drop_link")
        began = time.monotonic()
        robot.close()
        robot.close()
        assert time.monotonic() - began < 3.0
    told = [record.getMessage() for record in caplog.records]
    assert told == [f"{robot.name}: could not be restored, do it at the pendant: Motor, GiveArm"]


def test_halt_anew_stops_the_motion_of_another_connection() -> None:
    with emulated_denso(speedup=1.0) as emulated, RawSession(emulated.port) as mover:
        mover.ready(0.2)
        pose: Value = [p_from_matrix(moved(emulated.arm.reported_pose(), (0, 40, 0))), "P", "@E"]
        pending = mover.client.begin(Function.ROBOT_MOVE, mover.robot, 2, pose, "")
        running(emulated)
        halt_anew("127.0.0.1", emulated.port, "rc8")
        with pytest.raises(BcapError, match="E_ABORT"):
            pending.result(2.0)


def test_move_that_takes_too_long_is_halted_at_its_deadline() -> None:
    with emulated_denso(speedup=1.0) as emulated, connect(emulated.config(), live=True) as robot:
        emulated.arm.faults.set("slow_motion", 0.001)
        began = time.monotonic()
        with pytest.raises(RobotStoppedError) as caught:
            robot.move_linear(moved(start_of(robot), (0, 2, 0)), Speed(metres_per_second2=1.0))
        assert caught.value.reason == StopReason.DEADLINE
        assert 3.0 < time.monotonic() - began < 6.0
        assert not emulated.arm.moving


def test_stop_from_another_thread_halts_the_move_for_good() -> None:
    with emulated_denso(speedup=1.0) as emulated, connect(emulated.config(), live=True) as robot:
        start = start_of(robot)

        def stop() -> None:
            running(emulated)
            robot.stop()

        stopper = threading.Thread(target=stop)
        stopper.start()
        with pytest.raises(RobotStoppedError) as caught:
            robot.move_linear(moved(start, (0, 60, 0)), Speed())
        stopper.join()
        assert caught.value.reason == StopReason.OPERATOR
        assert not emulated.arm.moving
        with pytest.raises(RobotStoppedError, match="operator"):
            robot.move_linear(start, FAST)
        robot.stop()
        assert len(emulated.arm.log.of_kind("motion_begin")) == 1


def test_ctrl_c_during_a_move_halts_it_for_good() -> None:
    with emulated_denso(speedup=1.0) as emulated, connect(emulated.config(), live=True) as robot:
        start = start_of(robot)

        def press() -> None:
            running(emulated)
            _thread.interrupt_main()

        presser = threading.Thread(target=press)
        presser.start()
        with pytest.raises(RobotStoppedError, match="operator: interrupted") as caught:
            robot.move_linear(moved(start, (0, 60, 0)), Speed())
        presser.join()
        assert isinstance(caught.value.__cause__, KeyboardInterrupt)
        assert not emulated.arm.moving
        assert emulated.commands()[-1] == "ROBOT_HALT"


def test_close_during_a_move_halts_it_first() -> None:
    with emulated_denso(speedup=1.0) as emulated:
        robot = connect(emulated.config(), live=True)
        target = moved(start_of(robot), (0, 60, 0))

        def close() -> None:
            running(emulated)
            robot.close()

        closer = threading.Thread(target=close)
        closer.start()
        with pytest.raises(RobotStoppedError, match="operator"):
            robot.move_linear(target, Speed())
        closer.join()
        assert emulated.commands()[-3:] == ["ROBOT_HALT", "Motor", "GiveArm"]
        with pytest.raises(MoveRefusedError, match="was closed"):
            robot.move_linear(target, Speed())


def test_second_move_at_the_same_time_is_refused() -> None:
    with emulated_denso(speedup=1.0) as emulated, connect(emulated.config(), live=True) as robot:
        start, second = start_of(robot), list[Exception]()

        def move_too() -> None:
            running(emulated)
            try:
                robot.move_linear(start, FAST)
            except MoveRefusedError as error:
                second.append(error)

        other = threading.Thread(target=move_too)
        other.start()
        robot.move_linear(moved(start, (0, 10, 0)), FAST)
        other.join()
        assert "another move is under way" in str(second[0])


def test_motion_that_someone_else_halts_is_told_as_a_stop() -> None:
    with emulated_denso(speedup=1.0) as emulated, connect(emulated.config(), live=True) as robot:
        target = moved(start_of(robot), (0, 60, 0))

        def halt() -> None:
            running(emulated)
            with RawSession(emulated.port) as other:
                other.halt()

        halter = threading.Thread(target=halt)
        halter.start()
        with pytest.raises(RobotStoppedError, match=r"controller error: the motion: .*E_ABORT"):
            robot.move_linear(target, Speed())
        halter.join()


def test_pose_of_a_controller_whose_clock_stands_still_is_stale_and_ends_all_moves() -> None:
    with emulated_denso() as emulated, connect(emulated.config(freshness_s=0.2), live=True) as robot:
        start = start_of(robot)
        emulated.arm.faults.set("frozen_timestamp")
        robot.pose()
        began = time.monotonic()
        with pytest.raises(RobotStoppedError, match=r"stale pose: the controller's clock stands still"):
            robot.pose()
        assert time.monotonic() - began < 0.6
        emulated.arm.faults.clear()
        with pytest.raises(RobotStoppedError, match="stale pose"):
            robot.move_linear(start, FAST)
        assert moves_after_stop(emulated.arm.log.events) == []
