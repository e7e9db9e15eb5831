# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A TCP port of an emulator: a thread per connection, all of which end when it is closed."""

from __future__ import annotations

import errno
import socket
import threading
from collections.abc import Callable
from contextlib import suppress

from .log import EventLog

_JOIN = 2.0  # s that a connection's thread may take to end


class ProtocolViolation(Exception):  # noqa: N818 (names what a client did, not an error of the emulator)
    """The client broke the protocol; its connection is closed and the log says why."""


class ListenError(OSError):
    """A port that cannot be listened on; `service` and `port` say which."""

    def __init__(self, service: str, host: str, port: int, error: OSError) -> None:
        """`error`: what the system said."""
        taken = error.errno == errno.EADDRINUSE
        reason = "is in use, by another emulator perhaps" if taken else f"cannot be listened on ({error})"
        super().__init__(f"{host}: port {port} ({service}) {reason}")
        self.service, self.port, self.taken = service, port, taken


class Server:
    """Listens on `host` and `port` (0 = chosen) and runs `serve` for every connection in a thread of its own.

    `serve` returns, or raises OSError, when the connection is over, and ProtocolViolation when the client is to blame.
    Connections beyond `limit` are closed at once.
    """

    def __init__(
        self, host: str, port: int, service: str, serve: Callable[[socket.socket], None], log: EventLog, limit: int = 8
    ) -> None:
        """Begins to listen; ListenError where it cannot."""
        self._service, self._serve, self._log, self._limit = service, serve, log, limit
        self._lock = threading.Lock()
        self._connections: set[socket.socket] = set()
        self._threads: list[threading.Thread] = []
        self._closing = False
        try:
            self._socket = socket.create_server((host, port))
        except OSError as error:
            raise ListenError(service, host, port, error) from error
        self.port: int = self._socket.getsockname()[1]
        self._acceptor = threading.Thread(target=self._accept, name=f"{service} port", daemon=True)
        self._acceptor.start()

    def drop(self) -> None:
        """Closes every connection there is."""
        with self._lock:
            connections = list(self._connections)
        for connection in connections:
            _shut(connection)

    def close(self) -> None:
        """Stops listening, closes every connection, and waits for their threads."""
        with self._lock:
            self._closing = True
        _shut(self._socket)
        self._socket.close()
        self._acceptor.join(_JOIN)
        self.drop()
        for thread in self._threads:
            if thread is not threading.current_thread():
                thread.join(_JOIN)

    def _accept(self) -> None:
        while True:
            try:
                connection, address = self._socket.accept()
            except OSError:
                return
            with self._lock:
                refused = self._closing or len(self._connections) >= self._limit
                if not refused:
                    thread = threading.Thread(target=self._run, args=(connection, f"{address[0]}:{address[1]}"))
                    thread.daemon = True
                    self._connections.add(connection)
                    self._threads = [*(other for other in self._threads if other.is_alive()), thread]
                    thread.start()
            if refused:
                connection.close()

    def _run(self, connection: socket.socket, peer: str) -> None:
        self._log.add("connect", service=self._service, peer=peer)
        try:
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._serve(connection)
        except ProtocolViolation as error:
            self._log.add("violation", text=f"{self._service}: {error}")
        except OSError:
            pass  # the client is gone
        finally:
            with self._lock:
                self._connections.discard(connection)
            _shut(connection)
            connection.close()
            self._log.add("disconnect", service=self._service, peer=peer)


def _shut(connection: socket.socket) -> None:
    with suppress(OSError):
        connection.shutdown(socket.SHUT_RDWR)


class Lines:
    """The lines of a connection, each at most `longest` bytes; a longer one is a ProtocolViolation."""

    def __init__(self, connection: socket.socket, longest: int = 65536) -> None:
        """Reads from `connection`."""
        self._connection, self._longest = connection, longest
        self._buffer = b""

    def read(self) -> bytes | None:
        """Returns the next line without its end, None when the connection is over."""
        while b"\n" not in self._buffer:
            if len(self._buffer) > self._longest:
                raise ProtocolViolation(f"a line of more than {self._longest} bytes")
            block = self._connection.recv(4096)
            if not block:
                return None
            self._buffer += block
        line, self._buffer = self._buffer.split(b"\n", 1)
        return line
