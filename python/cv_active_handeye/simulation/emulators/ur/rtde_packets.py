# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""RTDE as a controller sees it: everything a client may send is parsed here, and what a controller can send is listed.

For fuzzing: `PacketReader.feed` and then, by the packet's kind, `protocol_version`, `output_request`, `names_of` and
`Recipe.unpack` are all that touches a client's bytes; PacketError is all that they may raise.
"""

from __future__ import annotations

import math
import struct

from ....robots.rtde_packets import PacketError

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
    return frequency, names_of(payload[8:])


def names_of(text: bytes) -> tuple[str, ...]:
    """Names, separated by commas, of a recipe; one comma may follow the last."""
    try:
        found = text.decode("ascii").removesuffix(",").split(",")
    except UnicodeDecodeError as error:
        raise PacketError(f"recipe: needs names in ASCII, given {text[:40]!r}") from error
    if not all(found) or len(set(found)) != len(found):
        raise PacketError(f"recipe: needs names that differ and are not empty, given {text[:80]!r}")
    return tuple(found)
