# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Any mounting, any motion: the truth from exact data, from noisy data errors that the covariance predicts.

A set may be refused; it must not be answered wrongly. Exact: every number of the answer is right to a millionth. Noisy:
no number is more than `GROSS` of its predicted standard deviations off, and the errors have the predicted size.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

import cv_active_handeye as cah

from . import cluster
from .mounting_sets import Expansion, Found, Stripes, TargetPoses, Translations, Turns
from .report import Cell, Measure, Report, Table

METRIC, FOE = cah.TRANSLATIONS_METRIC, cah.TRANSLATIONS_FOE
FIX_K, SQUARE = cah.TRANSLATIONS_FIX_K, cah.TRANSLATIONS_SQUARE_PIXELS
SETS: dict[str, Callable[[np.random.Generator, float], Found]] = {
    "translations, K known: 2": Translations(METRIC, FIX_K, 2),
    "translations, K known: 6 of almost one plane": Translations(METRIC, FIX_K, 6, flatness=0.008),
    "translations: 4": Translations(METRIC, 0, 4),
    "translations, square pixels: 4": Translations(METRIC, SQUARE, 4),
    "FOEs, K known: 2": Translations(FOE, FIX_K, 2),
    "FOEs, K known: 3": Translations(FOE, FIX_K, 3),
    "FOEs: 6": Translations(FOE, 0, 6),
    "turns: 3": Turns(3),
    "turns: 6": Turns(6),
    "FOE: any motion": Expansion((1, 1, 1)),
    "FOE: sideways": Expansion((1, 1, 0)),
    "FOE: forward": Expansion((0.05, 0.05, 1)),
    "light plane: 3 views of 2 planes": Stripes(1, 3, 2),
    "light plane: 5 views of 3 planes": Stripes(1, 5, 3),
    "light plane: 2 groups, 3 views of 1 plane": Stripes(2, 3, 1),
    "target's poses: 5": TargetPoses(5, 1.0),
    "target's poses: 8, small turns": TargetPoses(8, 0.15),
}
NOISE, EXACT, GROSS = 0.1, 1e-6, 6.0
NOT_DETERMINED = -7
"""Error code of a refusal."""


@dataclass(frozen=True)
class Outcome:
    """One recording without noise and with `NOISE` px; None = refused."""

    exact: Found | None
    noisy: Found | None


def trial(name: str, seed: int, number: int) -> Outcome:
    """One set of a kind."""
    return Outcome(*(_found(name, np.random.default_rng([seed, number]), noise) for noise in (0.0, NOISE)))


def _found(name: str, rng: np.random.Generator, noise: float) -> Found | None:
    try:
        return SETS[name](rng, noise)
    except cah.error as error:
        if error.code != NOT_DETERMINED:
            raise
        return None


@dataclass(frozen=True)
class Verdict:
    """What all sets of a kind did."""

    name: str
    sets: int
    refused: int
    worst_exact: float
    exact_wrong: int
    off: Sequence[float]
    """Largest error of every noisy answer, in predicted standard deviations."""
    ratio: float
    """Root of the median of squared standardised errors over that of the normal distribution."""

    @property
    def gross(self) -> int:
        """Noisy answers that are off by more than GROSS."""
        return sum(off > GROSS for off in self.off)

    def row(self) -> list[Cell]:
        """One line of the table."""
        worst = max(self.off, default=float("nan"))
        return [self.name, self.sets, self.refused, self.worst_exact, self.ratio, worst, self.gross]


def judge(name: str, outcomes: Sequence[Outcome]) -> Verdict:
    """The verdict on one kind."""
    exact = [float(np.abs(o.exact.error).max()) for o in outcomes if o.exact]
    noisy = [o.noisy.standardised() for o in outcomes if o.noisy]
    off = [float(np.abs(z).max()) for z in noisy]
    median_of_normal = 0.6745
    ratio = float(np.median(np.abs(np.concatenate(noisy)))) / median_of_normal if noisy else float("nan")
    refused = sum(o.noisy is None for o in outcomes)
    return Verdict(name, len(outcomes), refused, max(exact, default=0.0), sum(e > EXACT for e in exact), off, ratio)


COLUMNS = (
    *("kind", "sets", "refused", "exact data: largest error", "errors / predicted"),
    *("largest error / its sigma", f"answers off by > {GROSS:g} sigma"),
)


def measure(workers: cluster.Workers, trials: int = 500, seed: int = 1) -> Report:
    """Every kind, `trials` sets of each."""
    verdicts = [judge(name, workers.run(partial(trial, name, seed), trials, name)) for name in SETS]
    answers = sum(len(verdict.off) for verdict in verdicts)
    measures = [
        Measure("exact data: answers off by more than 1e-6", sum(v.exact_wrong for v in verdicts), 0),
        Measure(
            f"noisy answers off by more than {GROSS:g} sigma [per mille]",
            1000 * sum(v.gross for v in verdicts) / answers,
            0.5,
        ),
        Measure("largest ratio of errors to what is predicted", max(v.ratio for v in verdicts), 1.15),
        Measure("answers", answers, 0.9 * trials * len(SETS), at_least=True),
    ]
    setup = (
        f"{trials} sets of every kind, seed {seed}: rotation of the camera on the flange, base frame, focal length, "
        f"scene and motion all at random, once exact and once with {NOISE} px (poses of a target: 0.1 mrad, 0.1 mm). "
        "Refused: the error says what is missing. Errors / predicted: median of the absolute standardised errors, "
        "over that of the normal distribution."
    )
    table = Table("What the closed forms make of it", COLUMNS, [verdict.row() for verdict in verdicts])
    return Report("Any mounting, any motion", setup, [table], measures)


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    return cluster.main(
        __doc__, lambda workers, o: measure(workers, o.trials, o.seed), 500, "sets of every kind", arguments
    )


if __name__ == "__main__":
    sys.exit(main())
