# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The control port of an emulator, and its log."""

from __future__ import annotations

import json
import socket
import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from cv_active_handeye.simulation import CellConfig
from cv_active_handeye.simulation.emulators import (
    ControlPort,
    EmulatedArm,
    EmulatorLink,
    EmulatorLinkError,
    EventLog,
    read_events,
)

pytestmark = pytest.mark.timeout(60)
CELL = CellConfig(robot="ur5e", seed=4)


class Emulator:
    def __init__(self) -> None:
        self.arm = EmulatedArm(CELL, speedup=50, log=EventLog())
        self.ended = threading.Event()
        self.port = ControlPort(self.arm, "127.0.0.1", 0, self.ended.set)

    def link(self) -> EmulatorLink:
        return EmulatorLink(port=self.port.port)


@pytest.fixture
def emulator() -> Iterator[Emulator]:
    threads = threading.active_count()
    emulator = Emulator()
    yield emulator
    emulator.port.close()
    emulator.arm.close()
    assert threading.active_count() == threads


def raw(emulator: Emulator, data: bytes) -> bytes:
    """What comes back for bytes on a connection of their own, until it is closed or silent."""
    with socket.create_connection(("127.0.0.1", emulator.port.port), 5) as connection:
        try:
            connection.sendall(data)
            connection.shutdown(socket.SHUT_WR)
            answer = b""
            while block := connection.recv(65536):
                answer += block
        except ConnectionError:
            return b""
        return answer


def test_state_and_cell_say_what_the_arm_knows(emulator: Emulator) -> None:
    with emulator.link() as link:
        emulator.arm.set_output(2, True)
        state = link.state()
        np.testing.assert_array_equal(state.T_true, emulator.arm.true_pose())
        np.testing.assert_array_equal(state.T_reported, emulator.arm.reported_pose())
        np.testing.assert_array_equal(state.joints, emulator.arm.joints)
        assert (state.moving, state.steady, state.stop_index, state.speedup) == (False, True, 0, 50)
        assert [pin for pin, on in state.outputs.items() if on] == [2]
        assert link.cell() == CELL


def test_fault_clear_and_quit_reach_the_emulator(emulator: Emulator) -> None:
    with emulator.link() as link:
        link.fault("protective_stop")
        assert link.state().stop_condition == "protective stop"
        link.fault("pose_bias", 1.5)
        assert emulator.arm.faults.value("pose_bias") == 1.5
        link.clear()
        assert link.state().stop_condition is None
        assert not emulator.arm.faults.value("pose_bias")
        link.plan_fault("slow_settling=2@stop1")
        with pytest.raises(EmulatorLinkError, match=r"needs one of .*; given 'earthquake'"):
            link.fault("earthquake")
        link.quit()
    assert emulator.ended.wait(5)


def test_hold_begins_anew_when_an_output_is_switched(emulator: Emulator) -> None:
    with emulator.link() as link:
        link.hold(True)
        link.rendered(0, 0)
        emulator.arm.set_output(3, True)
        emulator.arm.set_output(3, True)  # no change, nothing to render
        seen = link.state()
        assert not seen.steady
        assert (seen.switchings, seen.outputs[3]) == (1, True)
        link.rendered(0, 0)  # what was under way before the switching
        assert not link.state().steady
        link.rendered(0, 1)
        assert link.state().steady


def test_hold_lasts_until_rendered_and_ends_with_its_connection(emulator: Emulator) -> None:
    with emulator.link() as link:
        link.hold(True)
        assert not link.state().steady
        link.rendered(0, 0)
        assert link.state().steady
    with emulator.link() as link:
        link.hold(True)
        move = threading.Event()
        target = emulator.arm.reported_pose()
        target[2, 3] += 0.001
        emulator.arm.move_linear(target, 0.1, 1.0, move)
    for _ in range(100):
        if emulator.arm.steady():
            break
        move.wait(0.02)
    assert emulator.arm.steady()


@pytest.mark.parametrize(
    "line",
    [
        *(b"\xff\xfe\x00", b"{", b"[]", b"7", b"[" * 60000, b'{"cmd": {}}', b'{"cmd": "hold"}'),
        *(b'{"cmd": "rendered", "stop": true}', b'{"cmd": "fault", "name": "pose_bias", "value": []}'),
    ],
)
def test_garbage_line_is_answered_with_an_error_and_the_port_lives_on(emulator: Emulator, line: bytes) -> None:
    answers = raw(emulator, line + b'\n{"cmd": "state"}\n').splitlines()
    assert [json.loads(answer)["ok"] for answer in answers] == [False, True]


def test_huge_line_closes_the_connection_as_a_violation(emulator: Emulator) -> None:
    assert raw(emulator, b"x" * 5_000_000) == b""
    for _ in range(100):
        if emulator.arm.log.of_kind("disconnect"):
            break
        threading.Event().wait(0.02)
    assert "65536 bytes" in emulator.arm.log.of_kind("violation")[0]["text"]
    with emulator.link() as link:
        assert link.state().stop_index == 0


def test_link_says_that_no_emulator_runs() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    with pytest.raises(EmulatorLinkError, match=f"127.0.0.1:{port}.*cv-active-handeye emulate"):
        EmulatorLink(port=port)


def test_link_to_a_silent_port_gives_up_after_its_timeout() -> None:
    with (
        socket.create_server(("127.0.0.1", 0)) as server,
        EmulatorLink(port=server.getsockname()[1], timeout=0.1) as link,
        pytest.raises(EmulatorLinkError, match="no answer to 'state'"),
    ):
        link.state()


def test_event_log_keeps_the_order_of_all_threads_in_memory_and_file(tmp_path: Path) -> None:
    log = EventLog(tmp_path / "log.jsonl")

    def write(name: str) -> None:
        for i in range(200):
            log.add("command", name=name, args=i)

    threads = [threading.Thread(target=write, args=(str(k),)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    log.close()
    events = log.events
    assert read_events(tmp_path / "log.jsonl") == events
    times = [event["time"] for event in events]
    assert times == sorted(times)
    for k in range(4):
        assert [event["args"] for event in events if event["name"] == str(k)] == list(range(200))
    with (tmp_path / "log.jsonl").open("a") as file:
        file.write('{"kind": "comm')
    assert read_events(tmp_path / "log.jsonl") == events
