# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The b-CAP decoder with any bytes: a PacketError, or packets that survive encoding and decoding again."""

from __future__ import annotations

import struct

from driver import require, run

from cv_active_handeye.robots.bcap_packets import Packet, PacketError, PacketStream, decode_packet, encode_packet


def check(data: bytes) -> Packet | None:
    """Decodes; what can be decoded survives another round. As text, for not-a-number is not equal to itself."""
    try:
        packet = decode_packet(data)
    except PacketError:
        return None
    again = decode_packet(encode_packet(packet))
    require(repr(again) == repr(packet), f"{packet!r} became {again!r}")
    return packet


def streamed(data: bytes, step: int) -> tuple[list[str], bool]:
    """The packets of a stream that comes in pieces of `step` bytes, and whether it ended with an error."""
    stream, packets = PacketStream(), list[str]()
    try:
        for at in range(0, len(data), step):
            packets += map(repr, stream.feed(data[at : at + step]))
    except PacketError:
        return packets, True
    return packets, False


def target(data: bytes) -> None:
    """The bytes as they are, as the arguments of a packet with a true frame, and as a stream cut in two ways."""
    check(data)
    if len(data) < 2:
        return
    frame = struct.pack("<BIHHIH", 1, 14 + len(data), 1, 0, 64, data[0] % 8) + data[2:] + b"\x04"
    check(frame)
    stream = frame + data
    wide, fine = streamed(stream, len(stream)), streamed(stream, 1 + data[1])
    require(wide[1] == fine[1], "the error depends on how the stream was cut")
    require(wide[0] == fine[0][: len(wide[0])], "the packets depend on how the stream was cut")


if __name__ == "__main__":
    run("bcap_packets", target, "cv_active_handeye.robots.bcap_packets")
