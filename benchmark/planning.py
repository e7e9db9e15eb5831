# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Planned stops against the paper's set of motions and against a board: predicted and reached accuracy, motor time.

Both robots of the simulated cell. The planner knows rough mounting and optics (20 mm, 2 degrees, 1 %), and keeps
joint limits and singularities; its plans are then judged in the true cell. The paper's set is that of the other
benchmarks: two groups of five stops and turns, more groups and turns with more stops.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from cv_active_handeye.report.pictures import GROUP_COLOURS, save_figure
from cv_active_handeye.workflow.plan_knowledge import predict

from . import cluster
from .planning_cells import NOISE, PAPER, POINTS, ROBOTS, PlanningCell, Robot, board_error, board_world, refined_error
from .report import Cell, Measure, Report, Table
from .scene import Array
from .world import World

SEEDS = (1, 2, 3)
RATIO, OFF_PERCENT, SECONDS = 0.7, 15.0, 10.0
PICTURE = Path(__file__).parents[1] / "out/benchmark/planning.png"
WAYS = PLANNED, PAPERS, OPENCV = "planned", "the paper's set", "OpenCV, board, random poses"


@dataclass(frozen=True)
class Reached:
    """RMS errors of one way with so many stops over all trials: rotation [deg], t_cam2gripper [mm]; motor time."""

    way: str
    robot: Robot
    stops: int
    predicted_mm: float | None
    rmse: Array
    seconds: float

    @property
    def off_percent(self) -> float | None:
        """By which the prediction is off."""
        return None if self.predicted_mm is None else 100 * (self.predicted_mm / float(self.rmse[1]) - 1)

    def row(self) -> list[Cell]:
        """A line of the table."""
        turn, shift = self.rmse.tolist()
        return [self.robot, self.stops, self.way, self.predicted_mm, shift, self.off_percent, turn, self.seconds]


def sigma(cell: PlanningCell, poses: Sequence[Array]) -> float:
    """Predicted in the true cell, mm."""
    found = predict(poses, cell.truth).t_cam2gripper_mm
    return float("nan") if found is None else found


def against_paper() -> tuple[Table, list[Measure]]:
    """Predicted sigma of t_cam2gripper, planned over the paper's, with as many stops; and how long planning takes."""
    rows: list[list[Cell]] = []
    worst: dict[int, float] = {}
    slowest = 0.0
    for robot in ROBOTS:
        for seed in SEEDS:
            cell = PlanningCell.simulated(robot, seed)
            for stops in (12, 24):
                before = time.process_time()
                planned = cell.planned(stops)
                seconds = time.process_time() - before
                slowest = max(slowest, seconds if stops == 24 else 0)
                theirs = cell.paper(stops, seed)
                ours_mm, theirs_mm = sigma(cell, planned), sigma(cell, theirs)
                worst[stops] = max(worst.get(stops, 0), ours_mm / theirs_mm)
                motor = [cell.seconds(planned), cell.seconds(theirs)]
                rows.append([robot, seed, stops, ours_mm, theirs_mm, ours_mm / theirs_mm, *motor, seconds])
    columns = ("robot", "seed", "stops", "planned [mm]", "paper's set [mm]", "ratio", "motor time, planned [s]")
    table = Table(
        "Predicted standard deviation of t_cam2gripper", (*columns, "paper's set [s]", "planning takes [s]"), rows
    )
    measures = [
        Measure(f"{stops} stops: predicted sigma, planned / the paper's set, largest", ratio, RATIO)
        for stops, ratio in worst.items()
    ]
    return table, [*measures, Measure("plan for 24 stops: time [s], longest", slowest, SECONDS)]


def trial(world: World, key: tuple[int, ...], number: int) -> Array:
    """Squared errors (1, 2) of ours with another noise."""
    return refined_error(world, np.random.default_rng([*key, number]))[None]


def board_trial(world: World, key: tuple[int, ...], number: int) -> Array:
    """Squared errors (5, 2) of OpenCV's methods with other noise and other poses, as many as the world has."""
    rng = np.random.default_rng([*key, number])
    return board_error(board_world(world, rng, len(world.R_gripper2base)), rng)


def reached(workers: cluster.Workers, robot: Robot, stops: int, way: str, trials: int, seed: int) -> Reached:
    """Monte Carlo of one way."""
    cell, what = PlanningCell.simulated(robot, seed), f"{robot}, {stops} stops, {way}"
    key = seed, ROBOTS.index(robot), stops, WAYS.index(way)
    poses = cell.planned(stops) if way == PLANNED else cell.paper(stops, seed)
    world = cell.world(poses)
    if way == OPENCV:
        found = workers.run(partial(board_trial, world, key), trials, what)
        seconds = cell.seconds_nearest_next(board_world(world, np.random.default_rng(key), stops))
        predicted = None
    else:
        found = workers.run(partial(trial, world, key), trials, what)
        seconds, predicted = cell.seconds(poses), sigma(cell, poses)
    rmse = np.sqrt(np.nanmean(np.array(found), axis=0))
    return Reached(way, robot, stops, predicted, rmse[np.argmin(rmse[:, 1])], seconds)


def draw(path: Path, found: Sequence[Reached]) -> None:
    """Accuracy against number of stops and against motor time."""
    figure = Figure(figsize=(10, 4.2), layout="constrained")
    by_stops, by_time = figure.subplots(1, 2, sharey=True)
    for colour, way in zip(GROUP_COLOURS, WAYS, strict=False):
        for robot, style in zip(ROBOTS, ("o-", "s--"), strict=True):
            rows = [row for row in found if row.way == way and row.robot == robot]
            errors = [float(row.rmse[1]) for row in rows]
            by_stops.plot([row.stops for row in rows], errors, style, color=colour, label=f"{way}, {robot}")
            by_time.plot([row.seconds for row in rows], errors, style, color=colour)
    by_stops.set(xlabel="stops", ylabel="RMS error of t_cam2gripper [mm]", ylim=(0, None))
    by_time.set(xlabel="motor time [s]")
    for axes in (by_stops, by_time):
        axes.grid(True, linewidth=0.3)
    figure.legend(loc="outside lower center", ncols=3, frameon=False)
    save_figure(figure, path)


def measure(workers: cluster.Workers, trials: int = 300, seed: int = 1, picture: Path = PICTURE) -> Report:
    """Predictions, then trials of every way with every number of stops."""
    table, measures = against_paper()
    found = [reached(workers, robot, stops, way, trials, seed) for robot in ROBOTS for stops in PAPER for way in WAYS]
    columns = ("robot", "stops", "way", "predicted [mm]", "RMSE of t [mm]", "off [%]", "RMSE of R [deg]")
    note = "OpenCV: the best of its methods; it needs a board, and its poses are not held against the arm's limits."
    rows = [row.row() for row in found]
    accuracy = Table("Accuracy against number of stops", (*columns, "motor time [s]"), rows, note)
    worst = max(abs(row.off_percent) for row in found if row.off_percent is not None)
    measures.append(Measure("prediction against Monte Carlo: off by [%], largest", worst, OFF_PERCENT))
    draw(picture, found)
    setup = (
        f"{trials} trials, seed {seed}; {NOISE.point_px} px, robot {NOISE.robot_mm} mm / {NOISE.robot_deg} deg, K "
        f"unknown, no distortion, {POINTS} scene points over 0.4 x 0.4 m. Predictions for cells of {len(SEEDS)} seeds. "
        "Motor time: straight lines at 50 mm/s and 0.2 m/s^2, turns at 15 deg/s, 1 s to settle at every stop; OpenCV's "
        "stops the nearest next. Planning time: of the processor."
    )
    return Report("Planned stops", setup, [table, accuracy], measures)


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""

    def run(workers: cluster.Workers, options: argparse.Namespace) -> Report:
        return measure(workers, options.trials, options.seed)

    return cluster.main(__doc__, run, 300, "trials per way and number of stops", arguments)


if __name__ == "__main__":
    sys.exit(main())
