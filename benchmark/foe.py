# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""estimateFOE against what one would call in OpenCV: findEssentialMat (USAC_MAGSAC) and recoverPose.

Pure translations, 100 matches, f = 1000 px, 0.5 px noise, 0 and 30 % wrong matches: sideways by 5 % of the depth,
forward by 10 %, and sideways before a plane. The error is the angle between the estimated and the true direction of
motion, 180 degrees where nothing comes back. Both sides get the same matches and are timed in the same run, one thread,
processor time; of two thresholds OpenCV has the one that suits it better.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

import cv_active_handeye as cah

from .report import Cell, Measure, Report, Table, finish, parser, progress
from .scene import Array

WIDTH, HEIGHT, FOCAL = 1280, 960, 1000.0
K = np.array([[FOCAL, 0, WIDTH / 2], [0, FOCAL, HEIGHT / 2], [0, 0, 1]])
MATCHES, SIGMA, DEPTH = 100, 0.5, 1.0
ACCURACY, SPEED = 0.5, 10.0


@dataclass(frozen=True)
class Case:
    """A motion (in depths, camera frame) before a scene with relief or before a tilted plane."""

    name: str
    motion: tuple[float, float, float]
    planar: bool = False

    def matches(self, rng: np.random.Generator, outliers: float) -> tuple[Array, Array]:
        """Two arrays (100, 2) of pixels; the share `outliers` of the second one is anywhere in the image."""
        pixels = rng.uniform((0, 0), (WIDTH, HEIGHT), (MATCHES, 2))
        rays = np.column_stack([pixels, np.ones(MATCHES)]) @ np.linalg.inv(K).T
        depth = (
            DEPTH / (1 + 0.3 * rays[:, 0] + 0.2 * rays[:, 1])
            if self.planar
            else DEPTH * rng.uniform(0.75, 1.25, MATCHES)
        )
        points = rays * depth[:, None]
        first, second = (self._image(points - camera) for camera in (np.zeros(3), DEPTH * np.array(self.motion)))
        first, second = (x + rng.normal(0, SIGMA, x.shape) for x in (first, second))
        wrong = int(outliers * MATCHES)
        second[:wrong] = rng.uniform((0, 0), (WIDTH, HEIGHT), (wrong, 2))
        return first, second

    @staticmethod
    def _image(points: Array) -> Array:
        homogeneous: Array = points @ K.T
        return np.asarray(homogeneous[:, :2] / homogeneous[:, 2:])


CASES = (
    Case("sideways", (0.05, 0, 0)),
    Case("forward", (0, 0, 0.10)),
    Case("sideways, planar", (0.05, 0, 0), planar=True),
)


def ours(first: Array, second: Array, threshold: float) -> Array:
    """Direction of motion of the camera by estimateFOE."""
    direction = np.linalg.solve(K, cah.estimateFOE(first, second, threshold=threshold)[1][:, 0])
    return np.asarray(direction)


def opencv(first: Array, second: Array, threshold: float) -> Array:
    """The same by findEssentialMat and recoverPose, whose t is the first camera's centre seen from the second."""
    E, mask = cv2.findEssentialMat(first, second, K, method=cv2.USAC_MAGSAC, prob=0.999, threshold=threshold)
    _, R, t, _ = cv2.recoverPose(E[:3], first, second, K, mask=mask)
    return np.asarray(-R.T @ t[:, 0], dtype=np.float64)


METHODS = ((ours, 3 * SIGMA), (ours, 1.0), (opencv, 1.0), (opencv, 3 * SIGMA))
"""Each with its inlier threshold in pixels; 1 px is the default of both."""


def angle_deg(a: Array, b: Array) -> float:
    """Angle between two vectors."""
    return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b)), np.dot(a, b))))


def timed(
    method: Callable[[Array, Array, float], Array], first: Array, second: Array, threshold: float
) -> tuple[Array, float]:
    """Direction (NaN where the call fails), and processor seconds of the faster of two calls."""
    seconds = []
    for _ in range(2):
        start = time.process_time()
        try:
            direction = method(first, second, threshold)
        except (cah.error, cv2.error, TypeError, IndexError):  # findEssentialMat may return None
            direction = np.full(3, np.nan)
        seconds.append(time.process_time() - start)
    return direction, min(seconds)


@dataclass(frozen=True)
class Comparison:
    """Errors [deg] (T,) and times [s] (T,) of the `METHODS`, one row each."""

    errors: Array
    times: Array

    def best_of_opencv(self) -> int:
        """Row of OpenCV's threshold with the smaller median error."""
        return 2 + int(np.argmin(np.median(self.errors[2:], axis=1)))


def compare(case: Case, outliers: float, trials: int, seed: int) -> Comparison:
    """All methods on the same `trials` sets of matches."""
    errors, times = [], []
    show = progress(trials, f"{case.name}, {outliers:.0%}")
    for trial in range(trials):
        first, second = case.matches(np.random.default_rng([seed, trial]), outliers)
        found = [timed(method, first, second, threshold) for method, threshold in METHODS]
        angles = [angle_deg(direction, np.array(case.motion)) for direction, _ in found]
        errors.append([180.0 if np.isnan(angle) else angle for angle in angles])
        times.append([seconds for _, seconds in found])
        show(trial + 1)
    return Comparison(np.array(errors).T, np.array(times).T)


def measure(trials: int = 500, seed: int = 1) -> Report:
    """Median and 90th percentile of the direction error, and times, of every case with and without wrong matches."""
    rows: list[list[Cell]] = []
    measures = []
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    for case in CASES:
        for outliers in (0.0, 0.3):
            found = compare(case, outliers, trials, seed)
            best = found.best_of_opencv()
            median, p90 = np.percentile(found.errors, [50, 90], axis=1).tolist()
            microseconds = (1e6 * np.median(found.times, axis=1)).tolist()
            ratio, speed = median[0] / median[best], microseconds[best] / microseconds[0]
            name = f"{case.name}, {outliers:.0%} wrong"
            row: list[Cell] = [name, median[0], p90[0], median[1], median[best], p90[best], ratio]
            rows.append([*row, microseconds[0], microseconds[best], speed])
            measures.append(Measure(f"{name}: median error / OpenCV's", ratio, ACCURACY))
            measures.append(Measure(f"{name}: times as fast", speed, SPEED, at_least=True))
    cv2.setNumThreads(threads)
    columns = ("case", "median [deg]", "p90", "median at 1 px", "OpenCV median", "p90", "ratio")
    times = ("time [µs]", "OpenCV [µs]", "times as fast")
    setup = (
        f"{trials} trials each, seed {seed}; {MATCHES} matches, f = {FOCAL:.0f} px, {SIGMA} px noise, one thread, "
        "median processor time of one run. estimateFOE with a threshold of 3 sigma (beside it: its default, 1 px). "
        f"OpenCV {cv2.__version__}: findEssentialMat (USAC_MAGSAC) and recoverPose, 1 px or 3 sigma, the better one."
    )
    title = "Direction of a pure translation: estimateFOE against OpenCV"
    return Report(title, setup, [Table("Direction error and time", (*columns, *times), rows)], measures)


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    line = parser(__doc__ or "")
    line.add_argument("--trials", type=int, default=500, help="sets of matches per case (default 500)")
    line.add_argument("--seed", type=int, default=1, help="trial i uses the random numbers of (seed, i)")
    options = line.parse_args(arguments)
    return finish(measure(options.trials, options.seed), options.output)


if __name__ == "__main__":
    sys.exit(main())
