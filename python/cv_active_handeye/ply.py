# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Point clouds as PLY files, binary little endian; why not by a library: doc/decisions/ply.md."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .files import FloatArray, write_atomic

TYPES = {"f8": "double", "f4": "float", "i4": "int"}
"""Names of numpy's types in a PLY header."""


def write_ply(path: str | Path, points: FloatArray, comments: tuple[str, ...] = (), **values: NDArray[Any]) -> None:
    """Writes `points` (N, 3) as double x, y, z, and every further array of `values` (N,) as a property of its name.

    The file is replaced at once. float64, float32 and int32 keep their type; ValueError for other types, other lengths
    and comments of more than one line.
    """
    columns = dict(zip("xyz", np.asarray(points, np.float64).reshape(-1, 3).T, strict=True)) | values
    for name, column in values.items():
        if column.shape != (len(points),) or column.dtype.str[1:] not in TYPES:
            wanted = f"{name}: needs {len(points)} numbers (float64, float32 or int32)"
            raise ValueError(f"{wanted}, given {column.dtype} of shape {column.shape}")
    if not all(text.isprintable() for text in comments):
        raise ValueError(f"comments: needs one line each, given {comments}")
    table = np.empty(len(points), [(name, "<" + column.dtype.str[1:]) for name, column in columns.items()])
    for name, column in columns.items():
        table[name] = column
    properties = [f"property {TYPES[column.dtype.str[1:]]} {name}" for name, column in columns.items()]
    head = ["ply", "format binary_little_endian 1.0", *(f"comment {text}" for text in comments)]
    head += [f"element vertex {len(points)}", *properties, "end_header", ""]
    write_atomic(Path(path), "\n".join(head).encode("ascii", "replace") + table.tobytes())
