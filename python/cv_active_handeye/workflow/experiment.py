# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The paper's experiment in the simulated cell: calibrate, measure 15 points with the laser, compare with touched ones.

Ten points are on the letters of a flat text, five on blocks 2 to 47 mm above it. Stripe and strokes are found in the
images; only where to look is told, to some pixels, as by a click of the mouse.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..calibration import Calibration
from ..dataset import Dataset
from ..files import FloatArray
from ..measured_points import NEEDED, REFERENCE, SIGMA, read_point_rows, write_measured
from ..report.verdict import NORMAL_95
from ..simulation import CellConfig, SimulatedCell
from ..simulation.marks import views_of
from .calibrate import calibrate
from .measure import MeasuredPoint, measure
from .profiles import Profiler, find_profiles, profiler
from .reporter import InsufficientDataError, Reporter, Silent
from .strokes import Crossing, stroke_crossing

TOUCH_SIGMA = 0.02e-3
"""Metres per axis: the paper's robot touches the points with a positioning accuracy of 0.02 mm."""

EXPOSURE = 0.7
"""The stripe on white paper is not saturated."""

LEAST_VIEWS = 2
_CLICK_PX = 3.0
_CLICKS, _TOUCHES = 5, 6  # keys of the random streams, beside those of the cell


@dataclass(frozen=True)
class ExperimentPoint:
    """One of the points S1 to S15, base frame, metres.

    measured: as `measure` gives it; touched (3,): what the robot's tip says; true (3,): mean of the places on the
    stroke that its views lit; half_widths (3,): of the 95 % intervals of the difference, with the touch.
    """

    measured: MeasuredPoint
    touched: FloatArray
    true: FloatArray

    @property
    def difference(self) -> FloatArray:
        """Measured minus touched (3,)."""
        return np.asarray(self.measured.position - self.touched)

    @property
    def variances(self) -> FloatArray:
        """Of `difference` (3,), m^2: what measuring states, and the touch."""
        return np.asarray(np.diag(self.measured.covariance) + TOUCH_SIGMA**2)

    @property
    def half_widths(self) -> FloatArray:
        """Halves of the 95 % intervals of `difference` (3,)."""
        return np.asarray(NORMAL_95 * np.sqrt(self.variances))


@dataclass(frozen=True)
class ExperimentResult:
    """The points in their order, the calibration they were measured with, and where all files are."""

    folder: Path
    calibration: Calibration
    points: tuple[ExperimentPoint, ...]

    @property
    def distances(self) -> FloatArray:
        """Lengths of the differences (15,), m."""
        return np.array([np.linalg.norm(point.difference) for point in self.points])

    @property
    def rms(self) -> float:
        """Root of the mean squared distance, m."""
        return float(np.sqrt(np.mean(self.distances**2)))

    @property
    def predicted_rms(self) -> float:
        """What `rms` should be, by the stated covariances, m."""
        return float(np.sqrt(np.mean([point.variances.sum() for point in self.points])))

    @property
    def inside(self) -> list[bool]:
        """Of all coordinates of all points: whether the difference is in its 95 % interval."""
        return [bool(held) for p in self.points for held in np.abs(p.difference) <= p.half_widths]


def experiment(folder: str | Path, seed: int = 0, reporter: Reporter | None = None) -> ExperimentResult:
    """Records the two motions of cell `seed`, calibrates with the first and measures in the second.

    Writes `calibration_views/` (14 stops), `measuring_views/` (32), `calibration.yaml` and `points.csv`, the input of
    `measure`, into `folder`. FileExistsError where a data set is there already.
    """
    folder, reporter = Path(folder), reporter or Silent()
    config = CellConfig(seed=seed, scene="experiment", exposure=EXPOSURE)
    cell = SimulatedCell(config)
    recorded = cell.record(folder / "calibration_views", reporter.step("recording the calibration"))
    calibration = calibrate(recorded, reporter=reporter)
    calibration.save(folder / "calibration.yaml")
    cell = SimulatedCell(config.model_copy(update={"motion": "experiment"}))
    dataset = cell.record(folder / "measuring_views", reporter.step("recording the 15 points"))
    return _measured(folder, cell, dataset, calibration, reporter)


def _measured(
    folder: Path, cell: SimulatedCell, dataset: Dataset, calibration: Calibration, reporter: Reporter
) -> ExperimentResult:
    poses = [_pose(view.R_gripper2base, view.t_gripper2base) for view in cell.truth.views]
    lit = [cell.crossings(pose) for pose in poses]
    clicks = np.random.default_rng([cell.config.seed, _CLICKS])
    seen = _find(profiler(dataset, calibration, reporter), [pixels for _, pixels in lit], clicks, cell, reporter)
    truths = [np.mean([lit[view][0][number] for view in views], axis=0) for number, views in enumerate(seen)]
    touches = np.random.default_rng([cell.config.seed, _TOUCHES])
    touched = np.array(truths) + touches.normal(0, TOUCH_SIGMA, (len(truths), 3))
    file = folder / "points.csv"
    _write_points(file, [mark.name for mark in cell.marks], seen, touched)
    points = measure(dataset, calibration, read_point_rows(file), reporter)
    found = [ExperimentPoint(*one) for one in zip(points, touched, truths, strict=True)]
    return ExperimentResult(folder, calibration, tuple(found))


def _find(
    tool: Profiler,
    exact: Sequence[FloatArray],
    clicks: np.random.Generator,
    cell: SimulatedCell,
    reporter: Reporter,
) -> list[dict[int, Crossing]]:
    """For every mark the crossings by view. Clicked at: the exact pixels (views, marks, 2), some pixels off."""
    profiles = find_profiles(tool, list(range(len(exact))), reporter)
    progress = reporter.step(f"finding {len(cell.marks)} points in {len(exact)} views")
    found: list[dict[int, Crossing]] = []
    for number, mark in enumerate(cell.marks):
        crossings: dict[int, Crossing] = {}
        for view in views_of(number):
            click = np.rint(exact[view][number] + clicks.uniform(-_CLICK_PX, _CLICK_PX, 2))
            try:
                crossings[view] = stroke_crossing(tool, profiles[view], click)
            except InsufficientDataError as error:
                reporter.note(f"point {mark.name}: left out in view {view}, {error}")
        if len(crossings) < LEAST_VIEWS:
            raise InsufficientDataError(f"point {mark.name}: needs {LEAST_VIEWS} views, found in {len(crossings)}")
        found.append(crossings)
        progress(number + 1, len(cell.marks))
    return found


def _write_points(file: Path, names: Sequence[str], seen: Sequence[dict[int, Crossing]], touched: FloatArray) -> None:
    rows = [
        [name, str(view), *(f"{x:.4f}" for x in (*crossing.pixel, crossing.sigmas[0], *(1000 * reference)))]
        for name, crossings, reference in zip(names, seen, touched, strict=True)
        for view, crossing in crossings.items()
    ]
    write_measured(file, [*NEEDED, SIGMA, *REFERENCE], rows)


def _pose(R: FloatArray, t: FloatArray) -> FloatArray:
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = R, t
    return out
