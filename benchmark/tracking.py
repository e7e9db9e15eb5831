# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Tracking against the exact correspondences of the simulated cell.

Every observation is compared with where the scene point at the track's reference position truly lies in that view. SIFT
alone is measured on the same tracks from its own positions. Wrong: more than 2 px off, or hidden in truth. Scenes:
the default cell, a dark one, one with lens distortion, one where all surfaces carry one small repeated tile.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cv_active_handeye.simulation import CellConfig, SimulatedCell, SimulatedView
from cv_active_handeye.tracking import TrackingConfig, Tracks, track_points

from .report import Measure, Report, Table, finish, parser, progress
from .scene import Array

WRONG_PX = 2.0
SIGMA, BIAS, TRACKS, WRONG, SECONDS = 0.09, 0.01, 1000, 0.01, 30.0
SCENES: dict[str, dict[str, object]] = {
    "default": {},
    "dark": {"exposure": 0.2},
    "lens distortion": {"distortion": (-0.12, 0.1, 0.001, -0.0005, 0.0)},
    "repeated texture": {"texture": "repeated"},
}


@dataclass(frozen=True)
class Errors:
    """Errors of the observations (n, 2) that are not references, inf where the point is hidden in truth, px; their
    views (n,), and the standard deviations (n,) the tracker states for them, reference included."""

    errors: Array
    views: NDArray[np.int64]
    sigmas: Array

    @property
    def robust_sigma(self) -> Array:
        """1.4826 times the median absolute deviation, per axis."""
        return np.asarray(1.4826 * np.median(np.abs(self.errors - self.bias), axis=0))

    @property
    def bias(self) -> Array:
        """Median error, per axis."""
        return np.asarray(np.median(self.errors, axis=0))

    @property
    def wrong(self) -> float:
        """Fraction of observations that are off by more than 2 px."""
        return self.beyond(WRONG_PX)

    def beyond(self, limit: float) -> float:
        """Fraction of observations whose distance from truth exceeds `limit`."""
        return float(np.mean(np.linalg.norm(self.errors, axis=1) > limit))

    def part(self, chosen: NDArray[np.bool_] | NDArray[np.int64]) -> Errors:
        """A selection of the observations."""
        return Errors(self.errors[chosen], self.views[chosen], self.sigmas[chosen])


def compare(cell: SimulatedCell, views: Sequence[SimulatedView], tracks: Tracks, points: Array) -> Errors:
    """Errors of positions `points` (V, N, 2) of the tracks against truth, from their own reference positions."""
    errors, where, sigmas = [], [], []
    for reference in np.unique(tracks.reference):
        for view in range(len(views)):
            chosen = np.flatnonzero((tracks.reference == reference) & np.isfinite(points[view, :, 0]))
            if view == reference or len(chosen) == 0:
                continue
            truth = cell.correspond(views[reference], views[view], points[reference, chosen])
            error = points[view, chosen] - truth
            errors.append(np.where(np.isfinite(error), error, np.inf))
            where.append(np.full(len(chosen), view))
            sigmas.append(np.hypot(tracks.sigmas[view, chosen], tracks.sigmas[reference, chosen]))
    return Errors(np.concatenate(errors), np.concatenate(where), np.concatenate(sigmas))


@dataclass(frozen=True)
class Run:
    """One scene tracked: errors of the refined positions and of SIFT's own on the same observations, and the times."""

    tracks: Tracks
    refined: Errors
    detected: Errors
    seconds: float
    processor_seconds: float


def run(scene: str, seed: int, config: TrackingConfig) -> Run:
    """Simulate the default 14 stops of a scene and track them."""
    cell = SimulatedCell(CellConfig.model_validate({"seed": seed, **SCENES[scene]}))
    show = progress(14, f"{scene}: images")
    views = []
    for index, pose in enumerate(cell.plan()):
        views.append(cell.capture(pose, index))
        show(index + 1)
    start, processor = time.perf_counter(), time.process_time()
    rotations = np.array([view.T_reported[:3, :3] for view in views])
    tracks = track_points([view.image for view in views], rotations, config)
    seconds, processor = time.perf_counter() - start, time.process_time() - processor
    refined = compare(cell, views, tracks, tracks.points)
    return Run(tracks, refined, compare(cell, views, tracks, tracks.detected), seconds, processor)


def accuracy_row(scene: str, result: Run) -> list[str | int | float | None]:
    """One line of the accuracy table."""
    found, sift = result.refined, result.detected
    return [
        scene,
        len(result.tracks),
        int(result.tracks.seen.sum()),
        *found.robust_sigma.tolist(),
        *found.bias.tolist(),
        100 * found.beyond(0.3),
        100 * found.wrong,
        *sift.robust_sigma.tolist(),
        *sift.bias.tolist(),
        result.seconds,
        result.processor_seconds,
    ]


def sigma_table(scene: str, result: Run, parts: int = 8) -> Table:
    """Stated standard deviation against the true error, observations sorted by it into equal parts."""
    rows = []
    for chosen in np.array_split(np.argsort(result.refined.sigmas), parts):
        part = result.refined.part(chosen)
        ratio = np.abs(part.errors) / part.sigmas[:, None]
        spread = float(1.4826 * np.median(np.abs(part.errors)))
        rows.append([float(np.median(part.sigmas)), spread, 1.4826 * float(np.median(ratio)),
                     float(np.percentile(ratio, 95)) / 1.96])  # fmt: skip
    columns = ("stated [px]", "true, robust [px]", "robust true / stated", "95 % point / 1.96")
    return Table(f"Standard deviations: {scene}", columns, rows)


def view_table(result: Run) -> Table:
    """Error per view."""
    rows = []
    for view in range(len(result.tracks.points)):
        part = result.refined.part(result.refined.views == view)
        rows.append([view, len(part.errors), *part.robust_sigma.tolist(), *part.bias.tolist(), 100 * part.wrong])
    columns = ("view", "observations", "sigma x [px]", "sigma y", "bias x [px]", "bias y", "wrong [%]")
    return Table("Default scene, view by view", columns, rows)


def measure(seed: int = 0, scenes: Sequence[str] = tuple(SCENES)) -> Report:
    """All scenes; the measures are those of the default scene, and few wrong observations on repeated texture."""
    runs = {scene: run(scene, seed, TrackingConfig()) for scene in scenes}
    columns = ("scene", "tracks", "observations", "sigma x [px]", "sigma y", "bias x [px]", "bias y", "> 0.3 px [%]",
               "wrong [%]", "SIFT sigma x", "SIFT sigma y", "SIFT bias x", "SIFT bias y", "time [s]",
               "processor [s]")  # fmt: skip
    tables = [Table("Accuracy", columns, [accuracy_row(scene, result) for scene, result in runs.items()])]
    measures = []
    if "default" in runs:
        tables += [sigma_table("default", runs["default"]), view_table(runs["default"])]
        measures = _measures(runs["default"])
    if "dark" in runs:
        tables.append(sigma_table("dark", runs["dark"]))
    setup = (
        f"Simulated cell, seed {seed}, the 14 stops of its plan, 640 x 480; default settings of the tracker. Tracks "
        "have three or more views; references, exact by definition, are not counted among the errors."
    )
    return Report("Tracking against exact correspondences", setup, tables, measures)


def _measures(result: Run) -> list[Measure]:
    found = result.refined
    return [
        Measure("robust sigma per axis [px]", float(found.robust_sigma.max()), SIGMA),
        Measure("bias [px]", float(np.abs(found.bias).max()), BIAS),
        Measure("tracks of three or more views", len(result.tracks), TRACKS, at_least=True),
        Measure("wrong observations, fraction", found.wrong, WRONG),
        Measure("processor time [s]", result.processor_seconds, SECONDS),
    ]


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    line = parser(__doc__ or "")
    line.add_argument("--seed", type=int, default=0, help="seed of the simulated cell")
    line.add_argument("--scenes", nargs="+", choices=list(SCENES), default=list(SCENES), help="default: all")
    options = line.parse_args(arguments)
    return finish(measure(options.seed, options.scenes), options.output)


if __name__ == "__main__":
    sys.exit(main())
