# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The general purpose registers, through which a client and the program on the controller talk."""

from __future__ import annotations

import threading

from ....robots.rtde_packets import Value
from .rtde_packets import INPUT_TYPES, REGISTERS

READY, DONE = 1, 2


class Registers:
    """Inputs that clients write, outputs that the program writes. Thread-safe."""

    def __init__(self) -> None:
        """All zero."""
        self.changed = threading.Condition()
        self._inputs: dict[str, Value] = dict.fromkeys(INPUT_TYPES, 0)
        self._updates = dict.fromkeys(INPUT_TYPES, 0)
        self._ints = [0] * REGISTERS
        self._doubles = [0.0] * REGISTERS

    def write_inputs(self, values: dict[str, Value]) -> None:
        """A client's package."""
        with self.changed:
            self._inputs.update(values)
            for name in values:
                self._updates[name] += 1
            self.changed.notify_all()

    def updates(self, name: str) -> int:
        """How many packages with this input variable have come."""
        with self.changed:
            return self._updates[name]

    def ints(self, offset: int) -> list[int]:
        """The 24 integers that a client wrote, from register `offset` on."""
        with self.changed:
            return [int(self._number(f"input_int_register_{offset + i}")) for i in range(24)]

    def doubles(self, offset: int) -> list[float]:
        """The 24 doubles that a client wrote, from register `offset` on."""
        with self.changed:
            return [float(self._number(f"input_double_register_{offset + i}")) for i in range(24)]

    def set_int(self, index: int, value: int) -> None:
        """The program's answer."""
        with self.changed:
            self._ints[index] = value

    def set_doubles(self, offset: int, values: list[float]) -> None:
        """The program's answer, a vector."""
        with self.changed:
            self._doubles[offset : offset + len(values)] = values

    def output(self, name: str) -> Value:
        """An output register by its name."""
        kind, index = name.removeprefix("output_").split("_register_")
        with self.changed:
            return (self._ints if kind == "int" else self._doubles)[int(index)]

    def _number(self, name: str) -> float | int:
        value = self._inputs[name]
        return 0 if isinstance(value, tuple) else value
