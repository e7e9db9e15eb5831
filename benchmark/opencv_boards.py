# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""refineHandEye without a target against OpenCV at its best, with a chessboard; K is unknown to both.

Two motions: stops made for calibration without a target, and stops made for a board (tilt about x and y up to 30
degrees, roll up to 90, 0.45 to 0.65 m, the whole board in every image). OpenCV gets a 9 x 6 board of 20 mm squares, is
told that there is no distortion, and counts with the best of its five methods. Ours gets 400 or 60 tracks of the scene
instead, or the corners of the board.

The board's stops have no two views of equal orientation, which the closed forms need. There ours starts from a rough
guess: f wrong by 3 %, the principal point in the middle of the image, 2 degrees and 20 mm off. On the board it starts
from OpenCV's result.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

import cv_active_handeye as cah

from . import boards, cluster
from .fisher import bound
from .refine_trials import PINHOLE, calibrate, settings
from .report import Cell, Measure, Report, Table
from .rough import NO_START, Start, rough_start
from .scene import Array
from .stops import STOPS_12, STOPS_24, active_stops
from .world import ROTATION, TRANSLATION, Noise, World, random_world

NOISE = Noise(0.1, 0.02, 0.01)
TRACKS = (400, 60)
BOARD = boards.corners()
MOTIONS = {"made for no target": False, "made for a board": True}
THIRD, BOARD_RATIO = 1 / 3, 1.25
OURS = [f"ours, {n} tracks" for n in TRACKS]
OURS_BOARD = "ours, board"


def error_with_bound(world: World, rng: np.random.Generator, start: Start, objects: Array | None) -> Array:
    """Rotation [deg] and translation [mm]: error of refineHandEye (NaN when refused), then their bounds."""
    recording = world.record(rng, NOISE)
    variances = np.diag(bound(world, NOISE, PINHOLE))
    limits = [np.degrees(np.sqrt(variances[ROTATION].sum())), 1000 * np.sqrt(variances[TRANSLATION].sum())]
    try:
        if objects is not None:
            found = boards.opencv(recording, objects)
            R, t = found.hand_eye["Park"]
            start = found.camera_matrix, None, R, t, None
        _, _, R, t, _ = calibrate(world, recording, settings(cah.LENS_FIXED), start, objects).calibration
    except cah.error:
        return np.array([np.nan, np.nan, *limits])
    return np.array([*boards.hand_eye_error(world, R, t), *limits])


def trial(views: int, for_board: bool, seed: int, number: int) -> dict[str, Array]:
    """Errors and bounds (4) of every way of calibrating, in one world."""
    rng = np.random.default_rng([seed, number])
    stops = STOPS_24 if views == 24 else STOPS_12
    motion = boards.board_stops(rng, views, BOARD) if for_board else active_stops(rng, stops)
    world = random_world(rng, motion, max(TRACKS))
    board = boards.put_board(rng, world, BOARD)
    missing = np.full(2, np.nan)
    theirs = boards.opencv(board.record(rng, NOISE), BOARD).hand_eye
    errors = {
        name: np.append(boards.hand_eye_error(world, *theirs[name]) if name in theirs else missing, missing)
        for name in boards.METHODS
    }
    errors[OURS_BOARD] = error_with_bound(board, rng, NO_START, BOARD)
    for name, count in zip(OURS, TRACKS, strict=True):
        part = replace(world, points=world.points[:count], visible=world.visible[:, :count])
        errors[name] = error_with_bound(part, rng, rough_start(rng, world) if for_board else NO_START, None)
    return errors


class Comparison:
    """RMS errors (rotation, translation) of every method on one motion, over the trials that gave an answer."""

    def __init__(self, trials: Sequence[dict[str, Array]]) -> None:
        columns = {name: np.array([found[name] for found in trials]) for name in trials[0]}
        self.failed = {name: int(np.isnan(column[:, 0]).sum()) for name, column in columns.items()}
        self.rmse = {name: np.sqrt(np.nanmean(column[:, :2] ** 2, axis=0)) for name, column in columns.items()}
        self.median = {name: np.nanmedian(column[:, :2], axis=0) for name, column in columns.items()}
        self.bounds = {name: np.sqrt(np.mean(columns[name][:, 2:] ** 2, axis=0)) for name in (OURS_BOARD, *OURS)}
        self.best = np.min([self.rmse[name] for name in boards.METHODS], axis=0)

    def table(self, title: str, best_of_all: Array) -> Table:
        """One line a method."""
        rows: list[list[Cell]] = []
        for name, rmse in self.rmse.items():
            limits = self.bounds[name].tolist() if name in self.bounds else [None, None]
            against = [*(rmse / self.best).tolist(), *(rmse / best_of_all).tolist()]
            middle = self.median[name].tolist()
            rows.append([name, self.failed[name], *rmse.tolist(), *middle, *limits, *against])
        units = ("[deg]", "[mm]")
        columns = [f"{what} {unit}" for what in ("RMSE", "median", "bound") for unit in units]
        columns += [f"RMSE / best of OpenCV {unit}" for unit in ("R", "t")]
        columns += [f"/ its best of both motions {unit}" for unit in ("R", "t")]
        return Table(title, ("method", "refused", *columns), rows)

    def measures(self, title: str) -> list[Measure]:
        """The limits of ours."""
        found = [Measure(f"{title}: refused, {name}", self.failed[name], 0) for name in (OURS_BOARD, *OURS)]
        few, board = self.rmse[OURS[1]] / self.rmse[OURS_BOARD], self.rmse[OURS[0]] / self.best
        for at, what in enumerate(("rotation", "t_cam2gripper")):
            found.append(Measure(f"{title}: {what}, 400 tracks / best of OpenCV", float(board[at]), THIRD))
            found.append(Measure(f"{title}: {what}, 60 tracks / our board", float(few[at]), BOARD_RATIO))
        return found


def measure(workers: cluster.Workers, trials: int = 400, seed: int = 1) -> Report:
    """12 and 24 stops of both motions."""
    tables, measures = [], []
    for views in (12, 24):
        found = {}
        for motion, for_board in MOTIONS.items():
            title = f"{views} stops {motion}"
            found[title] = Comparison(workers.run(partial(trial, views, for_board, seed), trials, title))
        best = np.min([comparison.best for comparison in found.values()], axis=0)
        for title, comparison in found.items():
            tables.append(comparison.table(title, best))
            measures += comparison.measures(title)
    setup = (
        f"{trials} trials, seed {seed}; {NOISE.point_px} px, robot {NOISE.robot_mm} mm / {NOISE.robot_deg} deg, no "
        "distortion, which all are told; K unknown. OpenCV: calibrateCamera and calibrateHandEye on a 9 x 6 board of "
        "20 mm squares. ours: refineHandEye, noise levels estimated. Where the motion is made for a board, ours starts "
        "from a rough guess (f 3 %, 2 deg, 20 mm off), else from nothing; on the board from OpenCV's result (Park)."
    )
    return Report("Without a target against OpenCV with a board", setup, tables, measures)


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    return cluster.main(
        __doc__, lambda workers, o: measure(workers, o.trials, o.seed),
        400, "trials per motion and number of stops", arguments,
    )


if __name__ == "__main__":
    sys.exit(main())
