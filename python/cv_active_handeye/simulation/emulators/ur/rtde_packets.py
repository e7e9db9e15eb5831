# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""RTDE (real-time data exchange), protocol version 2: packets and recipes, without any connection.

A packet is a big-endian u16 size (header of 3 bytes included), a type byte and a payload. Source: Universal Robots,
"Real-Time Data Exchange (RTDE) Guide". Everything a client may send is parsed here, and only here; what cannot be
parsed is a PacketError.
"""

from __future__ import annotations

import math
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

REGISTERS = 48


def _table(**names_of_type: str) -> dict[str, str]:
    return {name: kind for kind, names in names_of_type.items() for name in names.split()}


def _registers(direction: str) -> dict[str, str]:
    kinds = {"int": "INT32", "double": "DOUBLE"}
    return {f"{direction}_{word}_register_{i}": kind for word, kind in kinds.items() for i in range(REGISTERS)}


OUTPUT_TYPES = {
    **_table(
        DOUBLE="timestamp actual_execution_time speed_scaling target_speed_fraction actual_momentum "
        "actual_main_voltage actual_robot_voltage actual_robot_current standard_analog_input0 standard_analog_input1 "
        "standard_analog_output0 standard_analog_output1 payload",
        VECTOR6D="target_q target_qd target_qdd target_current target_moment actual_q actual_qd actual_qdd "
        "actual_current actual_moment joint_control_output actual_TCP_pose actual_TCP_speed actual_TCP_force "
        "target_TCP_pose target_TCP_speed joint_temperatures actual_joint_voltage ft_raw_wrench "
        "actual_current_as_torque payload_inertia tcp_offset",
        VECTOR3D="payload_cog actual_tool_accelerometer elbow_position elbow_velocity",
        VECTOR6INT32="joint_mode",
        INT32="robot_mode safety_mode",
        UINT32="runtime_state robot_status_bits safety_status_bits output_bit_registers0_to_31 "
        "output_bit_registers32_to_63",
        UINT64="actual_digital_input_bits actual_digital_output_bits",
    ),
    **_registers("output"),
}
"""What the controller can send, by name."""

INPUT_TYPES = {
    **_table(
        UINT32="speed_slider_mask",
        UINT8="standard_digital_output_mask standard_digital_output configurable_digital_output_mask "
        "configurable_digital_output tool_digital_output_mask tool_digital_output standard_analog_output_mask "
        "standard_analog_output_type",
        DOUBLE="speed_slider_fraction standard_analog_output_0 standard_analog_output_1",
        VECTOR6D="external_force_torque",
    ),
    **_registers("input"),
}
"""What a client can send, by name."""

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


def protocol_version(payload: bytes) -> int:
    """What a client asks for in a PROTOCOL packet."""
    if len(payload) != 2:
        raise PacketError(f"protocol version: needs 2 bytes, given {len(payload)}")
    return int(struct.unpack(">H", payload)[0])


def output_request(payload: bytes) -> tuple[float, tuple[str, ...]]:
    """Frequency (Hz) and names of an OUTPUTS packet."""
    if len(payload) < 8:
        raise PacketError(f"output recipe: needs a frequency of 8 bytes, given {len(payload)}")
    frequency = float(struct.unpack_from(">d", payload)[0])
    if not math.isfinite(frequency) or not 1.0 <= frequency <= 500.0:
        raise PacketError(f"output recipe: frequency needs to be 1 to 500 Hz, given {frequency:g}")
    return frequency, names(payload[8:])


def names(text: bytes) -> tuple[str, ...]:
    """Names, separated by commas, of a recipe; one comma may follow the last."""
    try:
        found = text.decode("ascii").removesuffix(",").split(",")
    except UnicodeDecodeError as error:
        raise PacketError(f"recipe: needs names in ASCII, given {text[:40]!r}") from error
    if not all(found) or len(set(found)) != len(found):
        raise PacketError(f"recipe: needs names that differ and are not empty, given {text[:80]!r}")
    return tuple(found)
