# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The b-CAP client against servers that do one thing each: deadlines, keep-alives, errors, damage."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest

from cv_active_handeye.robots.bcap import BcapClient, BcapError, BcapLinkError
from cv_active_handeye.robots.bcap_codes import Function, Result
from cv_active_handeye.robots.bcap_packets import Packet, PacketStream, encode_packet
from cv_active_handeye.simulation.emulators import EventLog, Server

pytestmark = pytest.mark.timeout(60)
Send = Callable[[Packet], None]
Script = Callable[[Packet, socket.socket, Send], None]


@contextmanager
def serving(script: Script) -> Iterator[int]:
    """A server that starts and stops the service and leaves every other request to `script`; gives its port."""

    def serve(connection: socket.socket) -> None:
        stream = PacketStream()

        def send(packet: Packet) -> None:
            connection.sendall(encode_packet(packet))

        while data := connection.recv(65536):
            for request in stream.feed(data):
                if request.code in (Function.SERVICE_START, Function.SERVICE_STOP):
                    send(Packet(request.serial, 0))
                else:
                    script(request, connection, send)

    server = Server("127.0.0.1", 0, "test", serve, EventLog())
    try:
        yield server.port
    finally:
        server.close()


def silent(request: Packet, connection: socket.socket, send: Send) -> None:
    pass


def echo(request: Packet, connection: socket.socket, send: Send) -> None:
    send(Packet(request.serial, 0, (list(request.arguments),)))


def test_call_returns_the_first_argument_of_the_answer() -> None:
    with serving(echo) as port:
        client = BcapClient("127.0.0.1", port)
        assert client.call(Function.ROBOT_EXECUTE, 3, "CurPos", None) == [3, "CurPos", None]
        client.close()
        assert client.closed


def test_call_without_an_answer_ends_at_its_deadline_and_closes_the_connection() -> None:
    with serving(silent) as port:
        client = BcapClient("127.0.0.1", port)
        began = time.monotonic()
        with pytest.raises(BcapLinkError, match=r"ROBOT_EXECUTE CurPos: no answer within 0\.2 s"):
            client.call(Function.ROBOT_EXECUTE, 3, "CurPos", deadline_s=0.2)
        assert 0.2 <= time.monotonic() - began < 1.0
        with pytest.raises(BcapLinkError, match="closed"):
            client.call(Function.ROBOT_EXECUTE, 3, "CurPos")


def test_keep_alives_carry_a_call_beyond_the_longest_silence() -> None:
    def slow(request: Packet, connection: socket.socket, send: Send) -> None:
        for _ in range(8):
            time.sleep(0.1)
            send(Packet(request.serial, Result.S_EXECUTING))
        send(Packet(request.serial, 0, (5,)))

    with serving(slow) as port:
        client = BcapClient("127.0.0.1", port, silence_s=0.4)
        assert client.call(Function.ROBOT_MOVE, 3, deadline_s=10.0) == 5
        assert client.executing == 8
        client.close()


def test_keep_alives_do_not_carry_a_call_beyond_its_deadline() -> None:
    def forever(request: Packet, connection: socket.socket, send: Send) -> None:
        for _ in range(20):
            send(Packet(request.serial, Result.S_EXECUTING))
            time.sleep(0.05)

    with serving(forever) as port:
        client = BcapClient("127.0.0.1", port)
        began = time.monotonic()
        with pytest.raises(BcapLinkError, match=r"no answer within 0\.3 s"):
            client.call(Function.ROBOT_MOVE, 3, deadline_s=0.3)
        assert time.monotonic() - began < 0.8


def test_silence_ends_a_long_call_before_its_deadline() -> None:
    with serving(silent) as port:
        client = BcapClient("127.0.0.1", port, silence_s=0.3)
        began = time.monotonic()
        with pytest.raises(BcapLinkError, match=r"silent for 0\.3 s"):
            client.call(Function.ROBOT_MOVE, 3, deadline_s=30.0)
        assert time.monotonic() - began < 1.0


def test_answer_with_another_serial_is_not_taken() -> None:
    def late(request: Packet, connection: socket.socket, send: Send) -> None:
        send(Packet(request.serial % 65535 + 7, 0, ("wrong",)))
        send(Packet(request.serial, 0, ("right",)))

    with serving(late) as port:
        client = BcapClient("127.0.0.1", port)
        assert client.call(Function.ROBOT_EXECUTE, 3, "X") == "right"
        client.close()


def test_refusal_has_code_name_and_meaning() -> None:
    def refuse(request: Packet, connection: socket.socket, send: Send) -> None:
        send(Packet(request.serial, int(str(request.arguments[1]), 16)))

    with serving(refuse) as port:
        client = BcapClient("127.0.0.1", port)
        with pytest.raises(BcapError, match=r"E_NOTIMPL 0x80004001 .*does not have this function") as caught:
            client.call(Function.ROBOT_EXECUTE, 3, "80004001")
        assert caught.value.code == Result.E_NOTIMPL
        with pytest.raises(BcapError, match=r"ROBOT_EXECUTE 84204050: motion error 0x84204050$"):
            client.call(Function.ROBOT_EXECUTE, 3, "84204050")
        with pytest.raises(BcapError, match=r"controller error 0x83201999$"):
            client.call(Function.ROBOT_EXECUTE, 3, "83201999")
        client.close()


@pytest.mark.parametrize(
    "damage", [b"HTTP/1.1 400", b"\x01\xff\xff\xff\xff", b"\x01\x10\x00\x00\x00" + bytes(10) + b"\x07"]
)
def test_damaged_answer_ends_the_link_with_its_reason(damage: bytes) -> None:
    with serving(lambda request, connection, send: connection.sendall(damage)) as port:
        client = BcapClient("127.0.0.1", port)
        with pytest.raises(BcapLinkError, match="no b-CAP packet: packet: needs"):
            client.call(Function.ROBOT_EXECUTE, 3, "X")
        assert client.closed


def test_connection_that_the_controller_closes_is_told() -> None:
    with serving(lambda request, connection, send: connection.shutdown(socket.SHUT_RDWR)) as port:
        client = BcapClient("127.0.0.1", port)
        with pytest.raises(BcapLinkError, match="closed the connection"):
            client.call(Function.ROBOT_EXECUTE, 3, "X")


def test_nobody_listening_is_told_at_once() -> None:
    with serving(silent) as port:
        pass
    with pytest.raises(BcapLinkError, match="cannot be reached"):
        BcapClient("127.0.0.1", port)


def test_a_port_that_accepts_and_stays_silent_does_not_hang_the_connection() -> None:
    listener = socket.create_server(("127.0.0.1", 0))
    began = time.monotonic()
    with pytest.raises(BcapLinkError, match=r"SERVICE_START: silent for 0\.3 s"):
        BcapClient("127.0.0.1", listener.getsockname()[1], silence_s=0.3)
    assert time.monotonic() - began < 1.5
    listener.close()


def test_begin_leaves_the_caller_free_and_the_connection_taken() -> None:
    go = threading.Event()

    def wait(request: Packet, connection: socket.socket, send: Send) -> None:
        if request.code == Function.ROBOT_MOVE:
            go.wait(5)
        send(Packet(request.serial, 0, (request.code,)))

    with serving(wait) as port:
        client = BcapClient("127.0.0.1", port)
        pending = client.begin(Function.ROBOT_MOVE, 3)
        assert not pending.poll(0.05)
        with pytest.raises(BcapLinkError, match="kept the connection busy"):
            client.call(Function.ROBOT_EXECUTE, 3, "X", deadline_s=0.1)
        go.set()
        assert pending.poll(2.0)
        assert pending.result(0.0) == Function.ROBOT_MOVE
        assert client.call(Function.ROBOT_EXECUTE, 3, "X") == Function.ROBOT_EXECUTE
        client.close()


def test_abort_from_another_thread_ends_a_call_under_way() -> None:
    with serving(silent) as port:
        client = BcapClient("127.0.0.1", port, silence_s=20.0)
        timer = threading.Timer(0.2, client.abort)
        timer.start()
        began = time.monotonic()
        with pytest.raises(BcapLinkError):
            client.call(Function.ROBOT_MOVE, 3, deadline_s=20.0)
        assert time.monotonic() - began < 2.0
        timer.join()


def test_calls_of_many_threads_take_turns_and_get_their_own_answers() -> None:
    with serving(echo) as port:
        client = BcapClient("127.0.0.1", port)
        wrong: list[object] = []

        def ask(number: int) -> None:
            for i in range(50):
                answer = client.call(Function.ROBOT_EXECUTE, number, str(i))
                if answer != [number, str(i)]:
                    wrong.append(answer)

        threads = [threading.Thread(target=ask, args=(number,)) for number in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert wrong == []
        client.close()
