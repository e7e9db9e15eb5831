# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The weld joint of the simulated cell: its root, measured with a calibration from the cell's own images.

The paper's application: a V-groove of 60 degrees, 12 mm deep, with a root gap of 1.5 mm. Every seed is another cell:
14 stops to calibrate, then 20 stops of 10 mm across the bench, from images and reported poses alone. Distances are
perpendicular to the line in which the two faces would meet.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from cv_active_handeye.simulation import CellConfig, SimulatedCell
from cv_active_handeye.workflow import calibrate
from cv_active_handeye.workflow.demo_seam import measure_joint
from cv_active_handeye.workflow.reporter import Silent

from . import cluster
from .cluster import Workers
from .report import Cell, Measure, Report, Table, finish, parser
from .scene import Array

RMS_MM, STATED, SLACK = 0.25, 95.0, 5.0
"""Limits: of the median RMS, and of the coverage."""


@dataclass(frozen=True)
class Run:
    """One seed: distances (N,) from the true root and stated standard deviations (N,) in the worst direction, mm;
    inside: share of the intervals across the seam, vertical and horizontal, that hold the truth."""

    seed: int
    distances: Array
    sigmas: Array
    inside: float
    length: float

    @property
    def rms(self) -> float:
        """Root of the mean squared distance, mm."""
        return float(np.sqrt(np.mean(self.distances**2)))


def run(number: int, seeds: Sequence[int]) -> Run:
    """Calibrates and measures one cell."""
    config = CellConfig(seed=seeds[number])
    with tempfile.TemporaryDirectory() as folder:
        calibration = calibrate(SimulatedCell(config).record(Path(folder) / "cell"))
        joint = measure_joint(Path(folder), config, calibration, Silent())
    start, end = joint.root
    direction = (end - start) / np.linalg.norm(end - start)
    across = np.linalg.svd(np.eye(3) - np.outer(direction, direction))[0][:, :2]
    errors = (joint.seam.points - start) @ across
    variances = np.einsum("ik,nij,jk->nk", across, joint.seam.covariances, across)
    inside = float(np.mean(np.abs(errors) < 1.96 * np.sqrt(variances)))
    return Run(seeds[number], 1000 * joint.distances, 1000 * joint.seam.sigmas, inside, 1000 * joint.seam.length)


def measure(seeds: Sequence[int] = range(10), workers: Workers | None = None) -> Report:
    """All seeds."""
    runs = (workers or Workers()).run(partial(run, seeds=list(seeds)), len(seeds), "seam")
    rows: list[list[Cell]] = [
        [str(r.seed), len(r.distances), r.length, r.rms, float(r.distances.max()), float(np.median(r.sigmas)), r.inside]
        for r in runs
    ]
    columns = ("seed", "profiles", "length [mm]", "RMS [mm]", "largest [mm]", "stated sigma [mm]", "intervals held")
    share = 100 * float(np.mean([r.inside for r in runs]))
    median = float(np.median([r.rms for r in runs]))
    setup = (
        f"{len(seeds)} cells, seeds {seeds[0]} to {seeds[-1]}; the joint is 170 mm long. The points of a seed share "
        "the errors of its calibration."
    )
    limits = [
        Measure("weld root: median over the seeds of the RMS distance [mm]", median, RMS_MM),
        Measure("weld root: coverage of the 95 % intervals off by [%]", abs(share - STATED), SLACK),
    ]
    return Report("Root of a weld joint", setup, [Table("Distance from the true root", columns, rows)], limits)


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    line = parser(__doc__ or "")
    cluster.add_options(line)
    line.add_argument("--seeds", type=int, default=10, help="how many cells (default 10)")
    options = line.parse_args(arguments)
    with cluster.start(options) as workers:
        report = measure(range(options.seeds), workers)
    return finish(report, options.output)


if __name__ == "__main__":
    sys.exit(main())
