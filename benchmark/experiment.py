# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The paper's experiment in the simulated cell: 15 points measured with the laser and touched.

Ten characteristic points of a flat text and five on blocks 2 to 47 mm above it, as in the paper's Table 1, with its
hardware: 640 x 480, f about 1413 px, DENSO VP-6242 with 0.02 mm and 0.005 deg repeatability; touched with 0.02 mm per
axis. Every seed is another cell: 14 stops to calibrate, then 32 to measure, four views a point, from images and
reported poses alone. Another seed is another scene, camera, mounting and noise.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from cv_active_handeye.workflow.experiment import ExperimentResult, experiment

from . import cluster
from .cluster import Workers
from .report import Cell, Measure, Report, Table, finish, parser
from .scene import Array

RMS_MM, LARGEST_MM = 0.12, 0.30
"""Limits of the medians over the seeds."""
RATIO = 1.1
STATED, SLACK = 95.0, 2.0
PAPER = ("the paper's Table 1, recomputed", 0.60, 1.18)


@dataclass(frozen=True)
class Run:
    """One seed: differences (15, 3) and their stated standard deviations (15, 3), mm; which intervals hold."""

    seed: int
    differences: Array
    sigmas: Array
    inside: list[bool]
    views: int

    @property
    def rms(self) -> float:
        """Root of the mean squared distance, mm."""
        return float(np.sqrt(np.mean(np.sum(self.differences**2, axis=1))))

    @property
    def largest(self) -> float:
        """Of the distances, mm."""
        return float(np.linalg.norm(self.differences, axis=1).max())

    @property
    def predicted(self) -> float:
        """RMS distance by the stated covariances, mm."""
        return float(np.sqrt(np.mean(np.sum(self.sigmas**2, axis=1))))

    def row(self) -> list[Cell]:
        """Columns of the table."""
        axes = [float(value) for value in np.sqrt(np.mean(self.differences**2, axis=0))]
        held = f"{sum(self.inside)} of {len(self.inside)}"
        return [str(self.seed), self.rms, self.predicted, self.largest, *axes, held, self.views]


def run(number: int, seeds: Sequence[int], keep: Path | None) -> Run:
    """The experiment of one seed; `keep`: where its files stay."""
    with tempfile.TemporaryDirectory() as temporary:
        result = experiment((keep or Path(temporary)) / f"seed{seeds[number]}", seeds[number])
    return summary(seeds[number], result)


def summary(seed: int, result: ExperimentResult) -> Run:
    """What of an experiment is kept."""
    differences = 1000 * np.array([point.difference for point in result.points])
    sigmas = 1000 * np.sqrt([point.variances for point in result.points])
    return Run(seed, differences, sigmas, result.inside, sum(len(point.measured.views) for point in result.points))


def coverage(runs: Sequence[Run]) -> tuple[float, float]:
    """Share (per cent) of the intervals that hold the touched value, and its standard error by whole runs."""
    shares = [100 * float(np.mean(one.inside)) for one in runs]
    error = float(np.std(shares, ddof=1) / np.sqrt(len(shares))) if len(shares) > 1 else float("nan")
    return float(np.mean(shares)), error


def ratio(runs: Sequence[Run]) -> float:
    """RMSE over all runs / what the covariances predict."""
    return float(np.sqrt(np.mean([r.rms**2 for r in runs]) / np.mean([r.predicted**2 for r in runs])))


def table(runs: Sequence[Run]) -> Table:
    """One line a seed, then medians, limits and the paper's."""
    rows = [one.row() for one in runs]
    medians = [float(np.median([row[k] for row in rows])) for k in range(1, 7)]
    rows.append(["median", *medians, "", None])
    rows.append(["limit of the median", RMS_MM, None, LARGEST_MM, None, None, None, "", None])
    rows.append([PAPER[0], PAPER[1], None, PAPER[2], None, None, None, "", None])
    columns = ("seed", "RMS [mm]", "predicted [mm]", "largest [mm]", "RMS x", "RMS y", "RMS z", "intervals", "views")
    share, error = coverage(runs)
    note = f"Intervals that hold the touched value: {share:.1f} % ± {error:.1f} %. RMSE / predicted: {ratio(runs):.3f}."
    return Table("15 points", columns, rows, note)


def measures(runs: Sequence[Run]) -> list[Measure]:
    """The limits of the experiment."""
    return [
        Measure("median over the seeds of the RMS of 15 points [mm]", float(np.median([r.rms for r in runs])), RMS_MM),
        Measure("median of the largest of 15 [mm]", float(np.median([r.largest for r in runs])), LARGEST_MM),
        Measure("RMSE / predicted", ratio(runs), RATIO),
        Measure("95 % intervals: coverage off by [%]", abs(coverage(runs)[0] - STATED), SLACK),
    ]


def measure(seeds: Sequence[int] = range(20), workers: Workers | None = None, keep: Path | None = None) -> Report:
    """All seeds."""
    trial = partial(run, seeds=list(seeds), keep=keep)
    runs = (workers or Workers()).run(trial, len(seeds), "experiment")
    setup = (
        f"{len(seeds)} cells, seeds {seeds[0]} to {seeds[-1]}. Distances between what the laser measures and what the "
        "robot's tip touches (0.02 mm per axis). views: of all points together. The errors of one calibration are "
        "common to the points of a seed."
    )
    return Report("The paper's experiment: 15 points measured with the laser", setup, [table(runs)], measures(runs))


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    line = parser(__doc__ or "")
    cluster.add_options(line)
    line.add_argument("--seeds", type=int, default=20, help="how many cells (default 20)")
    line.add_argument("--first", type=int, default=0, help="first seed (default 0)")
    line.add_argument("--keep", type=Path, help="keep data sets and results in this folder")
    options = line.parse_args(arguments)
    with cluster.start(options) as workers:
        report = measure(range(options.first, options.first + options.seeds), workers, options.keep)
    return finish(report, options.output)


if __name__ == "__main__":
    sys.exit(main())
