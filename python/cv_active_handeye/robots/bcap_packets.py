# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""b-CAP packets of DENSO controllers: bytes to values and back.

Layout after DENSO's "b-CAP communication specifications", all little endian:
`01 | u32 length | u16 serial | u16 reserved | u32 function or HRESULT | u16 count | count x {u32 size, VARIANT} | 04`,
VARIANT = `u16 type | u32 count | data`. Whatever comes in, decoding ends with a packet or a PacketError, in time and
memory proportional to the bytes.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import TypeAlias

Value: TypeAlias = bool | int | float | str | bytes | Sequence["Value"] | None
"""What a VARIANT holds here; arrays are lists, an array of bytes is `bytes`."""

MAX_PACKET = 16 << 20
MAX_VALUES = 1 << 20  # of a packet: a byte of an array can cost a whole Python object
MAX_DEPTH = 8
HEAD, LEAST = 5, 16

_SOH, _EOT, _ARRAY = 0x01, 0x04, 0x2000
_MIDDLE = struct.Struct("<HHIH")


class PacketError(ValueError):
    """Bytes that are no b-CAP packet; the text says what was needed and what was found."""


class Type(IntEnum):
    """Types of a VARIANT."""

    EMPTY, NULL, I2, I4, R4, R8, CY, DATE, BSTR = range(9)
    ERROR, BOOL, VARIANT = 10, 11, 12
    UI1, UI2, UI4, I8, UI8 = 17, 18, 19, 20, 21


_KNOWN = frozenset(Type)
_NUMBERS = {
    Type.I2: "h",
    Type.I4: "i",
    Type.R4: "f",
    Type.R8: "d",
    Type.CY: "q",
    Type.DATE: "d",
    Type.ERROR: "i",
    Type.BOOL: "h",
    Type.UI1: "B",
    Type.UI2: "H",
    Type.UI4: "I",
    Type.I8: "q",
    Type.UI8: "Q",
}


@dataclass(frozen=True)
class Packet:
    """serial: 1 to 65535; code: function of a request, HRESULT of a reply, unsigned; reserved: 0 over TCP."""

    serial: int
    code: int
    arguments: tuple[Value, ...] = ()
    reserved: int = 0


def encode_packet(packet: Packet) -> bytes:
    """Bytes of a packet: int as I4 (I8, UI8 where too large), float as R8, None as EMPTY, lists as arrays.

    Lists of one kind become arrays of that type, all others arrays of VARIANT. ValueError or TypeError name what has no
    place in a packet.
    """
    body = bytearray()
    for argument in packet.arguments:
        data = _encode(argument)
        body += struct.pack("<I", len(data)) + data
    if LEAST + len(body) > MAX_PACKET:
        raise ValueError(f"packet: needs at most {MAX_PACKET} bytes, given {LEAST + len(body)}")
    middle = _MIDDLE.pack(packet.serial, packet.reserved, packet.code, len(packet.arguments))
    return struct.pack("<BI", _SOH, LEAST + len(body)) + middle + bytes(body) + bytes([_EOT])


def packet_size(head: bytes) -> int:
    """Size of the packet that begins with these 5 bytes; PacketError where none can begin so."""
    if len(head) < HEAD:
        raise PacketError(f"packet: needs {HEAD} bytes at least, got {len(head)}")
    start, size = struct.unpack_from("<BI", head)
    if start != _SOH:
        raise PacketError(f"packet: needs to begin with {_SOH:#04x}, got {start:#04x}")
    if not LEAST <= size <= MAX_PACKET:
        raise PacketError(f"packet: needs a length from {LEAST} to {MAX_PACKET}, got {size}")
    return int(size)


def decode_packet(data: bytes) -> Packet:
    """The packet that these bytes are, all of them; PacketError otherwise."""
    if packet_size(data[:HEAD]) != len(data):
        raise PacketError(f"packet: says {packet_size(data[:HEAD])} bytes, got {len(data)}")
    if data[-1] != _EOT:
        raise PacketError(f"packet: needs to end with {_EOT:#04x}, got {data[-1]:#04x}")
    serial, reserved, code, count = _MIDDLE.unpack_from(data, HEAD)
    reader = _Reader(data, HEAD + _MIDDLE.size, len(data) - 1)
    arguments = tuple(reader.argument(i) for i in range(count))
    if reader.at != reader.end:
        raise PacketError(f"packet: {reader.end - reader.at} bytes are left after {count} arguments")
    return Packet(serial, code, arguments, reserved)


class PacketStream:
    """Cuts the bytes of a connection into packets; never holds more than one packet and what came with it."""

    def __init__(self) -> None:
        self._data = bytearray()

    def feed(self, data: bytes) -> list[Packet]:
        """The packets that these bytes complete; PacketError ends the stream, for it has lost its place."""
        self._data += data
        packets = []
        while len(self._data) >= HEAD:
            size = packet_size(bytes(self._data[:HEAD]))
            if len(self._data) < size:
                break
            packets.append(decode_packet(bytes(self._data[:size])))
            del self._data[:size]
        return packets


class _Reader:
    """Reads values from front to back, never beyond `end` and never more than MAX_VALUES."""

    def __init__(self, data: bytes, at: int, end: int) -> None:
        self._data, self.at, self.end, self._left = data, at, end, MAX_VALUES

    def argument(self, index: int) -> Value:
        (size,) = self._unpack("<I")
        begin = self.at
        value = self._variant(0)
        if self.at - begin != size:
            raise PacketError(f"argument {index}: says {size} bytes, has {self.at - begin}")
        return value

    def _variant(self, depth: int) -> Value:
        if depth > MAX_DEPTH:
            raise PacketError(f"VARIANT: nested deeper than {MAX_DEPTH}")
        kind, count = self._unpack("<HI")
        if kind & ~_ARRAY not in _KNOWN:
            raise PacketError(f"VARIANT: type {kind:#06x} is unknown")
        if kind & _ARRAY:
            return self._array(Type(kind & ~_ARRAY), count, depth)
        self._count(1)
        if kind in (Type.EMPTY, Type.NULL):
            return None
        if count != 1:
            raise PacketError(f"VARIANT: a single value needs the count 1, got {count}")
        if kind == Type.BSTR:
            return self._text()
        return self._variant(depth + 1) if kind == Type.VARIANT else self._numbers(Type(kind), 1)[0]

    def _array(self, kind: Type, count: int, depth: int) -> Value:
        if kind == Type.UI1:
            return self._take(count)
        self._count(1 + count)
        if kind in _NUMBERS:
            return self._numbers(kind, count)
        if kind == Type.BSTR:
            return [self._text() for _ in range(count)]
        if kind == Type.VARIANT:
            return [self._variant(depth + 1) for _ in range(count)]
        raise PacketError(f"VARIANT: there are no arrays of {kind.name}")

    def _numbers(self, kind: Type, count: int) -> list[Value]:
        code = _NUMBERS[kind]
        values = struct.unpack(f"<{count}{code}", self._take(count * struct.calcsize(f"<{code}")))
        return [bool(value) for value in values] if kind == Type.BOOL else list(values)

    def _text(self) -> str:
        (size,) = self._unpack("<I")
        try:
            return self._take(size).decode("utf-16-le")
        except UnicodeDecodeError as error:
            raise PacketError(f"BSTR: needs UTF-16, got {size} bytes that are none ({error.reason})") from error

    def _count(self, values: int) -> None:
        self._left -= values
        if self._left < 0:
            raise PacketError(f"packet: holds more than {MAX_VALUES} values")

    def _unpack(self, layout: str) -> tuple[int, ...]:
        return struct.unpack(layout, self._take(struct.calcsize(layout)))

    def _take(self, size: int) -> bytes:
        if size > self.end - self.at:
            raise PacketError(f"packet: {size} bytes are needed at {self.at}, {self.end - self.at} are left")
        self.at += size
        return self._data[self.at - size : self.at]


def _encode(value: Value, depth: int = 0) -> bytes:
    if depth > MAX_DEPTH:
        raise ValueError(f"value: needs to be nested {MAX_DEPTH} deep at most")
    if value is None:
        return struct.pack("<HI", Type.EMPTY, 1)
    if isinstance(value, str):
        return struct.pack("<HI", Type.BSTR, 1) + _bstr(value)
    if isinstance(value, bytes):
        return struct.pack("<HI", _ARRAY | Type.UI1, len(value)) + value
    if isinstance(value, (bool, int, float)):
        kind = _number_type([value])
        return struct.pack(f"<HI{_NUMBERS[kind]}", kind, 1, _number(value))
    if isinstance(value, (list, tuple)):
        return _encode_array(value, depth)
    raise TypeError(f"value: b-CAP has no type for {type(value).__name__}")


def _encode_array(values: Sequence[Value], depth: int) -> bytes:
    numbers = [value for value in values if isinstance(value, (bool, int, float))]
    if numbers and len(numbers) == len(values) and len({type(value) for value in numbers}) == 1:
        kind = _number_type(numbers)
        data = struct.pack(f"<{len(numbers)}{_NUMBERS[kind]}", *map(_number, numbers))
        return struct.pack("<HI", _ARRAY | kind, len(values)) + data
    texts = [value for value in values if isinstance(value, str)]
    if texts and len(texts) == len(values):
        return struct.pack("<HI", _ARRAY | Type.BSTR, len(values)) + b"".join(map(_bstr, texts))
    return struct.pack("<HI", _ARRAY | Type.VARIANT, len(values)) + b"".join(_encode(v, depth + 1) for v in values)


def _number_type(values: Sequence[bool | int | float]) -> Type:
    if isinstance(values[0], bool):
        return Type.BOOL
    if isinstance(values[0], float):
        return Type.R8
    for kind, low, high in ((Type.I4, -(1 << 31), 1 << 31), (Type.I8, -(1 << 63), 1 << 63), (Type.UI8, 0, 1 << 64)):
        if low <= min(values) and max(values) < high:
            return kind
    raise ValueError(f"value: no integer type of b-CAP holds {min(values)} to {max(values)}")


def _number(value: bool | int | float) -> int | float:
    return -int(value) if isinstance(value, bool) else value


def _bstr(text: str) -> bytes:
    data = text.encode("utf-16-le")
    return struct.pack("<I", len(data)) + data
