# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What the UR emulator does with a client's RTDE bytes: a PacketError, or values that survive packing again."""

from __future__ import annotations

import struct

from driver import require, run

from cv_active_handeye.robots.rtde_packets import (
    DATA,
    INPUTS,
    OUTPUTS,
    PROTOCOL,
    Packet,
    PacketError,
    PacketReader,
    Recipe,
)
from cv_active_handeye.simulation.emulators.ur.rtde_packets import (
    INPUT_TYPES,
    OUTPUT_TYPES,
    names_of,
    output_request,
    protocol_version,
)

KINDS = b"VvMUOISP"


def packets_of(data: bytes, step: int) -> tuple[list[Packet], bool]:
    """The packets of a stream that comes in pieces of `step` bytes, and whether it ended with an error."""
    reader, packets = PacketReader(), list[Packet]()
    try:
        for at in range(0, len(data), step):
            packets += reader.feed(data[at : at + step])
    except PacketError:
        return packets, True
    return packets, False


def recipe_of(packet: Packet) -> Recipe | None:
    """The recipe that a client asks for."""
    if packet.kind == OUTPUTS:
        frequency, names = output_request(packet.payload)
        require(1 <= frequency <= 500, f"frequency {frequency}")
        return Recipe(names, tuple(OUTPUT_TYPES.get(name, "NOT_FOUND") for name in names))
    if packet.kind == INPUTS:
        names = names_of(packet.payload)
        return Recipe(names, tuple(INPUT_TYPES.get(name, "NOT_FOUND") for name in names))
    return None


def unpack(recipe: Recipe, payload: bytes) -> None:
    """A package of values; as text, for not-a-number is not equal to itself."""
    size = struct.calcsize(recipe.format)
    values = recipe.unpack((payload * (size // max(len(payload), 1) + 1))[:size] if len(payload) % 2 else payload)
    again = recipe.unpack(recipe.pack(list(values.values())))
    require(repr(again) == repr(values), f"{values!r} became {again!r}")


def take(packets: list[Packet]) -> None:
    """Parses every packet by its kind, data by the last recipe."""
    recipe: Recipe | None = None
    for packet in packets:
        require(Packet(packet.kind, packet.payload).encoded()[3:] == packet.payload, "a packet changed")
        try:
            if packet.kind == PROTOCOL:
                require(0 <= protocol_version(packet.payload) < 1 << 16, "the version is no 16 bit number")
            recipe = recipe_of(packet) or recipe
            if packet.kind == DATA and recipe is not None and recipe.valid:
                unpack(recipe, packet.payload[1:])
        except PacketError:
            continue


def target(data: bytes) -> None:
    """The bytes as a stream, cut in two ways; then as payloads of packets with true frames."""
    if not data:
        return
    wide, fine = packets_of(data, len(data)), packets_of(data, 1 + data[0])
    require(wide[1] == fine[1] and wide[0] == fine[0], "the packets depend on how the stream was cut")
    take(wide[0])
    pieces = data[1:].split(b"\xff")[:20]
    framed = b"".join(Packet(KINDS[piece[0] % 8], piece[1:8000]).encoded() for piece in pieces if piece)
    take(packets_of(framed, 100)[0])


if __name__ == "__main__":
    run(
        "rtde_packets",
        target,
        "cv_active_handeye.robots.rtde_packets",
        "cv_active_handeye.simulation.emulators.ur.rtde_packets",
    )
