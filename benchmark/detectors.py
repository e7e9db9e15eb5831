# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""OpenCV's feature detectors against the exact correspondences of the simulated cell, before any refinement.

Behind doc/decisions/tracking-features.md: how many matches, how many of them right, how precise, how biased. Matches
are mutual nearest neighbours with a ratio of 0.8, of the first stop with stops of the same group, tilted, turned by 90
degrees, and both.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np

from cv_active_handeye.simulation import SimulatedCell, SimulatedView
from cv_active_handeye.simulation.config import CellConfig

from .report import Cell, Report, Table, finish, parser
from .scene import Array

RATIO, RIGHT_PX, FEATURES = 0.8, 3.0, 2000
VIEWS = {"same orientation": 1, "tilted": 5, "turned by 90°": 10, "turned and tilted": 12}
Found = tuple[Array, Any, float]


def detectors() -> dict[str, tuple[Any, int]]:
    """Detectors with the norm of their descriptors."""
    sift = cv2.SIFT.create
    return {
        "SIFT, precise upscale": (sift(FEATURES, contrastThreshold=0.04, enable_precise_upscale=True), cv2.NORM_L2),
        "SIFT, as it comes": (sift(FEATURES), cv2.NORM_L2),
        "SIFT, precise, contrast 0.02": (sift(0, contrastThreshold=0.02, enable_precise_upscale=True), cv2.NORM_L2),
        "AKAZE": (cv2.AKAZE.create(), cv2.NORM_HAMMING),
        "KAZE": (cv2.KAZE.create(), cv2.NORM_L2),
        "ORB": (cv2.ORB.create(FEATURES), cv2.NORM_HAMMING),
        "BRISK": (cv2.BRISK.create(), cv2.NORM_HAMMING),
    }


def detect(detector: Any, view: SimulatedView) -> Found:
    """Positions (n, 2), descriptors, processor seconds."""
    start = time.process_time()
    keypoints, descriptors = detector.detectAndCompute(view.image, None)
    seconds = time.process_time() - start
    return np.array([keypoint.pt for keypoint in keypoints], np.float64), descriptors, seconds


def match(a: Found, b: Found, norm: int) -> tuple[Array, Array]:
    """Positions (m, 2) of the matches in both views."""
    matcher = cv2.BFMatcher(norm)
    best = [pair[0] for pair in matcher.knnMatch(a[1], b[1], 2) if pair[0].distance < RATIO * pair[1].distance]
    back = {m.queryIdx: m.trainIdx for m in matcher.match(b[1], a[1])}
    pairs = np.array([(m.queryIdx, m.trainIdx) for m in best if back.get(m.trainIdx) == m.queryIdx])
    return a[0][pairs[:, 0]], b[0][pairs[:, 1]]


def row(name: str, where: str, cell: SimulatedCell, views: Sequence[SimulatedView], first: Found, other: Found,
        norm: int) -> list[Cell]:  # fmt: skip
    """One line of the table: the first view matched with another."""
    here, there = match(first, other, norm)
    error = there - cell.correspond(views[0], views[1], here)
    right = np.linalg.norm(error, axis=1) < RIGHT_PX
    bias = np.median(error[right], axis=0)
    sigma = 1.4826 * np.median(np.abs(error[right] - bias), axis=0)
    counts: list[Cell] = [len(here), 100 * float(np.mean(right))]
    return [name, where, len(first[0]), *counts, *sigma.tolist(), *bias.tolist(), 1000 * (first[2] + other[2]) / 2]


def measure(seed: int = 0) -> Report:
    """All detectors on the same five views."""
    cell = SimulatedCell(CellConfig(seed=seed))
    poses = cell.plan()
    views = {index: cell.capture(poses[index], index) for index in (0, *VIEWS.values())}
    rows = []
    for name, (detector, norm) in detectors().items():
        found = {index: detect(detector, view) for index, view in views.items()}
        for where, index in VIEWS.items():
            rows.append(row(name, where, cell, (views[0], views[index]), found[0], found[index], norm))
    columns = ("detector", "other view", "features", "matches", "right [%]", "sigma x [px]", "sigma y", "bias x [px]",
               "bias y", "time [ms]")  # fmt: skip
    setup = (
        f"Simulated cell, seed {seed}, stop 0 matched with stops {', '.join(map(str, VIEWS.values()))}. Right: within "
        f"{RIGHT_PX:g} px of the truth. Time: processor time for one image of 640 x 480. OpenCV {cv2.__version__}."
    )
    return Report("Feature detectors before refinement", setup, [Table("Matches", columns, rows)])


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    line = parser(__doc__ or "")
    line.add_argument("--seed", type=int, default=0, help="seed of the simulated cell")
    options = line.parse_args(arguments)
    return finish(measure(options.seed), options.output)


if __name__ == "__main__":
    sys.exit(main())
