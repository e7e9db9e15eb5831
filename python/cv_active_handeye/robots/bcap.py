# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""b-CAP over TCP: one connection to a DENSO controller, one call at a time, every call within its deadline."""

from __future__ import annotations

import contextlib
import select
import socket
import threading
import time
from typing import NoReturn

from .base import RobotError
from .bcap_codes import Function, Result, is_failure, result_meaning, result_name
from .bcap_packets import Packet, PacketError, PacketStream, Value, encode_packet
from .waiting import WatchedTime, watched_waits

PORT = 5007
KEEP_ALIVE_S = 0.2
"""How often the controller is asked to say that a long call is still being worked on (S_EXECUTING)."""
SILENCE_S = 1.0
"""Longest silence during a call, several times KEEP_ALIVE_S; longer calls need only their keep-alives."""

_CONNECT_S = 2.0
_CLOSE_S = 0.5
_CHUNK = 1 << 16


class BcapError(RobotError):
    """The controller refused a call. code: HRESULT, unsigned; description: the controller's own text, if asked."""

    def __init__(self, code: int, what: str, description: str = "") -> None:
        """`what` names the call."""
        self.code, self.what, self.description = code, what, description
        meaning = description or result_meaning(code)
        super().__init__(f"{what}: {result_name(code)} {code:#010x}" + (f" ({meaning})" if meaning else ""))


class BcapLinkError(RobotError):
    """The connection is gone, silent or garbled; it cannot be used again."""


class BcapClient:
    """One TCP connection with its service started; may be used from several threads, calls take turns.

    executing: how many keep-alives have come so far. After a BcapLinkError the connection is closed.
    """

    def __init__(
        self, host: str, port: int = PORT, *, keep_alive_s: float = KEEP_ALIVE_S, silence_s: float = SILENCE_S
    ) -> None:
        """Connects within 2 s and starts the service within another 2 s; BcapLinkError or BcapError otherwise."""
        self.address = f"{host}:{port}"
        self.executing = 0
        self._silence_s, self._serial = silence_s, 0
        self._lock, self._stream = threading.Lock(), PacketStream()
        self._closed = False
        try:
            self._socket = socket.create_connection((host, port), timeout=_CONNECT_S)
        except OSError as error:
            raise BcapLinkError(f"{self.address}: cannot be reached ({error})") from error
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        try:
            self.call(Function.SERVICE_START, f",WDT={round(1000 * keep_alive_s)},InvokeTimeout=180000")
        except RobotError:
            self.abort()
            raise

    def call(self, function: Function, *arguments: Value, deadline_s: float = 2.0) -> Value:
        """Asks and returns what the controller answers, at most `deadline_s` after the connection is free.

        Another call may hold the connection; that wait has the same limit. BcapError where the controller refuses,
        BcapLinkError where the link fails or the time is over: the connection is then closed.
        """
        pending = self.begin(function, *arguments, wait_s=deadline_s)
        return pending.result(deadline_s)

    def begin(self, function: Function, *arguments: Value, wait_s: float = 2.0) -> PendingCall:
        """Sends a request and returns without waiting for its answer; the connection is taken until that is there.

        Waits for another call's end at most `wait_s`: BcapLinkError.
        """
        what = f"{self.address}: {_title(function, arguments)}"
        if not any(self._lock.acquire(timeout=wait) for wait in watched_waits(wait_s)):
            raise BcapLinkError(f"{what}: another call has kept the connection busy for {wait_s:g} s")
        self._serial = self._serial % 65535 + 1
        try:
            self._send(encode_packet(Packet(self._serial, function, arguments)), what, wait_s)
        except BaseException:
            self._lock.release()
            raise
        return PendingCall(self, self._serial, what)

    def abort(self) -> None:
        """Closes the connection at once, without a word to the controller; calls under way end with BcapLinkError."""
        self._closed = True
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()

    def close(self) -> None:
        """Stops the service and closes the connection within 0.5 s; never raises."""
        if not self._closed:
            with contextlib.suppress(RobotError):
                self.call(Function.SERVICE_STOP, deadline_s=_CLOSE_S)
        self.abort()

    @property
    def closed(self) -> bool:
        """Whether no call can be made any more."""
        return self._closed

    def _send(self, data: bytes, what: str, wait_s: float) -> None:
        if self._closed:
            raise BcapLinkError(f"{what}: the connection was closed")
        try:
            self._socket.settimeout(wait_s)
            self._socket.sendall(data)
        except OSError as error:
            self.abort()
            raise BcapLinkError(f"{what}: cannot be sent ({error})") from error

    def _receive(self, what: str, wait_s: float) -> list[Packet]:
        """The packets that have come within `wait_s`, none if nothing came."""
        if self._closed:
            raise BcapLinkError(f"{what}: the connection was closed")
        try:
            if not select.select([self._socket], [], [], max(wait_s, 0.0))[0]:
                return []
            data = self._socket.recv(_CHUNK)
            if data:
                return self._stream.feed(data)
            reason = "the controller closed the connection"
        except PacketError as error:
            reason = f"the answer is no b-CAP packet: {error}"
        except (OSError, ValueError) as error:  # ValueError: select on a socket that another thread closed
            reason = str(error)
        self.abort()
        raise BcapLinkError(f"{what}: {reason}")


class PendingCall:
    """A request whose answer has not come yet. The connection is free again when `poll` returned True or raised."""

    def __init__(self, client: BcapClient, serial: int, what: str) -> None:
        self._client, self._serial, self._what = client, serial, what
        self._silence = WatchedTime(time.monotonic())
        self._answer: Packet | None = None
        self._held = True

    def poll(self, wait_s: float) -> bool:
        """Whether the answer is there, waiting `wait_s` at most; BcapLinkError where the link fails or is silent.

        A pause of this process counts as no time, here and in all that waits for the controller.
        """
        for wait in watched_waits(wait_s):
            if self._read(wait):
                return True
            if self._silence.look(time.monotonic()) > self._client._silence_s:
                self.give_up(f"silent for {self._client._silence_s:g} s")
        return False

    def result(self, deadline_s: float) -> Value:
        """The answer, after `deadline_s` at most; BcapError where the controller refused, else BcapLinkError."""
        if not self.poll(deadline_s):
            self.give_up(f"no answer within {deadline_s:g} s")
        assert self._answer is not None
        if is_failure(self._answer.code):
            raise BcapError(self._answer.code, self._what)
        return self._answer.arguments[0] if self._answer.arguments else None

    def give_up(self, reason: str) -> NoReturn:
        """Closes the connection, for a late answer would be taken for that of the next call: BcapLinkError."""
        self._client.abort()
        self._release()
        raise BcapLinkError(f"{self._what}: {reason}")

    def _read(self, wait_s: float) -> bool:
        """Takes what comes within `wait_s`; whether the answer is there."""
        if self._answer is not None:
            return True
        try:
            packets = self._client._receive(self._what, wait_s)
        except BcapLinkError:
            self._release()
            raise
        for packet in packets:
            if packet.serial != self._serial:
                continue
            self._silence.restart(time.monotonic())
            if packet.code == Result.S_EXECUTING:
                self._client.executing += 1
            else:
                self._answer = packet
                self._release()
        return self._answer is not None

    def _release(self) -> None:
        if self._held:
            self._held = False
            self._client._lock.release()


def _title(function: Function, arguments: tuple[Value, ...]) -> str:
    """The function and, where there is one, the command or name it is called with."""
    name = next((argument for argument in arguments if isinstance(argument, str) and argument), None)
    return f"{function.name}" + (f" {name}" if name and function != Function.SERVICE_START else "")
