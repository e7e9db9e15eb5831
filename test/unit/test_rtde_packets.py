# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""RTDE's packets and recipes: sizes, types, and bytes that are none."""

from __future__ import annotations

import struct

import numpy as np
import pytest

from cv_active_handeye.robots.rtde_packets import DATA, LONGEST, Packet, PacketError, PacketReader, Recipe
from cv_active_handeye.simulation.emulators.ur.rtde_packets import (
    INPUT_TYPES,
    OUTPUT_TYPES,
    names_of,
    output_request,
    protocol_version,
)


def test_reader_finds_the_packets_however_the_bytes_arrive() -> None:
    rng = np.random.default_rng(1)
    packets = [Packet(int(rng.choice(list(b"VvMUOISP"))), rng.bytes(int(rng.integers(0, 300)))) for _ in range(60)]
    stream = b"".join(packet.encoded() for packet in packets)
    reader, found, at = PacketReader(), [], 0
    while at < len(stream):
        step = int(rng.integers(1, 200))
        found += list(reader.feed(stream[at : at + step]))
        at += step
    assert found == packets


@pytest.mark.parametrize("data", [b"\x00\x02V", b"\x00\x00V", b"\xff\xffU", struct.pack(">HB", LONGEST + 1, DATA)])
def test_reader_refuses_sizes_that_cannot_be(data: bytes) -> None:
    with pytest.raises(PacketError, match=f"packet size: needs 3 to {LONGEST}, given"):
        list(PacketReader().feed(data))


def test_reader_refuses_an_unknown_type_before_its_payload_arrives() -> None:
    with pytest.raises(PacketError, match=r"packet type.*given 0"):
        list(PacketReader().feed(b"\x10\x00\x00"))


def test_reader_and_requests_raise_nothing_but_packet_error_on_random_bytes() -> None:
    rng = np.random.default_rng(2)
    recipe = Recipe(("input_int_register_0", "input_double_register_0"), ("INT32", "DOUBLE"))
    for _ in range(3000):
        data = rng.bytes(int(rng.integers(0, 40)))
        for parse in (
            lambda x: list(PacketReader().feed(x)),
            protocol_version,
            output_request,
            names_of,
            recipe.unpack,
        ):
            try:
                parse(data)
            except PacketError:
                continue


def test_recipe_packs_big_endian_in_its_order_and_unpacks_the_same() -> None:
    names = ("timestamp", "actual_q", "runtime_state", "actual_digital_output_bits", "payload_cog", "joint_mode")
    recipe = Recipe(names, tuple(OUTPUT_TYPES[name] for name in names))
    values = (1.5, (1.0, 2.0, 3.0, 4.0, 5.0, 6.0), 2, 9, (0.1, 0.2, 0.3), (253,) * 6)
    data = recipe.pack(values)
    assert data == struct.pack(">d6dIQ3d6i", 1.5, 1, 2, 3, 4, 5, 6, 2, 9, 0.1, 0.2, 0.3, *(253,) * 6)
    assert recipe.unpack(data) == dict(zip(names, values, strict=True))
    with pytest.raises(PacketError, match=f"needs {len(data)} bytes, given {len(data) - 1}"):
        recipe.unpack(data[:-1])


def test_move_package_of_the_client_is_76_bytes() -> None:
    names = ("input_int_register_0", *(f"input_double_register_{i}" for i in range(8)), "input_int_register_1")
    recipe = Recipe(names, tuple(INPUT_TYPES[name] for name in names))
    assert len(Packet(DATA, b"\x01" + recipe.pack((3, *[0.0] * 8, 1))).encoded()) == 76


def test_requests_read_what_clients_send() -> None:
    assert protocol_version(b"\x00\x02") == 2
    assert output_request(struct.pack(">d", 125.0) + b"timestamp,actual_q,") == (125.0, ("timestamp", "actual_q"))


@pytest.mark.parametrize("frequency", [0.0, -1.0, 500.1, float("nan"), float("inf")])
def test_output_request_refuses_a_frequency_that_cannot_be(frequency: float) -> None:
    with pytest.raises(PacketError, match="frequency needs to be 1 to 500 Hz"):
        output_request(struct.pack(">d", frequency) + b"timestamp")


@pytest.mark.parametrize("text", [b"", b",", b"a,,b", b"a,a", b"\xff"])
def test_names_refuses_what_is_no_list_of_names(text: bytes) -> None:
    with pytest.raises(PacketError, match="recipe: needs names"):
        names_of(text)
