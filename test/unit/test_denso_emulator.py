# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The emulated DENSO controller: order of calls, pose data, conversions, keep-alives, halting, hostile clients."""

from __future__ import annotations

import re
import socket
import threading
import time
from contextlib import suppress

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.denso_emulator import RawSession, emulated_denso, moved

from cv_active_handeye.robots.bcap import BcapClient, BcapError
from cv_active_handeye.robots.bcap_codes import Function, Result
from cv_active_handeye.robots.bcap_packets import Packet, PacketStream, Value, encode_packet
from cv_active_handeye.robots.denso_pose import matrix_from_p, matrix_from_t, p_from_matrix, t_from_matrix
from cv_active_handeye.simulation.emulators import moves_after_stop
from cv_active_handeye.simulation.emulators.denso.errors import ARM_NOT_TAKEN, MOTOR_OFF, OUT_OF_RANGE, STOPPED

pytestmark = pytest.mark.timeout(60)


def test_session_in_the_right_order_moves_and_violates_nothing() -> None:
    with emulated_denso() as emulated, RawSession(emulated.port) as session:
        session.ready()
        target = moved(emulated.arm.reported_pose(), (0, 15, 0), (3, 0, 0))
        session.move([t_from_matrix(target), "T", "@E"])
        reached = emulated.arm.reported_pose()
        assert np.abs(reached[:3, 3] - target[:3, 3]).max() < 2e-5
        assert (Rotation.from_matrix(reached[:3, :3].T @ target[:3, :3])).magnitude() < 1e-4
        session.execute("Motor", [0, 0])
        session.execute("GiveArm")
        assert emulated.violations() == []


@pytest.mark.parametrize(
    ("before", "code", "told"),
    [
        ([], ARM_NOT_TAKEN, "without TakeArm"),
        ([("TakeArm", [0, 0])], MOTOR_OFF, "with the motor off"),
        ([("TakeArm", [0, 0]), ("ExtSpeed", [5]), ("Motor", [1, 0]), ("GiveArm", None)], ARM_NOT_TAKEN, "TakeArm"),
    ],
)
def test_motion_out_of_order_is_refused_and_logged(before: list[tuple[str, Value]], code: int, told: str) -> None:
    with emulated_denso() as emulated, RawSession(emulated.port) as session:
        for command, parameter in before:
            session.execute(command, parameter)
        with pytest.raises(BcapError) as caught:
            session.move([p_from_matrix(emulated.arm.reported_pose()), "P", "@E"])
        assert caught.value.code == code
        assert told in emulated.violations()[-1]
        assert emulated.arm.log.of_kind("motion_begin") == []


def test_motor_before_the_speed_is_a_violation() -> None:
    with emulated_denso() as emulated, RawSession(emulated.port) as session:
        session.execute("TakeArm", [0, 0])
        session.execute("Motor", [1, 0])
        assert emulated.violations() == ["Motor before ExtSpeed: the speed is whatever was left"]


def test_second_client_does_not_get_the_arm_before_the_first_is_gone() -> None:
    with emulated_denso() as emulated, RawSession(emulated.port) as first, RawSession(emulated.port) as second:
        first.execute("TakeArm", [0, 0])
        with pytest.raises(BcapError, match="E_ACCESSDENIED"):
            second.execute("TakeArm", [0, 0])
        first.client.abort()
        end = time.monotonic() + 5
        while "disconnect" not in [event["kind"] for event in emulated.arm.log.events]:
            assert time.monotonic() < end
        second.execute("TakeArm", [0, 0])


@pytest.mark.parametrize(
    "pose",
    ["@E P({p})", "p({p})", "@P T({t})", "@0 J({j})", ["p", "P", "@E"], ["t", "T"], ["j", "J", "@10"]],
)
def test_pose_data_in_every_form_brings_the_arm_to_the_same_place(pose: Value) -> None:
    with emulated_denso(speedup=500) as emulated, RawSession(emulated.port) as session:
        session.ready(20)
        target = moved(emulated.arm.reported_pose(), (0, 5, 0))
        joints = np.degrees(emulated.arm.arm.inverse(target, emulated.arm.joints)).tolist()
        values = {"p": p_from_matrix(target), "t": t_from_matrix(target), "j": joints}
        if isinstance(pose, str):
            texts = {key: ",".join(f"{value:.9f}" for value in numbers) for key, numbers in values.items()}
            session.move(pose.format(**texts))
        else:
            assert isinstance(pose, list)
            session.move([values[str(pose[0])], *pose[1:]])
        assert np.abs(emulated.arm.reported_pose() - target).max() < 5e-5


@pytest.mark.parametrize(
    "pose", ["P(1,2)", "Q(1,2,3,4,5,6)", "P(a,b,c,d,e,f)", [1.0, 2.0], [[1.0], "P"], ["x", "P"], None]
)
def test_pose_data_that_is_none_is_an_invalid_argument(pose: Value) -> None:
    with emulated_denso() as emulated, RawSession(emulated.port) as session:
        session.ready()
        with pytest.raises(BcapError, match="E_INVALIDARG"):
            session.move(pose)


@pytest.mark.parametrize("mm", [1e9, 1e300])
def test_target_very_far_away_is_out_of_range_at_once(mm: float) -> None:
    with emulated_denso() as emulated, RawSession(emulated.port) as session:
        session.ready()
        began = time.monotonic()
        with pytest.raises(BcapError) as caught:
            session.move([[mm, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0], "P", "@E"])
        assert caught.value.code == OUT_OF_RANGE
        assert time.monotonic() - began < 1.0


def test_conversions_agree_with_scipy_and_the_arms_kinematics() -> None:
    rng = np.random.default_rng(8)
    with emulated_denso() as emulated, RawSession(emulated.port) as session:
        for angles in rng.uniform(-180, 180, (20, 3)):
            R = Rotation.from_euler("xyz", angles, degrees=True).as_matrix()
            said = session.numbers("P2T", [100.0, 200.0, 300.0, *map(float, angles), -1.0])
            np.testing.assert_allclose(said[:9], [100, 200, 300, *R[:, 1], *R[:, 2]], atol=1e-12)
            np.testing.assert_allclose(matrix_from_p(session.numbers("T2P", said.tolist()))[:3, :3], R, atol=1e-12)
        q = emulated.arm.joints
        pose = session.numbers("J2P", np.degrees(q).tolist())
        np.testing.assert_allclose(matrix_from_p(pose), emulated.arm.arm.forward(q), atol=1e-12)
        np.testing.assert_allclose(np.radians(session.numbers("P2J", pose.tolist()))[:6], q, atol=1e-9)


def test_readings_are_those_of_the_arm_in_the_controllers_units() -> None:
    with emulated_denso() as emulated, RawSession(emulated.port) as session:
        reported = emulated.arm.reported_pose()
        np.testing.assert_allclose(matrix_from_p(session.numbers("CurPos")), reported, atol=1e-12)
        np.testing.assert_allclose(matrix_from_t(session.numbers("CurTrn")), reported, atol=1e-12)
        np.testing.assert_allclose(np.radians(session.numbers("CurJnt"))[:6], emulated.arm.joints, atol=1e-12)
        clock = emulated.arm.now
        first, second = session.numbers("HighCurPosEx"), session.numbers("HighCurJntEx")
        assert (len(first), len(second)) == (8, 9)
        assert 1000 * clock - 1 <= first[0] <= second[0] <= 1000 * emulated.arm.now + 1
        np.testing.assert_allclose(matrix_from_p(first[1:]), reported, atol=1e-12)


def test_out_of_range_is_told_before_and_at_the_motion() -> None:
    far = np.eye(4)
    far[:3, 3] = 2.0
    with emulated_denso() as emulated, RawSession(emulated.port) as session:
        session.ready()
        assert session.execute("OutRange", [[p_from_matrix(emulated.arm.reported_pose()), "P"], 0, 0]) == 0
        assert session.execute("OutRange", [[p_from_matrix(far), "P"], 0, 0]) == 63
        with pytest.raises(BcapError) as caught:
            session.move([p_from_matrix(far), "P", "@E"])
        assert caught.value.code == OUT_OF_RANGE
        controller = session.client.call(Function.CONTROLLER_GET_VARIABLE, session.controller, "@ERROR_CODE", "")
        assert session.client.call(Function.VARIABLE_GET_VALUE, controller) == OUT_OF_RANGE - (1 << 32)
        execute = Function.CONTROLLER_EXECUTE
        text = session.client.call(execute, session.controller, "GetErrorDescription", OUT_OF_RANGE - (1 << 32))
        assert text == "the target is out of the motion range"
        session.client.call(execute, session.controller, "ClearError", None)
        assert session.client.call(Function.VARIABLE_GET_VALUE, controller) == 0
        with pytest.raises(BcapError):
            session.move([p_from_matrix(far), "P", "@E"])
        emulated.arm.clear()
        assert session.client.call(Function.VARIABLE_GET_VALUE, controller) == 0


def test_long_motion_sends_keep_alives_longer_than_the_clients_silence() -> None:
    with emulated_denso(speedup=1.0) as emulated, RawSession(emulated.port) as session:
        session.ready(0.2)
        session.client._silence_s = 0.5
        session.move([p_from_matrix(moved(emulated.arm.reported_pose(), (0, 20, 0))), "P", "@E"])
        assert session.client.executing >= 4


def test_halt_over_a_second_connection_ends_the_motion_of_the_first() -> None:
    with (
        emulated_denso(speedup=1.0) as emulated,
        RawSession(emulated.port) as mover,
        RawSession(emulated.port) as other,
    ):
        mover.ready(0.2)
        start = emulated.arm.reported_pose()
        pose: Value = [p_from_matrix(moved(start, (0, 40, 0))), "P", "@E"]
        pending = mover.client.begin(Function.ROBOT_MOVE, mover.robot, 2, pose, "")
        assert not pending.poll(0.3)
        other.halt()
        began = time.monotonic()
        with pytest.raises(BcapError, match="E_ABORT"):
            pending.result(2.0)
        assert time.monotonic() - began < 0.5
        way = np.linalg.norm(emulated.arm.reported_pose()[:3, 3] - start[:3, 3])
        assert 0.001 < way < 0.03


def test_call_during_a_motion_on_the_same_connection_is_answered_busy() -> None:
    with emulated_denso(speedup=1.0) as emulated, socket.create_connection(("127.0.0.1", emulated.port)) as connection:
        pose: Value = [p_from_matrix(moved(emulated.arm.reported_pose(), (0, 20, 0))), "P", "@E"]
        stream = PacketStream()
        calls: list[tuple[Function, tuple[Value, ...]]] = [
            (Function.SERVICE_START, ("",)),
            (Function.CONTROLLER_CONNECT, ("", "CaoProv.DENSO.VRC", "localhost", "")),
            (Function.CONTROLLER_GET_ROBOT, (1, "Arm", "")),
            (Function.ROBOT_EXECUTE, (2, "TakeArm", [0, 0])),
            (Function.ROBOT_EXECUTE, (2, "ExtSpeed", [0.2])),
            (Function.ROBOT_EXECUTE, (2, "Motor", [1, 0])),
        ]
        for serial, (function, arguments) in enumerate(calls, start=1):
            connection.sendall(encode_packet(Packet(serial, function, arguments)))
            assert stream.feed(connection.recv(65536))[0].code == Result.S_OK
        ask = Packet(21, Function.ROBOT_EXECUTE, (2, "CurPos", None))
        connection.sendall(encode_packet(Packet(20, Function.ROBOT_MOVE, (2, 2, pose, ""))) + encode_packet(ask))
        assert stream.feed(connection.recv(65536)) == [Packet(21, Result.E_BUSY_CONNECTION)]
        assert "another one was being worked on" in emulated.violations()[0]


def test_lost_connection_halts_its_motion_and_gives_the_arm_back() -> None:
    with emulated_denso(speedup=1.0) as emulated:
        with RawSession(emulated.port) as first:
            first.ready(0.2)
            pose: Value = [p_from_matrix(moved(emulated.arm.reported_pose(), (0, 40, 0))), "P", "@E"]
            pending = first.client.begin(Function.ROBOT_MOVE, first.robot, 2, pose, "")
            assert not pending.poll(0.2)
            first.client.abort()
        with RawSession(emulated.port) as second:
            end = time.monotonic() + 3
            while emulated.arm.moving:
                assert time.monotonic() < end
            second.execute("TakeArm", [0, 0])
        assert [event["arrived"] for event in emulated.arm.log.of_kind("motion_end")] == [False]


@pytest.mark.parametrize("fault", ["emergency_stop", "protective_stop", "program_stopped", "not_remote"])
def test_stop_condition_cuts_the_motor_and_refuses_motion_until_a_person_clears_it(fault: str) -> None:
    condition = {"program_stopped": "program stopped", "not_remote": "manual mode"}.get(fault, fault.replace("_", " "))
    with emulated_denso() as emulated, RawSession(emulated.port) as session:
        session.ready()
        emulated.arm.faults.set(fault)
        pose: Value = [p_from_matrix(emulated.arm.reported_pose()), "P", "@E"]
        with pytest.raises(BcapError) as caught:
            session.move(pose)
        assert caught.value.code == STOPPED[condition]
        assert len(moves_after_stop(emulated.arm.log.events)) == 1
        emulated.arm.clear()
        with pytest.raises(BcapError) as caught:
            session.move(pose)
        assert caught.value.code == MOTOR_OFF


def test_stop_condition_while_the_way_is_worked_out_keeps_the_motion_from_beginning() -> None:
    with emulated_denso() as emulated, RawSession(emulated.port) as session:
        session.ready()
        far = moved(emulated.arm.reported_pose(), (0, 60, 0), (0, 20, 0))
        pending = session.client.begin(Function.ROBOT_MOVE, session.robot, 2, [p_from_matrix(far), "P", "@E"], "")
        while emulated.arm.log.of_kind("command")[-1]["name"] != "ROBOT_MOVE":
            pass
        emulated.arm.halt("protective stop")
        with pytest.raises(BcapError):
            pending.result(5.0)
        begun = emulated.arm.log.of_kind("motion_begin")
        assert len(begun) == 0 or begun[0]["time"] < emulated.arm.log.of_kind("stop_condition")[0]["time"]


def test_commands_that_an_rc7_does_not_have_are_not_implemented() -> None:
    with emulated_denso(controller="rc7") as emulated, RawSession(emulated.port, "rc7") as session:
        for command in ("P2T", "CurTrn", "OutRange", "HighCurPosEx"):
            with pytest.raises(BcapError, match="E_NOTIMPL"):
                session.execute(command, [1.0] * 7)
        session.execute("TakeArm", [0, 0])
        session.client.call(Function.ROBOT_CHANGE, session.robot, "Tool=0")
        with pytest.raises(BcapError, match="E_INVALIDARG"):
            session.client.call(Function.ROBOT_CHANGE, session.robot, "Tool0")
        assert "Robot_Change" in emulated.violations()[0]


def test_provider_of_another_generation_is_refused() -> None:
    with emulated_denso(controller="rc9") as emulated, pytest.raises(BcapError, match="E_INVALIDARG"):
        RawSession(emulated.port, "rc8")


def test_watchdog_below_80_ms_is_refused() -> None:
    with emulated_denso() as emulated, pytest.raises(BcapError, match="SERVICE_START: E_INVALIDARG"):
        BcapClient("127.0.0.1", emulated.port, keep_alive_s=0.05)


def test_call_before_the_service_was_started_is_a_violation() -> None:
    with emulated_denso() as emulated, socket.create_connection(("127.0.0.1", emulated.port)) as connection:
        connection.sendall(encode_packet(Packet(1, Function.CONTROLLER_CONNECT, ("", "x", "", ""))))
        assert PacketStream().feed(connection.recv(65536)) == [Packet(1, Result.E_UNEXPECTED)]
        assert "before SERVICE_START" in emulated.violations()[0]


def test_garbage_closes_the_connection_and_nothing_else() -> None:
    rng = np.random.default_rng(9)
    with emulated_denso() as emulated:
        for size in (1, 5, 17, 4096):
            with socket.create_connection(("127.0.0.1", emulated.port)) as connection:
                connection.settimeout(5)
                connection.sendall(b"\x02" + rng.integers(0, 256, size, dtype=np.uint8).tobytes() + bytes(5))
                with suppress(ConnectionResetError):
                    assert connection.recv(10) == b""
        with RawSession(emulated.port) as session:
            assert session.execute("GetRobotTypeName") == "DENSO VP-6242"
        assert sum("needs to begin with" in text for text in emulated.violations()) == 4


def test_random_requests_are_answered_whatever_they_are() -> None:
    rng = np.random.default_rng(10)
    junk: list[Value] = [
        None,
        1,
        2,
        -1,
        1 << 40,
        0.5,
        "",
        "CurPos",
        "@MODE",
        "IO[1]",
        [1.0] * 7,
        [["P"], 1],
        b"x",
        True,
    ]
    functions = [function for function in Function if function != Function.SERVICE_STOP]
    with emulated_denso(speedup=1000) as emulated, RawSession(emulated.port) as session:
        for _ in range(600):
            function = functions[rng.integers(len(functions))]
            arguments = [junk[i] for i in rng.integers(0, len(junk), rng.integers(0, 5))]
            try:
                session.client.call(function, *arguments, deadline_s=5.0)
            except BcapError as error:
                assert re.search(r"0x8[0-9a-f]{7}", str(error))  # noqa: PT017 (refusals are fine, other errors are not)
        assert threading.active_count() < 20
