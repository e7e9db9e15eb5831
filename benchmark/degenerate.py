# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""No silent wrong answers: refineHandEye on degenerate and nearly degenerate recordings.

Each ends in an error (refused), or in intervals that contain the truth as often as they say; a parameter that was not
observed has an infinite interval, which does not count. Half of the sets come with a rough start, so that the closed
forms do not refuse first; a third asks for the partial answer; a third leaves the choice of the lens model to the
function.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

import cv_active_handeye as cah

from . import cluster
from .degenerate_sets import KINDS, Kind, degenerate_set
from .refine_trials import Estimate, calibrate, covered, settings
from .report import Cell, Measure, Report, Table
from .rough import NO_START, rough_start
from .scene import Array
from .world import DISTORTION, NAMES, World

STATED, LEAST, GROSS = 95.0, 93.0, 3.0
LEAST_OF_A_KIND, ENOUGH = 90.0, 400


@dataclass(frozen=True)
class Answer:
    """How one set ended: refused, or the finite intervals' hits and the errors in half widths of the interval."""

    refused: bool
    usable: bool = False
    partial: bool = False
    hits: tuple[bool, ...] = ()
    misses: tuple[float, ...] = ()
    unobserved: int = 0
    text: str = ""


def judge(world: World, found: Estimate) -> Answer:
    """Hits of the finite intervals of what was estimated.

    The coefficients of a lens model smaller than the true one are other quantities than those, and do not count.
    """
    summary = found.summary
    deviations = np.ravel(summary.standardDeviations)
    interval: Array = np.asarray(summary.intervals95)
    asked = ~(deviations == 0)
    if world.dist_coeffs.any() and summary.lensModel < cah.LENS_K1_K2:
        asked[DISTORTION] = False
    finite = asked & np.isfinite(deviations)
    half = 0.5 * (interval[:, 1] - interval[:, 0])
    hits = covered(found.error, found)[finite] > 0
    with np.errstate(invalid="ignore", divide="ignore"):
        off = np.abs(found.error[finite]) / half[finite]
    broken = ~np.isfinite(found.error[finite]) | ~np.isfinite(half[finite])
    off[broken] = np.inf
    worst = f"{NAMES[np.flatnonzero(finite)[np.argmax(off)]]}" if finite.any() else ""
    return Answer(False, summary.usable, False, tuple(hits & ~broken), tuple(off), int((asked & ~finite).sum()), worst)


def trial(kind: Kind, seed: int, number: int) -> Answer:
    """One set."""
    rng = np.random.default_rng([seed, number])
    world, noise = degenerate_set(rng, kind)
    recording = world.record(rng, noise)
    start = rough_start(rng, world) if rng.random() < 0.5 else NO_START
    partial_answer, choose = rng.random(2) < 1 / 3
    lens = cah.LENS_AUTO if choose else cah.LENS_K1_K2 if world.dist_coeffs.any() else cah.LENS_FIXED
    try:
        params = settings(lens, flags=cah.REFINE_ALLOW_PARTIAL if partial_answer else 0)
        return judge(world, calibrate(world, recording, params, start))
    except cah.error as error:
        return Answer(True, text=str(error))


def row(name: str, answers: Sequence[Answer]) -> list[Cell]:
    """One line of the table."""
    answered = [answer for answer in answers if not answer.refused]
    good = [answer for answer in answered if answer.usable]
    hits = [hit for answer in good for hit in answer.hits]
    warned = [hit for answer in answered if not answer.usable for hit in answer.hits]
    return [
        name,
        len(answers),
        len(answers) - len(answered),
        len(answered) - len(good),
        len(good),
        sum(answer.unobserved > 0 for answer in good),
        _percent(hits),
        gross(good),
        _percent(warned),
    ]


def gross(answers: Sequence[Answer]) -> int:
    """Answers with a parameter more than `GROSS` half widths of its interval away from the truth."""
    return sum(any(off > GROSS for off in answer.misses) for answer in answers)


def _percent(hits: Sequence[bool]) -> float | None:
    return 100 * float(np.mean(hits)) if hits else None


COLUMNS = (
    *("kind", "sets", "refused", "answered, not usable", "answered", "of these with unobserved parameters"),
    *("coverage [%]", f"off by > {GROSS:g} half intervals", "coverage where not usable [%]"),
)


def measure(workers: cluster.Workers, trials: int = 2200, seed: int = 1) -> Report:
    """Every kind, as many sets of each."""
    found = {}
    for index, kind in enumerate(KINDS):
        name = kind.__name__.replace("_", " ")
        found[name] = workers.run(partial(trial, kind, seed + 1000 * index), -(-trials // len(KINDS)), name)
    everything = [answer for answers in found.values() for answer in answers]
    rows = [row(name, answers) for name, answers in found.items()]
    rows.append(row("all", everything))
    answered = [answer for answer in everything if not answer.refused]
    good = [answer for answer in answered if answer.usable]
    measures = [
        Measure("sets", len(everything), 2000, at_least=True),
        Measure(
            "coverage of all intervals answered [%]", _percent([h for a in good for h in a.hits]) or 0.0, LEAST, True
        ),
        Measure(f"usable answers off by more than {GROSS:g} half intervals", gross(good), 0),
        Measure(
            f"other answers off by more than {GROSS:g} half intervals", gross([a for a in answered if not a.usable]), 0
        ),
    ]
    for name, answers in found.items():
        hits = [hit for answer in answers if answer.usable for hit in answer.hits]
        if len(hits) >= ENOUGH:
            measures.append(Measure(f"{name}: coverage [%]", _percent(hits) or 0.0, LEAST_OF_A_KIND, at_least=True))
    setup = (
        f"{len(everything)} sets, seed {seed}, severity from exactly degenerate to nearly well, 0.02 to 1 px, robot "
        "exact to 0.2 mm / 0.06 deg. Half of them with a rough start (f 3 %, 2 deg, 20 mm off), a third asks for the "
        "partial answer, a third lets the lens model be chosen. Coverage: share of the finite 95 % intervals that "
        "contain the truth; all parameters of all answers together."
    )
    return Report("Degenerate recordings", setup, [Table("How they end", COLUMNS, rows)], measures)


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    return cluster.main(__doc__, lambda workers, o: measure(workers, o.trials, o.seed), 2200, "sets in all", arguments)


if __name__ == "__main__":
    sys.exit(main())
