# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Choice of the lens model by refineHandEye (LENS_AUTO): how often it is which, and what the choice costs.

Lenses without distortion, with k1, k1 k2 and tangential distortion; 12 and 24 stops, noise levels estimated. Error and
coverage after the choice stand beside those with the true model given.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

import cv_active_handeye as cah

from . import cluster
from .fisher import linear_solution
from .refine_trials import PINHOLE, Case, Outcome, Outcomes, judge, settings
from .report import Cell, Measure, Report, Table
from .scene import Array
from .stops import STOPS_12, STOPS_24
from .world import DISTORTED, NAMES, ROTATION, TRANSLATION

MODELS = {
    cah.LENS_FIXED: "none",
    cah.LENS_K1: "k1",
    cah.LENS_K1_K2: "k1 k2",
    cah.LENS_TANGENTIAL: "k1 k2 p1 p2",
    cah.LENS_K3: "k1 k2 p1 p2 k3",
}
COEFFICIENTS = {cah.LENS_FIXED: 0, cah.LENS_K1: 1, cah.LENS_K1_K2: 2, cah.LENS_TANGENTIAL: 4, cah.LENS_K3: 5}
TOO_SMALL, COST, LEAST = 5.0, 1.25, 92.0


@dataclass(frozen=True)
class Lens:
    """A lens, the smallest model that describes it, and the smallest that does so within the noise."""

    name: str
    coefficients: tuple[float, ...]
    model: int
    enough: int


LENSES = (
    Lens("no distortion", (0, 0, 0, 0, 0), cah.LENS_FIXED, cah.LENS_FIXED),
    Lens("k1 -0.005", (-0.005, 0, 0, 0, 0), cah.LENS_K1, cah.LENS_FIXED),
    Lens("k1 -0.12", (-0.12, 0, 0, 0, 0), cah.LENS_K1, cah.LENS_K1),
    Lens("k1 -0.12, k2 0.08", tuple(DISTORTED), cah.LENS_K1_K2, cah.LENS_K1),
    Lens("k1 k2, p1 0.002, p2 -0.003", (*DISTORTED[:2], 0.002, -0.003, 0), cah.LENS_TANGENTIAL, cah.LENS_TANGENTIAL),
)
STOPS = {"12 stops": STOPS_12, "24 stops": STOPS_24}


def trial(case: Case, lens: Lens, seed: int, number: int) -> tuple[Outcome, Outcome]:
    """The model chosen, and the true one given."""
    rng = np.random.default_rng([seed, number])
    world = replace(case.world(rng), dist_coeffs=np.array(lens.coefficients))
    recording = world.record(rng, case.noise)
    names = NAMES[5 : 5 + COEFFICIENTS[lens.model]]
    best = linear_solution(world, case.noise, (*PINHOLE, *names), recording)
    return (
        judge(world, recording, settings(cah.LENS_AUTO), best),
        judge(world, recording, settings(lens.model), best),
    )


def length(found: Outcomes, part: slice) -> float:
    """RMS length of the error over the bound, common scatter removed."""
    return found.loss(list(range(*part.indices(len(NAMES)))))


def row(name: str, chosen: Sequence[Outcome], auto: Outcomes, told: Outcomes) -> list[Cell]:
    """One line of the table."""
    shares: list[Cell] = [100 * float(np.mean([one.lens_model == model for one in chosen])) for model in MODELS]
    cells: list[Cell] = [name, *shares]
    for part in (slice(0, 2), slice(2, 4), ROTATION, TRANSLATION):
        cells += [length(told, part), length(auto, part)]
    return [*cells, coverage(told), coverage(auto)]


def coverage(found: Outcomes) -> float:
    """Percentage of all intervals of camera matrix and hand-eye transform that contain the truth."""
    used: Array = found.covered[:, [NAMES.index(name) for name in PINHOLE]]
    return 100 * float(np.mean(used))


def measure(workers: cluster.Workers, trials: int = 500, seed: int = 1) -> Report:
    """All lenses, both numbers of stops."""
    rows, measures = [], []
    for stops_name, stops in STOPS.items():
        for lens in LENSES:
            name = f"{stops_name}, {lens.name}"
            pairs = workers.run(partial(trial, Case(name, stops=stops), lens, seed), trials, name)
            chosen = [pair[0] for pair in pairs]
            auto, told = Outcomes(chosen), Outcomes([pair[1] for pair in pairs])
            rows.append(row(name, chosen, auto, told))
            too_small = 100 * float(np.mean([one.lens_model < lens.enough for one in chosen]))
            cost = max(length(auto, part) / length(told, part) for part in (slice(0, 2), ROTATION, TRANSLATION))
            measures.append(Measure(f"{name}: too small a model [%]", too_small, TOO_SMALL))
            measures.append(Measure(f"{name}: RMSE chosen / RMSE told, largest", cost, COST))
            measures.append(Measure(f"{name}: coverage [%]", coverage(auto), LEAST, at_least=True))
    parts = ("fx, fy", "cx, cy", "R", "t")
    columns = ["lens", *(f"chosen: {model} [%]" for model in MODELS.values())]
    columns += [f"{part} / bound, {how}" for part in parts for how in ("told", "chosen")]
    columns += [f"coverage, {how} [%]" for how in ("told", "chosen")]
    setup = (
        f"{trials} trials, seed {seed}; 60 points, 0.1 px, robot 0.02 mm / 0.005 deg, noise levels estimated. Bound: "
        "of the smallest model that describes the lens. told: that model was given; chosen: LENS_AUTO. k2 0.08 and "
        "k1 -0.005 are about as large as their standard deviations. Coverage: all 95 % intervals of camera matrix "
        "and hand-eye transform together."
    )
    return Report("Choice of the lens model", setup, [Table("Models and errors", columns, rows)], measures)


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    return cluster.main(
        __doc__, lambda workers, o: measure(workers, o.trials, o.seed),
        500, "trials per lens and number of stops", arguments,
    )


if __name__ == "__main__":
    sys.exit(main())
