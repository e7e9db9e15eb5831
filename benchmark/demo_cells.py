# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The simulated cells of demo.py: their stops, how they are recorded and calibrated, and what came out of one."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path

import numpy as np

import cv_active_handeye as cah
from cv_active_handeye.calibration import Calibration
from cv_active_handeye.report import CalibrationErrors, calibration_errors, inside_intervals
from cv_active_handeye.simulation import CellConfig, SimulatedCell, Truth
from cv_active_handeye.simulation.motion import Look, camera_poses, default_looks
from cv_active_handeye.workflow import calibrate
from cv_active_handeye.workflow.demo import DemoResult, demo
from cv_active_handeye.workflow.reporter import InsufficientDataError

from .report import Cell
from .scene import Array

NAMES = [field.name for field in fields(CalibrationErrors)]
LENS = (-0.12, 0.08, 0.0, 0.0, 0.0)
GROUP = default_looks()[0].stops
HERE = np.zeros((1, 3))
LOOKS_12 = [*default_looks()[:2], Look((18, 0, -90), HERE), Look((-18, 0, -35), HERE)]
LOOKS_24 = [
    *default_looks()[:2],
    *(Look((18, 0, -90), 0.6 * GROUP), Look((-18, 0, -35), 0.6 * GROUP)),
    *(Look((0, -18, -90), HERE), Look((12, -12, -60), HERE), Look((-12, 12, -35), HERE), Look((0, 18, 0), HERE)),
]
"""As in stops.py: 2 x 5 + 2 and 4 x 5 + 4 stops, at orientations that the arm reaches over the bench."""


@dataclass(frozen=True)
class Recipe:
    """A kind of recording; `looks` None: the whole demo with its own 14 stops, pictures and report."""

    name: str
    looks: list[Look] | None = None
    distortion: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)


RECIPES = {
    recipe.name: recipe
    for recipe in (
        Recipe("demo, 14 stops"),
        Recipe("24 stops", LOOKS_24),
        Recipe("12 stops", LOOKS_12),
        Recipe("24 stops, distorted", LOOKS_24, LENS),
        Recipe("12 stops, distorted", LOOKS_12, LENS),
    )
}


@dataclass(frozen=True)
class Run:
    """One cell: errors (NaN where it failed), which 95 % intervals held the truth, what was used, and seconds."""

    recipe: str
    seed: int
    errors: CalibrationErrors
    inside: dict[str, bool]
    tracks: int = 0
    rms_px: float = float("nan")
    lens: str = "-"
    usable: bool = False
    beyond_limits: bool = False
    seconds: float = 0.0
    cpu_seconds: float = 0.0
    problem: str = ""

    def row(self) -> list[Cell]:
        """Columns of the table."""
        held = f"{sum(self.inside.values())} of {len(self.inside)}"
        shown = [None if np.isnan(e) else float(e) for e in astuple(self.errors)]
        verdict: list[Cell] = [held, self.lens, "yes" if self.usable else "no"]
        return [str(self.seed), *shown, *verdict, self.tracks, self.rms_px, self.seconds, self.cpu_seconds]


def run(number: int, recipes: Sequence[str], seeds: Sequence[int], keep: Path | None) -> Run:
    """Simulates and calibrates the cell of one recipe and seed; `keep`: where its files stay."""
    recipe, seed = recipes[number // len(seeds)], seeds[number % len(seeds)]
    clock, processors = time.perf_counter(), time.process_time()
    with tempfile.TemporaryDirectory() as temporary:
        folder = (keep or Path(temporary)) / recipe.replace(", ", "_").replace(" ", "_") / f"seed{seed}"
        try:
            calibration, truth, beyond = _calibrate(RECIPES[recipe], seed, folder)
        except (cah.error, InsufficientDataError) as error:
            failed = CalibrationErrors(*[float("nan")] * len(NAMES))
            return Run(recipe, seed, failed, {}, problem=f"{recipe}, seed {seed}: {error}")
    errors = astuple(calibration_errors(calibration, truth))
    verdict, lens, rms = calibration.verdict, calibration.lens, calibration.rms.points_px
    return Run(
        recipe,
        seed,
        CalibrationErrors(*(float("nan") if e is None else e for e in errors)),
        inside_intervals(calibration, truth),
        calibration.points,
        float("nan") if rms is None else rms,
        "-" if lens is None else lens.model,
        verdict is not None and verdict.usable,
        beyond,
        time.perf_counter() - clock,
        time.process_time() - processors,
    )


def _calibrate(recipe: Recipe, seed: int, folder: Path) -> tuple[Calibration, Truth, bool]:
    """The result, the truth, and whether the demo would have called it beyond its limits."""
    config = CellConfig(seed=seed, distortion=recipe.distortion)
    if recipe.looks is None:
        result: DemoResult = demo(folder, config)
        return result.calibration, result.truth, bool(result.beyond_limits())
    cell = SimulatedCell(config)
    dataset = cell.record(folder / "dataset", poses=gripper_poses(cell, recipe.looks))
    return calibrate(dataset), cell.truth, False


def gripper_poses(cell: SimulatedCell, looks: list[Look]) -> list[Array]:
    """Commanded poses (4, 4), gripper to base, from which the camera looks as `looks` say, over the same bench."""
    cam2gripper = np.eye(4)
    cam2gripper[:3, :3], cam2gripper[:3, 3] = cell.truth.R_cam2gripper, cell.truth.t_cam2gripper
    anywhere = np.zeros(3)
    first, *_ = camera_poses(default_looks(), anywhere)
    bench2base = cell.plan()[0] @ cam2gripper @ np.linalg.inv(first)
    return [bench2base @ pose @ np.linalg.inv(cam2gripper) for pose in camera_poses(looks, anywhere)]
