# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""reprojectStripe: points a second on one thread, through Python, beside a plain copy of the same pixels.

Processor time of the fastest of many calls; without covariances, since a scanner asks for them once in a while only.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

import numpy as np

import cv_active_handeye as cah

from .report import Cell, Measure, Report, Table, finish, parser
from .scene import Array
from .speed import fastest

K = np.array([[1413.0, 0, 318], [0, 1414.0, 243], [0, 0, 1]])
LENS = np.array([-0.1, 0.05, 1e-3, -1e-3, 0.0])
PLANE = np.append(np.array([0.02, 0.93, 0.367]) / np.linalg.norm([0.02, 0.93, 0.367]), 0.2)
MIN_RATE = 10.0


def rate(pixels: Array, lens: Array | None, rounds: int) -> float:
    """Million points a second, into the base frame."""
    R, t = np.eye(3), np.zeros(3)

    def call() -> None:
        cah.reprojectStripe(
            pixels, K, lens, PLANE, R_cam2gripper=R, t_cam2gripper=t, R_gripper2base=R, t_gripper2base=t
        )

    (seconds,) = fastest([call], rounds)
    return 1e-6 * len(pixels) / seconds


def measure(seed: int = 1, points: int = 100_000, rounds: int = 100) -> Report:
    """With and without lens distortion; and with covariances, for information."""
    pixels = np.random.default_rng(seed).uniform([0, 0], [640, 480], (points, 2))
    copied = np.empty_like(pixels)
    (copy,) = fastest([lambda: np.copyto(copied, pixels)], rounds)
    (full,) = fastest([lambda: cah.reprojectStripe(pixels[: points // 10], K, LENS, PLANE, pixelSigmas=0.1)], 3)
    plain, distorted = rate(pixels, None, rounds), rate(pixels, LENS, rounds)
    rows: list[list[Cell]] = [
        ["reprojectStripe, no lens distortion", plain],
        ["reprojectStripe, k1, k2, p1, p2", distorted],
        ["the same with covariances", 1e-6 * (points // 10) / full],
        ["copy of the pixels", 1e-6 * points / copy],
    ]
    table = Table(f"{points} points", ("call", "million points a second"), rows)
    setup = f"Seed {seed}; one thread, processor time, fastest of {rounds} calls through Python."
    limits = [
        Measure("reprojectStripe: million points a second", plain, MIN_RATE, at_least=True),
        Measure("reprojectStripe, with lens distortion: million points a second", distorted, MIN_RATE, at_least=True),
    ]
    return Report("Points from stripe pixels", setup, [table], limits)


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    line = parser(__doc__ or "")
    line.add_argument("--seed", type=int, default=1, help="seed of the pixels")
    line.add_argument("--points", type=int, default=100_000, help="pixels of one call (default 100 000)")
    line.add_argument("--rounds", type=int, default=100, help="calls (default 100)")
    options = line.parse_args(arguments)
    return finish(measure(options.seed, options.points, options.rounds), options.output)


if __name__ == "__main__":
    sys.exit(main())
