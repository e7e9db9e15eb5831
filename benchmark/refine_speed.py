# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Time of refineHandEye against Ceres and scipy on the same problem, and how time and memory grow.

24 views x 200 points with pose corrections, noise levels and lens model given, all from one perturbed start. Ceres
(benchmark/ceres, built here; Debian: libceres-dev) with automatic derivatives and the best of its Schur solvers: the
time of Solve() alone, against that of the whole call of refineHandEye, which also triangulates, and computes
covariances and tests. scipy.optimize.least_squares with sparsity and finite differences. One thread, processor time,
the fastest of many runs. Growth: slope of log time over log size.
"""

from __future__ import annotations

import multiprocessing
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

import cv_active_handeye as cah

from .refine_problem import Problem, Solution, build_ceres, make_problem, solve_ceres, solve_scipy
from .report import Cell, Measure, Report, Table, finish, parser
from .scene import CENTRE, FAR, NEAR, Array
from .stops import TURNS_DEG, active_stops
from .world import DISTORTED, Noise, Recording, World, in_image, random_world

VIEWS, POINTS, NOISE = 24, 200, Noise()
SOLVERS = ("DENSE_SCHUR", "SPARSE_SCHUR", "ITERATIVE_SCHUR")
TOLERANCES = (1e-6, 1e-8, 1e-10, 1e-12, 1e-14, 1e-16)
POINT_COUNTS, VIEW_COUNTS, LARGEST = (200, 630, 2000, 6300, 20000), (12, 24, 50, 100, 200), (200, 20000)
OURS, SCIPY, TURNS = "refineHandEye, the whole call", "scipy least_squares, LSMR to 1e-12", 5
Solve = Callable[[], Solution]
SAME, MAX_RATIO, MIN_GAIN = 1e-6, 1.0, 20.0
LINEAR, CUBIC, PATIENCE = 1.1, 3.0, 600.0


def large_world(rng: np.random.Generator, views: int, points: int) -> World:
    """As random_world, with any number of orientations of five stops each, and points drawn in small portions."""
    groups = -(-views // 5)
    motion = active_stops(rng, (5,) * groups, turns_deg=TURNS_DEG[np.arange(groups) % len(TURNS_DEG)])
    world = random_world(rng, (motion[0][:views], motion[1][:views]), 1, DISTORTED)
    chosen, seen = [world.points], [world.visible]
    while sum(map(len, chosen)) < points:
        drawn = CENTRE + rng.uniform(-1, 1, (2000, 3)) * [0.2, 0.2, 0.5 * (FAR - NEAR)]
        visible = in_image(world, drawn)
        kept = visible.sum(axis=0) >= 3
        chosen.append(drawn[kept])
        seen.append(visible[:, kept])
    return replace(world, points=np.concatenate(chosen)[:points], visible=np.concatenate(seen, axis=1)[:, :points])


def recording(views: int, points: int, seed: int) -> tuple[World, Recording, Array]:
    """A world, its recording, and a start that is a little wrong: fx, fy, cx, cy, k1, k2, rotation, translation."""
    world = large_world(np.random.default_rng([seed, views, points]), views, points)
    K, turn = world.camera_matrix, Rotation.from_rotvec([0.006, -0.005, 0.004])
    camera = [1.01 * K[0, 0], 1.01 * K[1, 1], K[0, 2] + 5, K[1, 2] - 5, 0, 0]
    hand = (turn * Rotation.from_matrix(world.R_cam2gripper)).as_rotvec()
    shared = np.concatenate([camera, hand, np.array([0.003, -0.003, 0.003]) + world.t_cam2gripper])
    return world, world.record(np.random.default_rng([seed, 1]), NOISE), shared


def solve_ours(seen: Recording, shared: Array, rounds: int) -> Solution:
    """Solution of refineHandEye; the fastest of `rounds` calls counts."""
    params = cah.RefineParams()
    params.lensModel = cah.LENS_K1_K2
    params.pointSigma, params.stripeSigma = NOISE.point_px, NOISE.stripe_px
    params.robotTranslationSigma, params.robotRotationSigma = NOISE.translation, NOISE.rotation
    params.huberThreshold = params.rejectThreshold = 1e6
    fx, fy, cx, cy, k1, k2 = shared[:6]
    K, D = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]]), np.array([k1, k2, 0, 0, 0])
    hand = Rotation.from_rotvec(shared[6:9]).as_matrix(), shared[9:12]
    inputs = seen.R_gripper2base, seen.t_gripper2base, seen.image_points, K, D, *hand, None
    fastest = float("inf")
    for _ in range(rounds):
        start = time.process_time()
        _, K, D, R, t, _, summary = cah.refineHandEye(*inputs, params=params)
        fastest = min(fastest, time.process_time() - start)
    found = [K[0, 0], K[1, 1], K[0, 2], K[1, 2], *D[:2, 0], *Rotation.from_matrix(R).as_rotvec(), *t[:, 0]]
    unknowns = np.concatenate([found, summary.poseCorrections.ravel(), summary.scenePoints.ravel()])
    return Solution(unknowns, float("nan"), summary.iterations, fastest)


def difference(problem: Problem, a: Array, b: Array) -> float:
    """Largest relative difference: camera matrix by fx, lens by 1, angles by 1 rad, positions by the distance."""
    found, expected = problem.split(a), problem.split(b)
    turn = Rotation.from_rotvec(found[0][6:9]) * Rotation.from_rotvec(expected[0][6:9]).inv()
    far = 0.5 * (NEAR + FAR)
    scaled = [
        (found[0][:4] - expected[0][:4]) / expected[0][0],
        found[0][4:6] - expected[0][4:6],
        turn.as_rotvec(),
        (found[0][9:12] - expected[0][9:12]) / far,
        (found[1] - expected[1]) / ([1] * 3 + [far] * 3),
        (found[2] - expected[2]) / far,
    ]
    return max(float(np.abs(part).max()) for part in scaled)


def ceres_solvers(problem: Problem, program: Path, file: Path, rounds: int) -> dict[str, Solve]:
    """Each Schur solver with the loosest tolerance that reaches the optimum to a tenth of SAME."""
    optimum = solve_ceres(program, file, "DENSE_SCHUR", 1e-16, 1).unknowns
    solvers: dict[str, Solve] = {}
    for name in SOLVERS:
        for tolerance in TOLERANCES:
            solution = solve_ceres(program, file, name, tolerance, 1)
            if difference(problem, solution.unknowns, optimum) <= 0.1 * SAME:
                solvers[f"Ceres, {name}, Solve() alone"] = partial(solve_ceres, program, file, name, tolerance, rounds)
                break
    return solvers


def in_turns(solvers: dict[str, Solve]) -> dict[str, Solution]:
    """The fastest solution of each; they take turns, so that other programs on the machine disturb all alike."""
    fastest: dict[str, Solution] = {}
    for _ in range(TURNS):
        for name, solve in solvers.items():
            solution = solve()
            if name not in fastest or solution.seconds < fastest[name].seconds:
                fastest[name] = solution
    return fastest


def against_others(seed: int, rounds: int) -> tuple[Table, list[Measure]]:
    """The same problem solved by everyone."""
    world, seen, shared = recording(VIEWS, POINTS, seed)
    problem = make_problem(world, seen, NOISE, shared)
    few = max(1, rounds // TURNS)
    with tempfile.TemporaryDirectory() as folder:
        program, file = build_ceres(Path(folder, "build")), Path(folder, "problem.txt")
        problem.save(file)
        ceres = ceres_solvers(problem, program, file, few)
        solvers: dict[str, Solve] = {
            OURS: partial(solve_ours, seen, shared, few),
            **ceres,
            SCIPY: partial(solve_scipy, problem, True),
            "scipy least_squares, defaults": partial(solve_scipy, problem, False),
        }
        fastest = in_turns(solvers)
    ours, scipy, best = fastest[OURS], fastest[SCIPY], min((fastest[name] for name in ceres), key=lambda s: s.seconds)
    apart = {name: difference(problem, solution.unknowns, best.unknowns) for name, solution in fastest.items()}
    rows: list[list[Cell]] = [
        [name, 1e3 * solution.seconds, solution.iterations, solution.seconds / ours.seconds, apart[name]]
        for name, solution in fastest.items()
    ]
    title = f"{VIEWS} views x {POINTS} points, {len(problem.view)} image points"
    columns = ("solver", "time [ms]", "iterations", "/ ours", "relative difference from Ceres")
    return Table(title, columns, rows), [
        Measure("refineHandEye / the fastest of Ceres", ours.seconds / best.seconds, MAX_RATIO),
        Measure("scipy.optimize.least_squares / refineHandEye", scipy.seconds / ours.seconds, MIN_GAIN, True),
        Measure("same optimum: largest relative difference", max(apart[name] for name in (OURS, SCIPY, *ceres)), SAME),
    ]


def alone(size: tuple[int, int, int, int]) -> list[Cell]:
    """views, points, image points, milliseconds, iterations, MB of one call in a process of its own (spawned)."""
    views, points, seed, rounds = size
    world, seen, shared = recording(views, points, seed)
    before = memory("VmRSS", reset=True)
    solution = solve_ours(seen, shared, rounds)
    used = memory("VmHWM") - before
    return [views, points, int(world.visible.sum()), 1e3 * solution.seconds, solution.iterations, used]


def memory(entry: str, reset: bool = False) -> float:
    """MB of this process now (VmRSS) or at its peak (VmHWM) since the last reset; Linux only."""
    if reset:
        Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith(entry)) / 1024


def growth(seed: int, rounds: int) -> tuple[Table, list[Measure]]:
    """Time and memory over points and over views, and the largest problem."""
    sizes = [(VIEWS, n) for n in POINT_COUNTS] + [(v, POINTS) for v in VIEW_COUNTS] + [LARGEST]
    jobs = [(views, points, seed, max(1, rounds * VIEWS * POINTS // (views * points))) for views, points in sizes]
    with multiprocessing.get_context("spawn").Pool(1, maxtasksperchild=1) as pool:
        rows = list(pool.imap(alone, jobs, chunksize=1))

    def slope(first: int, last: int, over: int, what: int) -> float:
        (x0, y0), (x1, y1) = (np.array([row[over], row[what]], dtype=np.float64) for row in (rows[first], rows[last]))
        return float(np.log(y1 / y0) / np.log(x1 / x0))

    points, views = len(POINT_COUNTS), len(VIEW_COUNTS)
    columns = ("views", "points", "image points", "time [ms]", "iterations", "memory [MB]")
    seconds = rows[-1][3]
    assert isinstance(seconds, float)
    note = (
        "Memory: peak of the call above what the process held before it. It grows with the image points, and with the "
        "square of the views: some eight dense matrices over the six corrections of every view."
    )
    return Table("Growth", columns, rows, note), [
        Measure(f"time, {POINT_COUNTS[0]} to {POINT_COUNTS[-1]} points: slope", slope(0, points - 1, 1, 3), LINEAR),
        Measure("memory, 2000 to 20000 points: slope", slope(2, points - 1, 1, 5), LINEAR),
        Measure("time, 100 to 200 views: slope", slope(points + views - 2, points + views - 1, 0, 3), CUBIC),
        Measure(f"{LARGEST[0]} views x {LARGEST[1]} points [s]", seconds / 1e3, PATIENCE),
    ]


def measure(seed: int = 1, rounds: int = 30) -> Report:
    """The comparison, and the growth."""
    (same, limits), (grown, slopes) = against_others(seed, rounds), growth(seed, rounds)
    setup = (
        f"{NOISE.point_px} px, robot {NOISE.robot_mm} mm and {NOISE.robot_deg} deg, lens k1 {DISTORTED[0]}, "
        f"k2 {DISTORTED[1]}; start 1 % wrong in f, 5 px in the centre, 0.5 deg, 5 mm, no distortion. Noise levels "
        "given, no robust loss. "
        f"One thread, processor time, fastest of {rounds} runs (scipy: of {TURNS}), seed {seed}."
    )
    return Report("Speed of the refinement", setup, [same, grown], [*limits, *slopes])


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    line = parser(__doc__ or "")
    line.add_argument("--seed", type=int, default=1, help="seed of scene, motion and noise")
    line.add_argument("--rounds", type=int, default=30, help="runs of which the fastest counts (default 30)")
    options = line.parse_args(arguments)
    return finish(measure(options.seed, options.rounds), options.output)


if __name__ == "__main__":
    sys.exit(main())
