# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""b-CAP packets: known bytes, what goes in comes out, and hostile bytes end with one kind of error."""

from __future__ import annotations

import struct
import time
import tracemalloc
from itertools import pairwise

import numpy as np
import pytest

from cv_active_handeye.robots.bcap_packets import (
    MAX_DEPTH,
    MAX_PACKET,
    MAX_VALUES,
    Packet,
    PacketError,
    PacketStream,
    Value,
    decode_packet,
    encode_packet,
    packet_size,
)

# Recorded from the maker's own client and server.
KNOWN = {
    "011e000000010000000100000001000a0000000800010000000000000004": Packet(1, 1, ("",)),
    "0142000000020000004000000003000a00000003000100000003000000160000000800010000000c000000430075007200"
    "50006f0073000600000000000100000004": Packet(2, 64, (3, "CurPos", None)),
    "0110000000020000000009000000000" + "4": Packet(2, 0x900),
    "012a000000020000000000000001001600000005200200000000000000000004400000000000000cc004": Packet(
        2, 0, ([2.5, -3.5],)
    ),
}


def packet_of(*variants: bytes) -> bytes:
    body = b"".join(struct.pack("<I", len(variant)) + variant for variant in variants)
    return struct.pack("<BIHHIH", 1, 16 + len(body), 7, 0, 0, len(variants)) + body + b"\x04"


def random_value(rng: np.random.Generator, depth: int = 0) -> Value:
    kinds: list[Value] = [
        None,
        bool(rng.integers(2)),
        int(rng.integers(-(1 << 31), 1 << 31)),
        int(rng.integers(-(1 << 62), 1 << 62)),
        float(rng.normal() * 10.0 ** rng.integers(-9, 9)),
        "".join(chr(c) for c in rng.integers(32, 0xD7FF, rng.integers(0, 9))),
        bytes(rng.integers(0, 256, rng.integers(0, 9), dtype=np.uint8)),
        [float(x) for x in rng.normal(size=rng.integers(0, 5))],
        [int(x) for x in rng.integers(-9, 9, rng.integers(0, 5))],
        [bool(x) for x in rng.integers(0, 2, rng.integers(1, 5))],
        ["a", "", "\U0001f916"],
    ]
    if depth < 3:
        kinds.append([random_value(rng, depth + 1) for _ in range(rng.integers(0, 4))])
    return kinds[rng.integers(len(kinds))]


@pytest.mark.parametrize(("data", "packet"), KNOWN.items())
def test_packets_of_the_makers_programs_are_read_and_written(data: str, packet: Packet) -> None:
    assert decode_packet(bytes.fromhex(data)) == packet
    assert encode_packet(packet).hex() == data


def test_what_is_encoded_is_decoded() -> None:
    rng = np.random.default_rng(1)
    for serial in range(1, 400):
        values = tuple(random_value(rng) for _ in range(rng.integers(0, 5)))
        packet = Packet(serial, int(rng.integers(1 << 32)), values)
        assert decode_packet(encode_packet(packet)) == packet


def test_every_number_type_of_a_controller_is_read() -> None:
    numbers = {
        "<HIh": (2, -3), "<HIi": (3, -70000), "<HIf": (4, 0.5), "<HId": (5, 0.1), "<HIq": (6, -1 << 40),
        "<HI d": (7, 2.5), "<HI i": (10, -5), "<HIB": (17, 200), "<HIH": (18, 60000), "<HII": (19, 1 << 31),
        "<HI q": (20, -1 << 60), "<HIQ": (21, 1 << 63),
    }  # fmt: skip
    for layout, (kind, value) in numbers.items():
        assert decode_packet(packet_of(struct.pack(layout, kind, 1, value))).arguments == (value,)
        if kind != 17:
            array = struct.pack(layout + layout[-1], kind | 0x2000, 2, value, value)
            assert decode_packet(packet_of(array)).arguments == ([value, value],)
    assert decode_packet(packet_of(struct.pack("<HIhh", 0x200B, 2, -1, 0))).arguments == ([True, False],)
    nested = struct.pack("<HI", 12, 1) + struct.pack("<HIi", 3, 1, 9)
    assert decode_packet(packet_of(nested)).arguments == (9,)


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"\x02" + packet_of()[1:], "needs to begin with 0x01"),
        (packet_of()[:-1] + b"\x05", "needs to end with 0x04"),
        (packet_of() + b"\x00", "says 16 bytes, got 17"),
        (struct.pack("<BI", 1, MAX_PACKET + 1), "needs a length from 16"),
        (struct.pack("<BI", 1, 15), "needs a length from 16"),
        (b"\x01", "needs 5 bytes"),
        (packet_of(struct.pack("<HI", 0x2005, MAX_VALUES)), "holds more than"),
        (packet_of(struct.pack("<HI", 0x2005, 0xFFFFFFFF)), "holds more than"),
        (packet_of(struct.pack("<HI", 0x2005, 3) + bytes(16)), "24 bytes are needed"),
        (packet_of(struct.pack("<HI", 0x2011, 1 << 24)), "bytes are needed"),
        (packet_of(struct.pack("<HI", 3, 2) + bytes(8)), "needs the count 1, got 2"),
        (packet_of(struct.pack("<HI", 9, 1)), "type 0x0009 is unknown"),
        (packet_of(struct.pack("<HI", 0x4003, 1) + bytes(4)), "type 0x4003 is unknown"),
        (packet_of(struct.pack("<HI", 0x2000, 2)), "no arrays of EMPTY"),
        (packet_of(struct.pack("<HII", 8, 1, 3) + b"abc"), "needs UTF-16"),
        (packet_of(struct.pack("<HII", 8, 1, 2) + b"\x00\xd8"), "needs UTF-16"),
        (packet_of(struct.pack("<HI", 12, 1) * (MAX_DEPTH + 2)), "nested deeper than"),
        (packet_of(struct.pack("<HIi", 3, 1, 5) + b"\x00"), "argument 0: says 11 bytes, has 10"),
        (struct.pack("<BIHHIH", 1, 17, 1, 0, 0, 0) + b"\x00\x04", "1 bytes are left after 0"),
        (struct.pack("<BIHHIH", 1, 16, 1, 0, 0, 9) + b"\x04", "4 bytes are needed"),
    ],
)
def test_bytes_that_are_no_packet_are_refused_with_the_reason(data: bytes, reason: str) -> None:
    with pytest.raises(PacketError, match=reason):
        decode_packet(data)


@pytest.mark.parametrize(
    ("value", "error"),
    [(1 << 64, ValueError), (object(), TypeError), ("\ud800", ValueError), ([[[[[[[[[[1]]]]]]]]], "x"], ValueError)],
)
def test_values_without_a_place_in_a_packet_are_refused(value: Value, error: type[Exception]) -> None:
    with pytest.raises(error):
        encode_packet(Packet(1, 1, (value,)))


def test_a_packet_over_16_mb_is_not_sent() -> None:
    with pytest.raises(ValueError, match="needs at most 16777216 bytes"):
        encode_packet(Packet(1, 1, (bytes(MAX_PACKET),)))


def test_stream_cut_anywhere_gives_the_same_packets() -> None:
    rng = np.random.default_rng(2)
    packets = [Packet(i, i, tuple(random_value(rng) for _ in range(3))) for i in range(1, 60)]
    data = b"".join(map(encode_packet, packets))
    for _ in range(20):
        cuts = [0, *sorted(rng.integers(0, len(data), 40)), len(data)]
        stream = PacketStream()
        assert [p for a, b in pairwise(cuts) for p in stream.feed(data[a:b])] == packets


def test_stream_refuses_a_bad_length_before_it_waits_for_the_bytes() -> None:
    with pytest.raises(PacketError, match="length"):
        PacketStream().feed(struct.pack("<BI", 1, 0x7FFFFFFF))


def test_random_and_damaged_bytes_end_with_a_packet_or_a_packet_error() -> None:
    rng = np.random.default_rng(3)
    whole = [bytes.fromhex(data) for data in KNOWN]
    decoded = 0
    for _ in range(4000):
        data = bytearray(whole[rng.integers(len(whole))])
        for _ in range(rng.integers(1, 6)):
            data[rng.integers(5, len(data) - 1)] = rng.integers(256)
        try:
            packet = decode_packet(bytes(data))
            decoded += 1
        except PacketError:
            continue
        # As text: not a number is not equal to itself.
        assert repr(decode_packet(encode_packet(packet))) == repr(packet)
    assert decoded > 100


def test_the_largest_packet_takes_bounded_time_and_memory() -> None:
    size = MAX_PACKET - 16 - 10
    arrays = [struct.pack("<HI", 0x200C, (size // 6) - 9) + struct.pack("<HI", 0, 1) * ((size // 6) - 9)]
    half = MAX_VALUES // 2 - 2
    arrays.append(struct.pack("<HI", 0x2003, half) + bytes(range(1, 5)) * half)
    for array in arrays:
        tracemalloc.start()
        began = time.monotonic()
        try:
            assert len(decode_packet(packet_of(array)).arguments) == 1
        except PacketError as error:
            assert "holds more than" in str(error)  # noqa: PT017 (either outcome is fine, no other is)
        assert time.monotonic() - began < 20
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert peak < 150 << 20


def test_size_of_a_packet_is_known_from_its_first_five_bytes() -> None:
    assert packet_size(packet_of()[:5]) == 16
