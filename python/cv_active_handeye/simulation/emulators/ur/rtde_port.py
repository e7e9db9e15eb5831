# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""One RTDE connection: negotiation, the stream to the client, and the packages from it."""

from __future__ import annotations

import socket
import struct
import threading
import time

from ....robots import rtde_packets as rtde
from ....robots.rtde_packets import Packet, PacketError, PacketReader, Recipe
from ..server import ProtocolViolation
from .controller import UrController
from .rtde_packets import INPUT_TYPES, OUTPUT_TYPES, names_of, output_request, protocol_version

_LONGEST_INPUTS = 255  # recipes; their number is a byte


class Claims:
    """Which connection owns which input variable; a controller gives each to one client only."""

    def __init__(self) -> None:
        """Nobody owns any."""
        self._lock = threading.Lock()
        self._owners: dict[str, object] = {}

    def take(self, owner: object, names: tuple[str, ...]) -> set[str]:
        """Claims all of `names`, or none: returns those that belong to somebody else."""
        with self._lock:
            taken = {name for name in names if self._owners.get(name, owner) is not owner}
            if not taken:
                self._owners.update(dict.fromkeys(names, owner))
            return taken

    def release(self, owner: object) -> None:
        """Gives back all that `owner` has."""
        with self._lock:
            self._owners = {name: other for name, other in self._owners.items() if other is not owner}


class RtdeConnection:
    """Serves one client until it goes or breaks the protocol."""

    def __init__(self, connection: socket.socket, controller: UrController, claims: Claims) -> None:
        """`claims` is shared by all connections."""
        self._connection, self._controller, self._claims = connection, controller, claims
        self._sending = threading.Lock()
        self._outputs: Recipe | None = None
        self._frequency = 125.0
        self._inputs: list[Recipe] = []
        self._streaming = threading.Event()
        self._stream: threading.Thread | None = None

    def serve(self) -> None:
        """Reads packets; ProtocolViolation on the first that is wrong."""
        reader = PacketReader()
        try:
            while data := self._connection.recv(65536):
                for packet in reader.feed(data):
                    if not self._silent():
                        self._answer(packet)
        except PacketError as error:
            raise ProtocolViolation(str(error)) from error
        finally:
            self._pause()
            self._claims.release(self)

    def _answer(self, packet: Packet) -> None:
        payload = packet.payload
        if packet.kind == rtde.PROTOCOL:
            self._send(rtde.PROTOCOL, bytes([protocol_version(payload) == 2]))
        elif packet.kind == rtde.VERSION:
            self._send(rtde.VERSION, struct.pack(">4I", *self._controller.version))
        elif packet.kind == rtde.OUTPUTS:
            self._frequency, names = output_request(payload)
            self._outputs = Recipe(names, tuple(OUTPUT_TYPES.get(name, rtde.NOT_FOUND) for name in names))
            self._send(rtde.OUTPUTS, b"\x01" + ",".join(self._outputs.types).encode())
        elif packet.kind == rtde.INPUTS:
            self._add_inputs(names_of(payload))
        elif packet.kind == rtde.START:
            self._start()
        elif packet.kind == rtde.PAUSE:
            self._pause()
            self._send(rtde.PAUSE, b"\x01")
        elif packet.kind == rtde.DATA:
            self._receive(payload)

    def _add_inputs(self, names: tuple[str, ...]) -> None:
        if len(self._inputs) >= _LONGEST_INPUTS:
            raise PacketError(f"input recipes: needs at most {_LONGEST_INPUTS}")
        types = tuple(INPUT_TYPES.get(name, rtde.NOT_FOUND) for name in names)
        taken = self._claims.take(self, names) | self._fieldbus(names)
        if taken:
            types = tuple(rtde.IN_USE if name in taken else kind for name, kind in zip(names, types, strict=True))
        self._inputs.append(Recipe(names, types))
        number = len(self._inputs) if self._inputs[-1].valid else 0
        self._send(rtde.INPUTS, bytes([number]) + ",".join(types).encode())

    def _fieldbus(self, names: tuple[str, ...]) -> set[str]:
        if not self._controller.arm.faults.value("register_conflict"):
            return set()
        return {name for name in names if "_register_" in name and int(name.rsplit("_", 1)[1]) < 24}

    def _receive(self, payload: bytes) -> None:
        number = payload[0] if payload else 0
        if not 1 <= number <= len(self._inputs) or not self._inputs[number - 1].valid:
            raise PacketError(f"package: needs the number of an input recipe, given {number}")
        self._controller.write_inputs(self._inputs[number - 1].unpack(payload[1:]))

    def _start(self) -> None:
        ready = self._outputs is not None and self._outputs.valid
        self._send(rtde.START, bytes([ready]))
        if ready and self._stream is None:
            self._streaming.set()
            self._stream = threading.Thread(target=self._run_stream, name="RTDE stream", daemon=True)
            self._stream.start()

    def _pause(self) -> None:
        self._streaming.clear()
        if self._stream is not None:
            self._stream.join(2.0)
            self._stream = None

    def _run_stream(self) -> None:
        recipe = self._outputs
        due = time.monotonic()
        while self._streaming.is_set() and recipe is not None:
            if not self._silent():
                snapshot = self._controller.snapshot()
                values = [self._controller.value(name, snapshot) for name in recipe.names]
                try:
                    self._send(rtde.DATA, b"\x01" + recipe.pack(values))
                except OSError:
                    return
            due = max(due + 1 / self._frequency, time.monotonic() - 0.1)
            time.sleep(max(due - time.monotonic(), 0.0))

    def _send(self, kind: int, payload: bytes) -> None:
        with self._sending:
            self._connection.sendall(Packet(kind, payload).encoded())

    def _silent(self) -> bool:
        return bool(self._controller.arm.faults.value("silent_port"))
