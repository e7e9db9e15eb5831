# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The simulated cell from images to the calibration, over ten seeds: errors against the truth.

Every run is what `cv-active-handeye demo` does: record 14 stops, laser off and on, track points, calibrate in closed
form from images and reported poses alone, draw the pictures. Another seed is another scene, texture, camera, mounting
and noise. The cell has the paper's hardware: 640 x 480, f about 1413 px, DENSO VP-6242 with 0.02 mm repeatability.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path

import numpy as np

import cv_active_handeye as cah
from cv_active_handeye.report import CalibrationErrors
from cv_active_handeye.simulation import CellConfig
from cv_active_handeye.workflow.demo import demo
from cv_active_handeye.workflow.reporter import InsufficientDataError

from .report import Cell, Measure, Report, Table, finish, parser, progress

LIMITS = {
    "rotation_deg": 0.05,
    "translation_mm": 0.5,
    "fx_percent": 0.15,
    "plane_normal_deg": 0.1,
    "plane_offset_mm": 0.5,
}
MAX_SECONDS = 120.0
NAMES = [field.name for field in fields(CalibrationErrors)]
UNITS = {"percent": "%"}
HEADINGS = [
    f"{what.replace('_', ' ')} [{UNITS.get(unit, unit)}]" for what, _, unit in (n.rpartition("_") for n in NAMES)
]


@dataclass(frozen=True)
class Run:
    """One demo: its errors (NaN where it failed), what it used, and seconds of the clock and of the processors."""

    seed: int
    errors: CalibrationErrors
    tracks: int
    rms_px: float
    seconds: float
    cpu_seconds: float
    problem: str = ""

    def row(self) -> list[Cell]:
        """Columns of the table."""
        return [str(self.seed), *astuple(self.errors), self.tracks, self.rms_px, self.seconds, self.cpu_seconds]


def run(seed: int, folder: Path) -> Run:
    """Simulates and calibrates the cell of one seed in `folder`."""
    clock, processors = time.perf_counter(), time.process_time()
    failed = CalibrationErrors(*[float("nan")] * len(NAMES))
    errors, tracks, rms, problem = failed, 0, float("nan"), ""
    try:
        result = demo(folder, CellConfig(seed=seed))
        errors = CalibrationErrors(*(float("nan") if e is None else e for e in astuple(result.errors)))
        tracks, rms = result.calibration.points, result.calibration.rms.translations_px
    except (cah.error, InsufficientDataError) as error:
        problem = f"seed {seed}: {error}"
    return Run(seed, errors, tracks, rms, time.perf_counter() - clock, time.process_time() - processors, problem)


def measure(seeds: Sequence[int] = range(10), folder: Path | None = None) -> Report:
    """Errors of every seed, their median and largest, and the limits for the median."""
    runs = []
    show = progress(len(seeds), "demo")
    with tempfile.TemporaryDirectory() as temporary:
        for seed in seeds:
            runs.append(run(seed, (folder or Path(temporary)) / f"seed{seed}"))
            show(len(runs))
    errors = np.array([astuple(r.errors) for r in runs], dtype=np.float64)
    filled = np.where(np.isnan(errors), np.inf, errors)
    median, largest = np.median(filled, axis=0), np.max(filled, axis=0)
    times = [float(np.median([r.seconds for r in runs])), float(np.median([r.cpu_seconds for r in runs]))]
    rows: list[list[Cell]] = [r.row() for r in runs]
    rows.append(["median", *median.tolist(), int(np.median([r.tracks for r in runs])), None, *times])
    rows.append(["largest", *largest.tolist(), None, None, max(r.seconds for r in runs), None])
    rows.append(["limit of the median", *(LIMITS.get(name) for name in NAMES), None, None, MAX_SECONDS, None])
    measures = [
        Measure(f"median {heading}", float(median[NAMES.index(name)]), LIMITS[name])
        for name, heading in zip(NAMES, HEADINGS, strict=True)
        if name in LIMITS
    ]
    measures.append(Measure("median seconds of a run", times[0], MAX_SECONDS))
    columns = ("seed", *HEADINGS, "tracks", "rms [px]", "time [s]", "processor [s]")
    setup = (
        f"Seeds {', '.join(map(str, seeds))}; sizes of the errors of the closed forms, from images and reported poses "
        "alone. rms: of the pure translations. The clock also counts what else the machine does."
    )
    note = " ".join(r.problem for r in runs if r.problem)
    return Report(
        "The simulated cell, from images to the calibration", setup, [Table("Errors", columns, rows, note)], measures
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    line = parser(__doc__ or "")
    line.add_argument("--seeds", type=int, default=10, help="how many cells: seeds 0 to this number - 1 (default 10)")
    line.add_argument("--first", type=int, default=0, help="first seed (default 0)")
    line.add_argument("--keep", type=Path, help="keep data sets, results and pictures in this folder")
    options = line.parse_args(arguments)
    seeds = range(options.first, options.first + options.seeds)
    return finish(measure(seeds, options.keep), options.output)


if __name__ == "__main__":
    sys.exit(main())
