# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""One least-squares problem of refineHandEye, and its solution by Ceres and by scipy.optimize.least_squares.

Unknowns: fx, fy, cx, cy, k1, k2, R_cam2gripper, t_cam2gripper, a correction of every robot pose (true R = exp(w)
R_gripper2base, true t = t + e) and all points. Known noise levels; no robust loss. Metres, pixels.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.sparse import csr_array
from scipy.spatial.transform import Rotation

from .scene import Array
from .world import Noise, Recording, World

FOLDER = Path(__file__).parent / "ceres"
SHARED = 12
"""fx, fy, cx, cy, k1, k2, rotation vector and translation of the camera in the gripper frame."""


@dataclass(frozen=True)
class Problem:
    """Reported poses, M image points with their views and points, noise levels, and where all solvers start."""

    R_gripper2base: Array
    t_gripper2base: Array
    view: NDArray[np.int64]
    point: NDArray[np.int64]
    pixels: Array
    noise: Noise
    shared: Array
    points: Array

    def start(self) -> Array:
        """All unknowns: the shared ones, six corrections per view (w, e), points."""
        return np.concatenate([self.shared, np.zeros(6 * len(self.R_gripper2base)), self.points.ravel()])

    def split(self, unknowns: Array) -> tuple[Array, Array, Array]:
        """shared (12), corrections (V, 6), points (N, 3)."""
        V = len(self.R_gripper2base)
        shared, corrections, points = np.split(unknowns, [SHARED, SHARED + 6 * V])
        return shared, corrections.reshape(V, 6), points.reshape(-1, 3)

    def residuals(self, unknowns: Array) -> Array:
        """In units of their standard deviations: x, y of every image point, then the corrections."""
        shared, corrections, points = self.split(unknowns)
        w, e = corrections[:, :3], corrections[:, 3:]
        gripper2base = Rotation.from_rotvec(w).as_matrix() @ self.R_gripper2base
        cam2gripper = Rotation.from_rotvec(shared[6:9]).as_matrix()
        to_camera = np.swapaxes(gripper2base @ cam2gripper, 1, 2)
        centre = np.einsum("vij,j->vi", gripper2base, shared[9:12]) + self.t_gripper2base + e
        X = np.einsum("mij,mj->mi", to_camera[self.view], points[self.point] - centre[self.view])
        ray = X[:, :2] / X[:, 2:]
        r2 = (ray**2).sum(axis=1, keepdims=True)
        image = shared[:2] * ray * (1 + r2 * (shared[4] + r2 * shared[5])) + shared[2:4]
        errors = (image - self.pixels) / self.noise.point_px
        return np.concatenate([errors.ravel(), (w / self.noise.rotation).ravel(), (e / self.noise.translation).ravel()])

    def sparsity(self) -> csr_array:
        """Which residual hangs on which unknown."""
        M, V = len(self.view), len(self.R_gripper2base)
        own = np.concatenate(
            [
                np.broadcast_to(np.arange(SHARED), (M, SHARED)),
                SHARED + 6 * self.view[:, None] + np.arange(6),
                SHARED + 6 * V + 3 * self.point[:, None] + np.arange(3),
            ],
            axis=1,
        )
        corrections = SHARED + np.arange(6 * V).reshape(V, 6)
        columns = np.concatenate(
            [np.repeat(own, 2, axis=0).ravel(), corrections[:, :3].ravel(), corrections[:, 3:].ravel()]
        )
        rows = np.concatenate([np.repeat(np.arange(2 * M), own.shape[1]), 2 * M + np.arange(6 * V)])
        return csr_array((np.ones(len(rows), np.int8), (rows, columns)))

    def save(self, path: Path) -> None:
        """Writes the problem as text, for the program refine_ceres."""
        header = [len(self.R_gripper2base), len(self.points), len(self.view)]
        poses = np.hstack([self.R_gripper2base.reshape(-1, 9), self.t_gripper2base])
        numbers = [self.noise.point_px, self.noise.rotation, self.noise.translation, *self.shared]
        with path.open("w", encoding="ascii") as file:
            print(*header, *map(repr, map(float, numbers)), file=file)
            np.savetxt(file, poses, "%.17g")
            np.savetxt(file, self.points, "%.17g")
            np.savetxt(file, np.column_stack([self.view, self.point, self.pixels]), "%d %d %.17g %.17g")


@dataclass(frozen=True)
class Solution:
    """What a solver found: all unknowns, the sum of squares, and what it took."""

    unknowns: Array
    cost: float
    iterations: int
    seconds: float


def make_problem(world: World, recording: Recording, noise: Noise, shared: Array) -> Problem:
    """The problem of a recording, its points triangulated with the calibration `shared` that everything starts from."""
    view, point = np.nonzero(world.visible)
    pixels = recording.image_points[view, point]
    motion = recording.R_gripper2base, recording.t_gripper2base
    problem = Problem(*motion, view, point, pixels, noise, shared, np.zeros((world.visible.shape[1], 3)))
    return replace(problem, points=triangulate(problem))


def triangulate(problem: Problem) -> Array:
    """Points (N, 3) nearest to the viewing rays, without lens distortion."""
    shared = problem.shared
    R = problem.R_gripper2base @ Rotation.from_rotvec(shared[6:9]).as_matrix()
    centre = (problem.R_gripper2base @ shared[9:12] + problem.t_gripper2base)[problem.view]
    rays = np.insert((problem.pixels - shared[2:4]) / shared[:2], 2, 1.0, axis=1)
    directions = np.einsum("mij,mj->mi", R[problem.view], rays / np.linalg.norm(rays, axis=1, keepdims=True))
    across = np.eye(3) - directions[:, :, None] * directions[:, None]
    left, right = np.zeros((len(problem.points), 3, 3)), np.zeros((len(problem.points), 3, 1))
    np.add.at(left, problem.point, across)
    np.add.at(right, problem.point, across @ centre[:, :, None])
    return np.asarray(np.linalg.solve(left, right)[:, :, 0], dtype=np.float64)


def build_ceres(folder: Path) -> Path:
    """Builds benchmark/ceres in `folder`; the program."""
    cmake = shutil.which("cmake")
    if cmake is None:
        raise RuntimeError("refine_speed needs CMake; `make setup` brings it into .venv/bin, which has to be on PATH")
    for step in (["-S", str(FOLDER), "-B", str(folder), "-DCMAKE_BUILD_TYPE=Release"], ["--build", str(folder)]):
        done = subprocess.run([cmake, *step], capture_output=True, text=True, check=False)
        if done.returncode:
            missing = "CeresConfig.cmake" in done.stderr
            hint = "Ceres is missing; install it (Debian, Ubuntu: libceres-dev)" if missing else "see below"
            raise RuntimeError(f"{FOLDER} cannot be built: {hint}\n{done.stderr}")
    return folder / "refine_ceres"


def solve_ceres(program: Path, file: Path, solver: str, tolerance: float, rounds: int) -> Solution:
    """Solution of the problem in `file` by one of Ceres' linear solvers; the fastest of `rounds` runs counts."""
    one_thread = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    command = [str(program), str(file), solver, repr(tolerance), str(rounds)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=one_thread)
    if done.returncode:
        raise RuntimeError(done.stderr)
    seconds, iterations, cost, *unknowns = map(float, done.stdout.split())
    return Solution(np.array(unknowns), cost, int(iterations), seconds)


def solve_scipy(problem: Problem, accurate: bool) -> Solution:
    """Solution by least_squares with finite differences along the sparsity.

    LSMR's default tolerances stop short of the optimum; `accurate` tightens them, as one who looks at the result does.
    """
    tight = {"atol": 1e-12, "btol": 1e-12, "conlim": 1e16, "maxiter": 5000, "regularize": False}
    start = time.process_time()
    found = least_squares(
        problem.residuals,
        problem.start(),
        jac_sparsity=problem.sparsity(),
        x_scale="jac",
        tr_options=tight if accurate else {},
    )
    seconds = time.process_time() - start
    return Solution(found.x, 2 * float(found.cost), found.njev or 0, seconds)
