# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Calls the C++ functions through the program direct_calls, that is, without the bindings."""

from __future__ import annotations

import os
import struct
import subprocess
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
BUILD = Path(os.environ.get("ACTIVE_HANDEYE_BUILD", Path(__file__).parents[2] / "build/python"))
PROGRAM = BUILD / "bin/direct_calls"


def pack(arguments: Sequence[ArrayLike | list[Array]]) -> bytes:
    """Arguments as the program reads them; a list is a sequence of arrays, anything else one array."""
    data = struct.pack("<i", len(arguments))
    for argument in arguments:
        arrays = argument if isinstance(argument, list) else [argument]
        data += struct.pack("<i", len(arrays))
        for array in arrays:
            matrix = np.asarray(array, dtype="<f8")
            matrix = matrix.reshape(len(matrix), -1)
            data += struct.pack("<2i", *matrix.shape) + matrix.tobytes()
    return data


def unpack(data: bytes) -> list[Array]:
    """The arrays that the program answered."""
    (count,) = struct.unpack_from("<i", data)
    position, arrays = 4, []
    for _ in range(count):
        _, rows, columns = struct.unpack_from("<3i", data, position)
        position += 12
        arrays.append(np.frombuffer(data, "<f8", rows * columns, position).reshape(rows, columns))
        position += 8 * rows * columns
    return arrays


def direct_call(function: str, *arguments: ArrayLike | list[Array]) -> list[Array]:
    """Results of a C++ function for these inputs, all as doubles, scalars as (1, 1)."""
    assert PROGRAM.exists(), f"{PROGRAM} is missing: `make test-cpp` builds it"
    done = subprocess.run([PROGRAM, function], input=pack(arguments), capture_output=True, check=True)
    return unpack(done.stdout)
