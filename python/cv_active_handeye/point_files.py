# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Two small CSV tables a data set may name: points found in its images, and where those points lie on a board.

`image_points.csv`: view, point, u_px, v_px - one row an observation, pixel centres are integers.
`board_points.csv`: point, X_m, Y_m, Z_m - only for comparing with board methods; the calibration never reads it.
"""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np

from .files import FileFormatError, FloatArray, write_atomic

IMAGE_HEADER = ["view", "point", "u_px", "v_px"]
BOARD_HEADER = ["point", "X_m", "Y_m", "Z_m"]


def write_image_points(path: Path, points: FloatArray) -> None:
    """`points` (V, N, 2); rows with NaN are left out."""
    seen = np.argwhere(np.isfinite(points).all(axis=2))
    rows = [[str(v), str(j), repr(float(points[v, j, 0])), repr(float(points[v, j, 1]))] for v, j in seen]
    _write_table(path, IMAGE_HEADER, rows)


def read_image_points(path: Path, view_count: int) -> FloatArray:
    """(V, N, 2), NaN where a point is not seen; N is the largest point number + 1."""
    table = _read_table(path, IMAGE_HEADER)
    views, numbers = _indices(path, table, 0), _indices(path, table, 1)
    if len(views) and views.max() >= view_count:
        raise FileFormatError(f"{path}: names view {views.max()}, the data set has {view_count} views")
    points = np.full((view_count, int(numbers.max()) + 1 if len(numbers) else 0, 2), np.nan)
    points[views, numbers] = table[:, 2:]
    if np.isfinite(points).all(axis=2).sum() != len(table):
        raise FileFormatError(f"{path}: an observation (view, point) is given twice or is not finite")
    return points


def write_board_points(path: Path, points: FloatArray) -> None:
    """`points` (N, 3) in metres."""
    known = np.flatnonzero(np.isfinite(points).all(axis=1))
    rows = [[str(j), *(repr(float(value)) for value in points[j])] for j in known]
    _write_table(path, BOARD_HEADER, rows)


def read_board_points(path: Path) -> FloatArray:
    """(N, 3) in metres, NaN where no row names the point."""
    table = _read_table(path, BOARD_HEADER)
    numbers = _indices(path, table, 0)
    points = np.full((int(numbers.max()) + 1 if len(numbers) else 0, 3), np.nan)
    points[numbers] = table[:, 1:]
    return points


def _write_table(path: Path, header: list[str], rows: list[list[str]]) -> None:
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    write_atomic(path, stream.getvalue().encode())


def _read_table(path: Path, header: list[str]) -> FloatArray:
    if not path.is_file():
        raise FileFormatError(f"{path.name}: the file is missing")
    rows = list(csv.reader(path.read_text(encoding="utf-8").splitlines()))
    if not rows or rows[0] != header:
        given = ",".join(rows[0]) if rows else "nothing"
        raise FileFormatError(f"{path}: needs the header {','.join(header)}, given {given}")
    try:
        numbers = [[float(value) for value in row] for row in rows[1:]]
        table = np.array(numbers, dtype=np.float64).reshape(-1, len(header))
    except ValueError as error:
        raise FileFormatError(f"{path}: every row needs {len(header)} numbers: {error}") from error
    return table


def _indices(path: Path, table: FloatArray, column: int) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    values = table[:, column]
    if not np.all((values >= 0) & (values == np.floor(values))):
        raise FileFormatError(f"{path}: column {column + 1} needs whole numbers from 0 on")
    indices: np.ndarray[tuple[int], np.dtype[np.int64]] = values.astype(np.int64)
    return indices
