# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The CSV files of `measure`: which points of the stripe to measure, and where they are. Columns: doc/files.md.

These two files are read and written by people and spreadsheets, so lengths are millimetres here.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from .files import FileFormatError, write_atomic

NEEDED = ("name", "view", "u", "v")
SIGMA = "sigma"
PICKED_SIGMA = 0.3
"""Of a pixel picked by hand, px: the column `sigma` where it is not given."""
REFERENCE = ("x", "y", "z")


class PointRow(NamedTuple):
    """One row: where in the laser image of a view a point is. `where`: file and line, for errors; `sigma`: standard
    deviation of the pixel along the stripe, px; `reference`: known coordinates in the base frame, mm, None without."""

    where: str
    name: str
    view: int
    u: float
    v: float
    sigma: float = PICKED_SIGMA
    reference: tuple[float, float, float] | None = None


def read_point_rows(path: str | Path) -> list[PointRow]:
    """The rows of a points file; `FileFormatError` names the line, what was needed and what was given."""
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise FileFormatError(f"{path}: cannot be read as a table of points: {reason}") from error
    reader = csv.reader(io.StringIO(text))
    header = [name.strip() for name in next(reader, [])]
    _check_header(path, header)
    rows = []
    for fields in reader:
        where = f"{path}, line {reader.line_num}"
        if not any(field.strip() for field in fields):
            continue
        if len(fields) != len(header):
            raise FileFormatError(f"{where}: needs {len(header)} columns as in the header, given {len(fields)}")
        rows.append(_row(where, {name: field.strip() for name, field in zip(header, fields, strict=True)}))
    if not rows:
        raise FileFormatError(f"{path}: needs at least one row below the header, has none")
    _check_rows(rows)
    return rows


def write_measured(path: str | Path, header: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Writes a table as CSV, replacing the file at once."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerows([header, *rows])
    write_atomic(Path(path), stream.getvalue().encode())


def _check_header(path: Path, header: list[str]) -> None:
    references_needed = f"for reference values, {','.join(REFERENCE)}"
    needed = f"{path}: needs the columns {','.join(NEEDED)}, where wanted {SIGMA}, and, {references_needed}"
    given = f"given {','.join(header) if header else 'nothing'}"
    for name in header:
        if header.count(name) > 1:
            raise FileFormatError(f"{path}: needs every column once, but '{name}' appears {header.count(name)} times")
        if name not in (*NEEDED, SIGMA, *REFERENCE):
            raise FileFormatError(f"{needed}; column '{name}' is unknown, {given}")
    references = [name for name in REFERENCE if name in header]
    missing = [name for name in NEEDED if name not in header]
    missing += [name for name in REFERENCE if references and name not in header]
    if missing:
        raise FileFormatError(f"{needed}; missing {','.join(missing)}, {given}")


def _row(where: str, fields: Mapping[str, str]) -> PointRow:
    if not fields["name"] or not fields["name"].isprintable():
        raise FileFormatError(f"{where}: column 'name' needs a name, given {fields['name']!r}")
    view = fields["view"]
    if not (view.isascii() and view.isdigit()):
        raise FileFormatError(f"{where}: column 'view' needs a whole number from 0 on, given {view!r}")
    u, v = (_number(where, fields, name) for name in ("u", "v"))
    sigma = _number(where, fields, SIGMA) if fields.get(SIGMA) else PICKED_SIGMA
    if sigma < 0:
        raise FileFormatError(f"{where}: column '{SIGMA}' needs 0 or a positive number, given {fields[SIGMA]!r}")
    given = [name for name in REFERENCE if fields.get(name)]
    if given and len(given) < len(REFERENCE):
        raise FileFormatError(f"{where}: reference values need all of x,y,z or none, given {','.join(given)}")
    reference = None
    if given:
        x, y, z = (_number(where, fields, name) for name in REFERENCE)
        reference = (x, y, z)
    return PointRow(where, fields["name"], int(view), u, v, sigma, reference)


def _number(where: str, fields: Mapping[str, str], name: str) -> float:
    try:
        value = float(fields[name])
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise FileFormatError(f"{where}: column '{name}' needs a finite number, given {fields[name]!r}")
    return value


def _check_rows(rows: Sequence[PointRow]) -> None:
    """Every point once a view, and with one reference."""
    seen: dict[tuple[str, int], PointRow] = {}
    references: dict[str, PointRow] = {}
    for row in rows:
        first = seen.setdefault((row.name, row.view), row)
        if first is not row:
            raise FileFormatError(
                f"{row.where}: needs one row for each point and view, but point {row.name} in view {row.view} stands "
                f"in {first.where} too"
            )
        if row.reference is not None:
            known = references.setdefault(row.name, row)
            if known.reference != row.reference:
                needed = f"needs the same x,y,z for point {row.name} as {known.where}"
                raise FileFormatError(f"{row.where}: {needed}: {known.reference}, given {row.reference}")
