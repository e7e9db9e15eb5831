# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The UR emulator's ports against clients that err: nothing crashes, everything is told."""

from __future__ import annotations

import os
import socket
import struct
import threading
import time
from collections.abc import Iterator

import numpy as np
import pytest

from cv_active_handeye.robots import ur_probe
from cv_active_handeye.robots.base import RobotUnavailableError
from cv_active_handeye.robots.rtde_packets import DATA, INPUTS, OUTPUTS, PROTOCOL, START, Packet, PacketReader
from cv_active_handeye.simulation import CellConfig
from cv_active_handeye.simulation.emulators import EmulatedArm, EventLog
from cv_active_handeye.simulation.emulators.ur import UrEmulator

pytestmark = pytest.mark.timeout(60)


class Client:
    """One RTDE connection that sends what a test wants."""

    def __init__(self, host: str) -> None:
        self.socket = socket.create_connection((host, 30004), 5)
        self.reader = PacketReader()
        self.waiting: list[Packet] = []

    def ask(self, kind: int, payload: bytes) -> bytes:
        self.socket.sendall(Packet(kind, payload).encoded())
        return self.next(kind)

    def next(self, kind: int) -> bytes:
        while True:
            while self.waiting:
                packet = self.waiting.pop(0)
                if packet.kind == kind:
                    return packet.payload
            data = self.socket.recv(65536)
            if not data:
                raise ConnectionResetError
            self.waiting += self.reader.feed(data)

    def closed(self) -> bool:
        try:
            while self.socket.recv(65536):
                pass
        except ConnectionError:
            pass
        return True


_clients: list[Client] = []


def connected(emulator: UrEmulator) -> Client:
    """A client that is closed after the test."""
    _clients.append(Client(emulator.host))
    return _clients[-1]


@pytest.fixture
def emulator() -> Iterator[UrEmulator]:
    threads = threading.active_count()
    host = f"127.{1 + os.getpid() // 250 % 250}.{1 + os.getpid() % 250}.9"
    arm = EmulatedArm(CellConfig(robot="ur5e"), speedup=20, log=EventLog())
    with UrEmulator(arm, host) as emulator:
        yield emulator
        while _clients:
            _clients.pop().socket.close()
    arm.close()
    assert threading.active_count() == threads


def violations(emulator: UrEmulator) -> list[str]:
    return [event["text"] for event in emulator.controller.arm.log.of_kind("violation")]


@pytest.mark.parametrize(
    ("data", "text"),
    [
        (b"\x00\x00\x00", "packet size"),
        (b"GET / HTTP/1.1\r\n\r\n", "packet size"),
        (Packet(PROTOCOL, b"\x02").encoded(), "protocol version"),
        (Packet(OUTPUTS, b"").encoded(), "frequency"),
        (Packet(INPUTS, b",,").encoded(), "recipe: needs names"),
        (Packet(DATA, b"").encoded(), "number of an input recipe, given 0"),
        (Packet(DATA, b"\x07").encoded(), "number of an input recipe, given 7"),
        (
            Packet(INPUTS, b"input_int_register_0").encoded() + Packet(DATA, b"\x01\x00").encoded(),
            "needs 4 bytes, given 1",
        ),
    ],
)
def test_malformed_packet_is_a_violation_and_ends_only_its_connection(
    emulator: UrEmulator, data: bytes, text: str
) -> None:
    other, client = connected(emulator), connected(emulator)
    client.socket.sendall(data)
    assert client.closed()
    assert text in violations(emulator)[0]
    assert other.ask(PROTOCOL, b"\x00\x02") == b"\x01"


def test_random_bytes_on_all_ports_leave_the_emulator_alive(emulator: UrEmulator) -> None:
    rng = np.random.default_rng(3)
    for port in (30004, 30003, 29999) * 6:
        with socket.create_connection((emulator.host, port), 5) as connection:
            try:
                connection.sendall(rng.bytes(int(rng.integers(1, 200_000))))
            except ConnectionError:
                continue
    assert connected(emulator).ask(PROTOCOL, b"\x00\x02") == b"\x01"


def test_unknown_output_and_input_are_not_found(emulator: UrEmulator) -> None:
    client = connected(emulator)
    assert client.ask(OUTPUTS, struct.pack(">d", 10) + b"timestamp,wind") == b"\x01DOUBLE,NOT_FOUND"
    assert client.ask(START, b"") == b"\x00"
    assert client.ask(INPUTS, b"wind") == b"\x00NOT_FOUND"


def test_register_belongs_to_one_client_until_it_leaves(emulator: UrEmulator) -> None:
    first, second = connected(emulator), connected(emulator)
    assert first.ask(INPUTS, b"input_int_register_3") == b"\x01INT32"
    assert second.ask(INPUTS, b"input_int_register_3,input_int_register_4") == b"\x00IN_USE,INT32"
    assert first.ask(INPUTS, b"input_int_register_3") == b"\x02INT32"
    first.socket.close()
    deadline = time.monotonic() + 5
    while second.ask(INPUTS, b"input_int_register_3")[0] == 0:
        assert time.monotonic() < deadline


def test_stream_has_its_rate_and_stands_still_with_the_frozen_clock(emulator: UrEmulator) -> None:
    client = connected(emulator)
    client.ask(OUTPUTS, struct.pack(">d", 100) + b"timestamp")
    client.ask(START, b"")
    times = [struct.unpack(">Bd", client.next(DATA))[1] for _ in range(51)]
    assert np.diff(times).min() > 0
    assert (times[-1] - times[0]) / 20 == pytest.approx(0.5, abs=0.1)
    emulator.controller.arm.faults.set("frozen_timestamp")
    later = [struct.unpack(">Bd", client.next(DATA))[1] for _ in range(20)]
    assert len(set(later[5:])) == 1


def test_command_without_a_program_is_a_violation_and_counts_as_a_refused_motion(emulator: UrEmulator) -> None:
    client = connected(emulator)
    client.ask(INPUTS, b"input_int_register_0")
    client.socket.sendall(Packet(DATA, b"\x01" + struct.pack(">i", 3)).encoded())
    deadline = time.monotonic() + 5
    while not violations(emulator):
        assert time.monotonic() < deadline
    event = emulator.controller.arm.log.of_kind("violation")[0]
    assert (event["text"], event["refused_motion"]) == ("moveL without a running program", True)


def test_program_that_is_not_known_is_told_and_stops_the_one_that_runs(emulator: UrEmulator) -> None:
    c = emulator.controller
    c.start_program("def rtde_control():\nend\n")
    assert c.playing
    c.start_program("def dance():\n movej([0,0,0,0,0,0])\nend\n")
    assert "def dance" in violations(emulator)[0]
    assert not c.playing


def test_program_of_stops_alone_is_obeyed_without_a_violation(emulator: UrEmulator) -> None:
    c = emulator.controller
    c.start_program("def rtde_control():\nend\n")
    c.start_program("def halt():\n  stopl(2.0)\nend\n")
    assert not c.playing
    assert not violations(emulator)


def test_dashboard_answers_and_tells_what_it_does_not_know(emulator: UrEmulator) -> None:
    answers = ur_probe.ask_dashboard(emulator.host, "PolyscopeVersion", "is in remote control", "safetystatus", "sing")
    assert answers[0].startswith("URSoftware 5.11.0.")
    assert answers[1:3] == ["true", "Safetystatus: NORMAL"]
    assert "sing" in answers[3]
    assert "'sing'" in violations(emulator)[0]
    emulator.controller.arm.faults.set("protective_stop")
    assert ur_probe.ask_dashboard(emulator.host, "safetystatus") == ["Safetystatus: PROTECTIVE_STOP"]


def test_probe_reads_version_state_and_tool(emulator: UrEmulator) -> None:
    facts = ur_probe.ask_rtde(emulator.host)
    assert facts.version == (5, 11, 0, 108249)
    assert (facts.robot_mode, facts.safety_bits, facts.runtime_state) == (7, 1, 1)
    assert facts.T_tcp2flange is not None
    np.testing.assert_array_equal(facts.T_tcp2flange, emulator.controller.T_tcp2flange)


def test_probe_of_a_silent_controller_gives_up_and_says_so(emulator: UrEmulator) -> None:
    emulator.controller.arm.faults.set("silent_port")
    for ask in (ur_probe.ask_rtde, ur_probe.ask_dashboard):
        began = time.monotonic()
        with pytest.raises(RobotUnavailableError, match="does not answer"):
            ask(emulator.host)
        assert time.monotonic() - began < 3.5


def test_probe_of_nothing_is_refused_with_the_port() -> None:
    with pytest.raises(RobotUnavailableError, match=r"port 30004 \(RTDE\) refuses connections"):
        ur_probe.ask_rtde("127.0.0.254")


def test_probe_of_another_service_says_that_it_is_no_rtde(
    emulator: UrEmulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ur_probe, "RTDE_PORT", 29999)
    with pytest.raises(RobotUnavailableError, match="not RTDE"):
        ur_probe.ask_rtde(emulator.host)


def commanding(emulator: UrEmulator, offset: int) -> Client:
    """A client whose first recipe holds an integer and a double register, the program running and its watchdog set."""
    emulator.controller.start_program(f"def rtde_control():\nreg_offset_int = # int register offset\n{offset}\nend\n")
    client = connected(emulator)
    client.ask(INPUTS, f"input_int_register_{offset},input_double_register_{offset}".encode())
    client.socket.sendall(Packet(DATA, b"\x01" + struct.pack(">id", 35, 5.0)).encoded())
    while emulator.controller.registers.output(f"output_int_register_{offset}") != 2:
        time.sleep(0.005)
    return client


def stop_reasons(emulator: UrEmulator) -> list[str]:
    return [event["reason"] for event in emulator.controller.arm.log.of_kind("stop_condition")]


@pytest.mark.parametrize("offset", [0, 24])
def test_watchdog_ends_the_program_when_packages_stop_and_not_before(emulator: UrEmulator, offset: int) -> None:
    client = commanding(emulator, offset)
    for _ in range(30):
        last = time.monotonic()
        client.socket.sendall(Packet(DATA, b"\x01" + struct.pack(">id", 0, 0.0)).encoded())
        time.sleep(0.02)
    assert emulator.controller.playing
    assert stop_reasons(emulator) == []
    while emulator.controller.playing:
        assert time.monotonic() - last < 10
        time.sleep(0.005)
    assert time.monotonic() - last >= 0.2
    (event,) = emulator.controller.arm.log.of_kind("stop_condition")
    assert event["reason"] == "watchdog"
    assert event["text"] == f"no package with input_int_register_{offset} came for 0.2 s"


def test_watchdog_is_not_kicked_by_packages_without_its_variable(emulator: UrEmulator) -> None:
    client = commanding(emulator, 24)
    client.ask(INPUTS, b"input_int_register_0")
    deadline = time.monotonic() + 10
    while emulator.controller.playing:
        assert time.monotonic() < deadline
        client.socket.sendall(Packet(DATA, b"\x02" + struct.pack(">i", 0)).encoded())
        time.sleep(0.01)
    assert stop_reasons(emulator) == ["watchdog"]


def test_watchdog_ends_with_its_program(emulator: UrEmulator) -> None:
    commanding(emulator, 0)
    emulator.controller.stop_program()
    time.sleep(0.4)
    assert stop_reasons(emulator) == []
