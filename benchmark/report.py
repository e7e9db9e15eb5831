# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What every benchmark returns: tables, and measures with the limit each has to keep; and its command line."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

Cell = str | int | float | None


@dataclass(frozen=True)
class Table:
    """Rows of numbers under a title. Numbers are printed with four significant digits, None as a dash."""

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    note: str = ""

    def markdown(self, level: int = 3) -> str:
        """The table as GitHub markdown, columns aligned so that it reads well in a terminal too."""
        cells = [list(self.columns)] + [[format_cell(cell) for cell in row] for row in self.rows]
        widths = [max(len(row[i]) for row in cells) for i in range(len(self.columns))]
        numeric = [all(not isinstance(row[i], str) for row in self.rows) for i in range(len(self.columns))]
        rule = ["-" * (w - 1) + (":" if n else "-") for w, n in zip(widths, numeric, strict=True)]
        lines = [
            "| "
            + " | ".join(c.rjust(w) if n else c.ljust(w) for c, w, n in zip(row, widths, numeric, strict=True))
            + " |"
            for row in [cells[0], rule, *cells[1:]]
        ]
        note = f"\n\n{self.note}" if self.note else ""
        return f"{'#' * level} {self.title}\n\n" + "\n".join(lines) + note + "\n"


@dataclass(frozen=True)
class Measure:
    """A number that has to stay within its limit: at most `limit`, or at least when `at_least`."""

    name: str
    value: float
    limit: float
    at_least: bool = False

    @property
    def kept(self) -> bool:
        """Whether the limit is kept; NaN is not."""
        return self.value >= self.limit if self.at_least else self.value <= self.limit

    def row(self) -> list[Cell]:
        """name, value, limit, verdict."""
        sign = ">=" if self.at_least else "<="
        return [self.name, self.value, f"{sign} {format_cell(self.limit)}", "kept" if self.kept else "MISSED"]


@dataclass(frozen=True)
class Report:
    """Result of one benchmark. `setup` is one paragraph: what was simulated or read, how often, with which seed."""

    title: str
    setup: str
    tables: Sequence[Table] = ()
    measures: Sequence[Measure] = field(default_factory=tuple)

    @property
    def missed(self) -> list[Measure]:
        """Measures beyond their limit."""
        return [measure for measure in self.measures if not measure.kept]

    def markdown(self) -> str:
        """The whole report as a section of doc/accuracy.md."""
        tables = list(self.tables)
        if self.measures:
            tables.append(Table("Measures", ("measure", "value", "limit", "verdict"), [m.row() for m in self.measures]))
        return f"## {self.title}\n\n{self.setup}\n\n" + "\n".join(table.markdown() for table in tables)

    def save(self, path: Path) -> None:
        """Writes markdown, or JSON when the file is called *.json."""
        text = json.dumps(asdict(self), indent=1) if path.suffix == ".json" else self.markdown()
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")

    @classmethod
    def load(cls, path: Path) -> Report:
        """Reads what `save` wrote to a *.json file."""
        content = json.loads(path.read_text(encoding="utf-8"))
        tables = [Table(**table) for table in content["tables"]]
        return cls(content["title"], content["setup"], tables, [Measure(**measure) for measure in content["measures"]])


def format_cell(cell: Cell) -> str:
    """Four significant digits, without an exponent where the number is of everyday size."""
    if cell is None:
        return "-"
    if not isinstance(cell, float):
        return str(cell)
    return (
        f"{cell:.0f}" if 1e3 <= abs(cell) < 1e6 else f"{cell:.3g}" if abs(cell) < 1e-3 else f"{cell:#.4g}".rstrip(".")
    )


def parser(description: str) -> argparse.ArgumentParser:
    """A parser with --output; the benchmark adds its own options."""
    made = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    made.add_argument("--output", type=Path, help="also write the report to this file: *.md markdown, *.json JSON")
    return made


def finish(report: Report, output: Path | None) -> int:
    """Prints and saves the report; exit status 1 when a measure is missed, named on standard error."""
    print(report.markdown())
    if output:
        report.save(output)
    for measure in report.missed:
        print(
            f"MISSED {measure.name}: {format_cell(measure.value)}, limit {format_cell(measure.limit)}", file=sys.stderr
        )
    return 1 if report.missed else 0


def progress(total: int, what: str) -> Callable[[int], None]:
    """A counter on standard error, where that is a terminal."""

    def show(done: int) -> None:
        if sys.stderr.isatty() and (done % 20 == 0 or done == total):
            print(f"\r{what} {done}/{total}", end="" if done < total else "\n", file=sys.stderr, flush=True)

    return show
