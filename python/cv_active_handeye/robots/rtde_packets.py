# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""RTDE (real-time data exchange), protocol version 2: packets and recipes, without any connection.

A packet is a big-endian u16 size (header of 3 bytes included), a type byte and a payload. Source: Universal Robots,
"Real-Time Data Exchange (RTDE) Guide". What cannot be parsed is a PacketError.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

HEADER = 3
LONGEST = 8192
"""Bytes of the longest packet that is accepted; the longest of ur_rtde's is a quarter of it."""

PROTOCOL, VERSION, TEXT, DATA = ord("V"), ord("v"), ord("M"), ord("U")
OUTPUTS, INPUTS, START, PAUSE = ord("O"), ord("I"), ord("S"), ord("P")
_TYPES = {PROTOCOL, VERSION, TEXT, DATA, OUTPUTS, INPUTS, START, PAUSE}

FORMATS = {
    "BOOL": "?",
    "UINT8": "B",
    "UINT32": "I",
    "UINT64": "Q",
    "INT32": "i",
    "DOUBLE": "d",
    "VECTOR3D": "3d",
    "VECTOR6D": "6d",
    "VECTOR6INT32": "6i",
}
"""struct's letters for RTDE's types."""

NOT_FOUND, IN_USE = "NOT_FOUND", "IN_USE"

Value = float | int | bool | tuple[float | int, ...]


class PacketError(ValueError):
    """Bytes that are no RTDE of protocol version 2."""


@dataclass(frozen=True)
class Packet:
    """kind: a type byte; payload: what follows the header."""

    kind: int
    payload: bytes

    def encoded(self) -> bytes:
        """The bytes on the wire."""
        return struct.pack(">HB", HEADER + len(self.payload), self.kind) + self.payload


class PacketReader:
    """Cuts a stream of bytes into packets; holds at most one unfinished packet."""

    def __init__(self) -> None:
        """Nothing read so far."""
        self._buffer = b""

    def feed(self, data: bytes) -> Iterator[Packet]:
        """Yields the packets that `data` completes; PacketError on a size or type that cannot be."""
        self._buffer += data
        while len(self._buffer) >= HEADER:
            size, kind = struct.unpack_from(">HB", self._buffer)
            if not HEADER <= size <= LONGEST:
                raise PacketError(f"packet size: needs {HEADER} to {LONGEST}, given {size}")
            if kind not in _TYPES:
                raise PacketError(f"packet type: needs one of {bytes(sorted(_TYPES))!r}, given {kind}")
            if len(self._buffer) < size:
                return
            packet, self._buffer = Packet(kind, self._buffer[HEADER:size]), self._buffer[size:]
            yield packet


@dataclass(frozen=True)
class Recipe:
    """Variables in the order in which they are packed."""

    names: tuple[str, ...]
    types: tuple[str, ...]

    @property
    def valid(self) -> bool:
        """Whether the controller has all of them."""
        return all(kind in FORMATS for kind in self.types)

    @property
    def format(self) -> str:
        """struct's format of one package."""
        return ">" + "".join(FORMATS[kind] for kind in self.types)

    def pack(self, values: Sequence[Value]) -> bytes:
        """The values, one per variable, as bytes."""
        flat = [x for value in values for x in (value if isinstance(value, tuple) else (value,))]
        return struct.pack(self.format, *flat)

    def unpack(self, payload: bytes) -> dict[str, Value]:
        """The values by name; PacketError where the size does not fit."""
        size = struct.calcsize(self.format)
        if len(payload) != size:
            raise PacketError(f"package of {', '.join(self.names)}: needs {size} bytes, given {len(payload)}")
        flat = list(struct.unpack(self.format, payload))
        out: dict[str, Value] = {}
        for name, kind in zip(self.names, self.types, strict=True):
            count = 6 if kind.startswith("VECTOR6") else 3 if kind == "VECTOR3D" else 1
            values, flat = flat[:count], flat[count:]
            out[name] = values[0] if count == 1 else tuple(values)
        return out
