# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The light plane: calibrateLightPlane and refineHandEye against the Cramér-Rao bound, and the simulated cell's truth.

First synthetic stripes with independent noise on planes, two groups of five views. calibrateLightPlane knows K and
R_cam2gripper, not t_cam2gripper: a surface that two groups see is two surfaces to it. refineHandEye estimates
everything. Then the rendered cell of `cv-active-handeye demo`, from images to a joint refinement with the stripes of
its two groups of five stops; and how many of its stripe segments got the surface that they lie on.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.stats import norm

import cv_active_handeye as cah

from . import cluster
from .light_plane_bound import light_plane_bound
from .light_plane_cells import CellRun, run
from .refine_trials import Case, Outcomes
from .refine_trials import trial as refine_trial
from .report import Cell, Measure, Report, Table
from .scene import Array
from .stops import STOPS_12, active_stops
from .stripes import random_stripes
from .world import NAMES, Noise, random_world

STOPS = (5, 5)
CASES = {f"{surfaces} surfaces": surfaces for surfaces in (2, 4)}
JOINT = Case("refineHandEye, 4 surfaces", stops=STOPS_12, stripes=True)
NORMAL, OFFSET = [NAMES.index(name) for name in ("nx", "ny", "nz")], [NAMES.index("d")]
QUANTITIES = {"normal [deg]": (slice(0, 3), float(np.degrees(1))), "offset [mm]": (slice(3, 4), 1000.0)}
LIMIT, STATED, SLACK = 1.1, 95.0, 2.0
CELL_LIMITS = {"normal [deg]": 0.01, "offset [mm]": 0.05}
LABELLED, WRONG = 85.0, 1.0
"""Of the segments whose surface two views or more show, per cent."""
POINTS = 15
"""Of a segment."""


@dataclass(frozen=True)
class PlaneTrial:
    """One recording: error (4) of nx, ny, nz, d, variances (4) of the bound and as returned."""

    error: Array
    bound: Array
    stated: Array

    @property
    def covered(self) -> Array:
        """Which 95 % intervals hold the truth."""
        return np.asarray(np.abs(self.error) <= norm.ppf(0.975) * np.sqrt(self.stated), dtype=np.float64)


def trial(surfaces: int, seed: int, number: int) -> PlaneTrial:
    """calibrateLightPlane in a random world, with exact poses, K and R_cam2gripper."""
    rng = np.random.default_rng([seed, number])
    stripes = random_stripes(rng, surfaces, POINTS)
    world = random_world(rng, active_stops(rng, STOPS), points=4, stripes=stripes)
    noise = Noise(robot_mm=0, robot_deg=0)
    recording = world.record(rng, noise)
    _, plane, covariance = cah.calibrateLightPlane(
        recording.R_gripper2base,
        recording.t_gripper2base,
        recording.stripe_points,
        recording.stripe_views,
        recording.surface_ids,
        world.camera_matrix,
        world.dist_coeffs,
        world.R_cam2gripper,
    )
    bound = light_plane_bound(world, STOPS, noise.stripe_px)
    return PlaneTrial(stripes.light_plane - np.ravel(plane), np.diag(bound), np.diag(covariance))


def closed_form_table(name: str, trials: Sequence[PlaneTrial]) -> tuple[Table, list[Measure]]:
    """RMSE, bound, their ratio and coverage of one number of surfaces."""
    errors, bounds, stated, covered = (
        np.array([getattr(t, what) for t in trials]) for what in ("error", "bound", "stated", "covered")
    )
    rows: list[list[Cell]] = []
    measures = []
    for what, (at, unit) in QUANTITIES.items():
        rmse, bound, said = (
            float(np.sqrt(np.mean(np.sum(squares[:, at], axis=1)))) for squares in (errors**2, bounds, stated)
        )
        share = 100 * float(np.mean(covered[:, at]))
        rows.append([what, unit * rmse, unit * bound, rmse / bound, said / bound, share])
        title = f"calibrateLightPlane, {name}: {what.partition(' [')[0]}"
        measures += [
            Measure(f"{title}, RMSE / bound", rmse / bound, LIMIT),
            Measure(f"{title}, coverage off {STATED:g} % by [%]", abs(share - STATED), SLACK),
        ]
    columns = ("quantity", "RMSE", "bound", "RMSE / bound", "stated σ / bound", "inside 95 % [%]")
    return Table(f"calibrateLightPlane, {name}", columns, rows), measures


def joint_table(found: Outcomes) -> tuple[Table, list[Measure]]:
    """The same for the light plane of refineHandEye, noise levels estimated."""
    rows: list[list[Cell]] = []
    measures = []
    for (what, (_, unit)), at in zip(QUANTITIES.items(), (NORMAL, OFFSET), strict=True):
        share = float(np.mean([found.coverage(i) for i in at]))
        ratio = found.ratio(at)
        rows.append([what, unit * found.rmse(at), unit * found.bound(at), ratio, found.stated(at), share])
        title = f"{JOINT.name}: {what.partition(' [')[0]}"
        measures += [
            Measure(f"{title}, RMSE / bound", ratio, LIMIT),
            Measure(f"{title}, coverage off {STATED:g} % by [%]", abs(share - STATED), SLACK),
        ]
    columns = ("quantity", "RMSE", "bound", "RMSE / bound", "stated σ / bound", "inside 95 % [%]")
    note = f"Refused: {len(found.problems)}."
    return Table(f"{JOINT.name}, 60 points, 0.1 px, robot 0.02 mm / 0.005 deg", columns, rows, note), measures


def cell_table(runs: Sequence[CellRun]) -> tuple[Table, list[Measure]]:
    """One line a seed; medians, and shares of labelled segments over all."""
    rows: list[list[Cell]] = [r.row() for r in runs]
    medians = [float(np.median([getattr(r, name) for r in runs])) for name in ("normal_deg", "offset_mm")]
    able, labelled, wrong = (sum(getattr(r, name) for r in runs) for name in ("able", "labelled", "wrong"))
    rows.append(["all", *medians, able, labelled, wrong])
    columns = ("seed", "normal [deg]", "offset [mm]", "segments", "labelled", "wrong")
    note = (
        "Errors: last line medians. segments: those whose surface two views or more show; labelled: of these, with a "
        "surface; wrong: on another plane than most of their surface."
    )
    measures = [
        Measure(f"rendered cell, two groups of five: {what}, median", value, CELL_LIMITS[what])
        for what, value in zip(QUANTITIES, medians, strict=True)
    ]
    measures += [
        Measure(
            "rendered cell: stripe segments with their surface [%]", 100 * labelled / able, LABELLED, at_least=True
        ),
        Measure("rendered cell: stripe segments with a wrong surface [%]", 100 * wrong / able, WRONG),
    ]
    return Table("Rendered cell, two groups of five stops, joint refinement", columns, rows, note), measures


def measure(workers: cluster.Workers, trials: int = 1000, seed: int = 1, cells: int = 10) -> Report:
    """All of it; refineHandEye with half the trials."""
    tables, measures = [], []
    for name, surfaces in CASES.items():
        found = closed_form_table(name, workers.run(partial(trial, surfaces, seed), trials, name))
        tables.append(found[0])
        measures += found[1]
    pairs = workers.run(partial(refine_trial, JOINT, seed), trials // 2, JOINT.name)
    joint = joint_table(Outcomes([estimated for _, estimated in pairs]))
    rendered = cell_table(workers.run(run, cells, "rendered cells")) if cells else None
    for table, kept in (joint, rendered) if rendered else (joint,):
        tables.append(table)
        measures += kept
    setup = (
        f"{trials} trials ({trials // 2} of refineHandEye), seed {seed}; each another camera, mounting, motion and "
        f"scene. Two groups of five views 60 mm apart, {POINTS} stripe points of 0.1 px independent noise a segment. "
        "The bound of calibrateLightPlane has surfaces of their own in every group, since it does not know "
        "t_cam2gripper; that of refineHandEye, which has two more stops, is the bound of everything at once. "
        f"Then {cells} simulated cells."
    )
    return Report("Light plane", setup, tables, measures)


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""

    def start(workers: cluster.Workers, options: argparse.Namespace) -> Report:
        return measure(workers, options.trials, options.seed)

    return cluster.main(__doc__, start, 1000, "trials per case", arguments)


if __name__ == "__main__":
    sys.exit(main())
