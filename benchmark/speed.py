# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Time of the closed forms against cv2.calibrateHandEye, and how it grows with points and views.

calibrateHandEyeTranslations and calibrateHandEyeRotation on 24 views x 200 image points, against the faster of Tsai and
Park on 24 poses of a board, which leaves out the time OpenCV's way takes for calibrateCamera. One thread, processor
time; the calls take turns and the fastest of many counts, so that other programs on the machine disturb little. Growth:
slope of log time over log size from one size to its double; 1 = linear.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from functools import partial

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

import cv_active_handeye as cah

from .report import Cell, Measure, Report, Table, finish, parser
from .scene import Array, Scene, random_scene

VIEWS, POINTS, SIGMA = 24, 200, 0.1
MAX_RATIO, MAX_SLOPE = 1.0, 1.15
POINT_COUNTS, GROUP_COUNTS = (100, 200, 400, 800, 1600), (3, 6, 12, 24)
Call = Callable[[], object]


def fastest(calls: Sequence[Call], rounds: int, in_a_row: int = 5) -> list[float]:
    """Processor seconds of the fastest run of every call. In each round every call has its turn, `in_a_row` times."""
    best = [float("inf")] * len(calls)
    for _ in range(rounds):
        for i, call in enumerate(calls):
            for _ in range(in_a_row):
                start = time.process_time()
                call()
                best[i] = min(best[i], time.process_time() - start)
    return best


def closed_forms(scene: Scene, seed: int) -> tuple[Call, Call]:
    """The two calls on one recording of the scene; the second one takes what the first one finds."""
    seen = scene.observe(np.random.default_rng([seed, 1]), SIGMA)
    motion = scene.R_gripper2base, scene.t_gripper2base
    _, K, R, _ = cah.calibrateHandEyeTranslations(*motion, seen, None, None)
    return (
        lambda: cah.calibrateHandEyeTranslations(*motion, seen, None, None),
        lambda: cah.calibrateHandEyeRotation(*motion, seen, K, None, R),
    )


def board_poses(views: int, seed: int) -> tuple[list[Array], list[Array], list[Array], list[Array]]:
    """Poses as in OpenCV's own test of calibrateHandEye: turns of 5 to 45 degrees about random axes."""
    rng = np.random.default_rng([seed, 2])
    X, target = np.eye(4), np.eye(4)
    X[:3, :3], X[:3, 3] = Rotation.random(random_state=rng).as_matrix(), rng.uniform(-0.5, 0.5, 3)
    target[:3, :3], target[:3, 3] = Rotation.random(random_state=rng).as_matrix(), rng.uniform(-3.5, 3.5, 3)
    gripper, board = [], []
    for _ in range(views):
        axis = rng.uniform(-1, 1, 3)
        T = np.eye(4)
        T[:3, :3] = Rotation.from_rotvec(axis / np.linalg.norm(axis) * np.radians(rng.uniform(5, 45))).as_matrix()
        T[:3, 3] = rng.uniform(-1.5, 1.5, 3)
        gripper.append(T)
        board.append(np.linalg.inv(T @ X) @ target)
    R_gripper2base, t_gripper2base = [T[:3, :3] for T in gripper], [T[:3, 3:] for T in gripper]
    return R_gripper2base, t_gripper2base, [T[:3, :3] for T in board], [T[:3, 3:] for T in board]


def against_opencv(seed: int, rounds: int) -> tuple[Table, Measure]:
    """The chain on 24 views x 200 points, Tsai and Park on 24 poses."""
    scene = random_scene(np.random.default_rng([seed, 0]), POINTS, (4,) * (VIEWS // 4))
    poses = board_poses(VIEWS, seed)
    methods = (cv2.CALIB_HAND_EYE_TSAI, cv2.CALIB_HAND_EYE_PARK)
    theirs: list[Call] = [partial(cv2.calibrateHandEye, *poses, method=method) for method in methods]
    translations, rotation, tsai, park = fastest([*closed_forms(scene, seed), *theirs], rounds)
    chain, opencv = translations + rotation, min(tsai, park)
    rows: list[list[Cell]] = [
        ["calibrateHandEyeTranslations", 1e3 * translations, translations / opencv],
        ["calibrateHandEyeRotation", 1e3 * rotation, rotation / opencv],
        ["both: K, R_cam2gripper, t_cam2gripper", 1e3 * chain, chain / opencv],
        [f"cv2.calibrateHandEye, Tsai ({cv2.__version__})", 1e3 * tsai, tsai / opencv],
        ["cv2.calibrateHandEye, Park", 1e3 * park, park / opencv],
    ]
    table = Table(
        f"{VIEWS} views x {POINTS} points, {VIEWS} board poses", ("call", "time [ms]", "/ fastest of OpenCV"), rows
    )
    return table, Measure("closed forms / fastest of Tsai and Park", chain / opencv, MAX_RATIO)


def growth(what: str, sizes: Sequence[int], scenes: Sequence[Scene], seed: int, rounds: int) -> tuple[Table, Measure]:
    """Time of the chain for every scene, and the slope between the ends of the range."""
    calls = [call for scene in scenes for call in closed_forms(scene, seed)]
    parts = fastest(calls, rounds)
    times = [a + b for a, b in zip(parts[::2], parts[1::2], strict=True)]
    rows: list[list[Cell]] = []
    for i, (size, seconds, scene) in enumerate(zip(sizes, times, scenes, strict=True)):
        slope = float(np.log2(seconds / times[i - 1])) if i else None
        rows.append([size, 1e3 * seconds, 1e9 * seconds / scene.visible.sum(), slope])
    slope = float(np.log2(times[-1] / times[0]) / np.log2(sizes[-1] / sizes[0]))
    columns = (what, "both calls [ms]", "per image point [ns]", "slope")
    return Table(f"Growth with {what}", columns, rows), Measure(f"growth with {what}: slope", slope, MAX_SLOPE)


def measure(seed: int = 1, rounds: int = 100) -> Report:
    """The ratio to OpenCV, and both growths."""
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    results = [against_opencv(seed, rounds)]
    cv2.setNumThreads(threads)
    few = max(rounds // 10, 3)
    by_points = [random_scene(np.random.default_rng([seed, n]), n, (4,) * 6) for n in POINT_COUNTS]
    results.append(growth("points, 24 views", POINT_COUNTS, by_points, seed, few))
    by_views = [random_scene(np.random.default_rng([seed, n]), POINTS, (4,) * n) for n in GROUP_COUNTS]
    results.append(growth("views, 200 points", [4 * n for n in GROUP_COUNTS], by_views, seed, few))
    setup = (
        f"One thread, processor time, fastest of {rounds} rounds of five calls (growth: {few} rounds), seed {seed}; "
        f"image points with {SIGMA} px noise."
    )
    return Report("Speed of the closed forms", setup, [table for table, _ in results], [limit for _, limit in results])


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    line = parser(__doc__ or "")
    line.add_argument("--seed", type=int, default=1, help="seed of scene, motion and noise")
    line.add_argument(
        "--rounds", type=int, default=100, help="rounds of five calls, of which the fastest counts (default 100)"
    )
    options = line.parse_args(arguments)
    return finish(measure(options.seed, options.rounds), options.output)


if __name__ == "__main__":
    sys.exit(main())
