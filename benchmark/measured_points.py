# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Points measured with the calibrated laser (reprojectStripe): their errors against the covariances returned.

Every trial calibrates a random cell with stripes (refineHandEye, noise levels estimated), moves the robot to a new
place, and measures one point of the stripe there. What is stated is the joint covariance of the calibration, the pixel
noise and the estimated noise of the robot, carried into the base frame.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from functools import partial

import numpy as np
from scipy.spatial.transform import Rotation
from scipy.stats import chi2, norm

import cv_active_handeye as cah

from . import cluster
from .refine_trials import Case, Estimate, calibrate, settings
from .report import Cell, Measure, Report, Table
from .scene import Array
from .stops import STOPS_12
from .world import Noise, World, pixels

CASES = (
    Case("24 stops", stripes=True),
    Case("24 stops, robot 0.1 mm / 0.03 deg, k1 k2", Noise(robot_mm=0.1, robot_deg=0.03), stripes=True, distorted=True),
    Case("12 stops", stops=STOPS_12, stripes=True),
)
STATED, SLACK = 95.0, 2.0


def stripe_point(rng: np.random.Generator, world: World, R: Array, t: Array) -> tuple[Array, Array]:
    """A point (3) of the light plane in the base frame, on one of the surfaces, and its exact pixel."""
    assert world.stripes is not None
    view, surface = 0, int(rng.integers(len(world.stripes.surfaces)))
    pixel = world.stripes.segments(world, R[None], t[None])[view, surface, rng.integers(world.stripes.columns.shape[1])]
    n, d = world.stripes.light_plane[:3], world.stripes.light_plane[3]
    K = world.camera_matrix
    ray = (pixel - K[:2, 2]) / np.diag(K)[:2]
    for _ in range(50):
        ray = ray + (pixel - pixels(world.parameters(), ray)) / np.diag(K)[:2]
    in_camera = np.append(ray, 1) * d / (np.append(ray, 1) @ n)
    return R @ (world.R_cam2gripper @ in_camera + world.t_cam2gripper) + t, pixel


def measured(rng: np.random.Generator, case: Case, world: World, found: Estimate) -> tuple[Array, Array]:
    """Error (3) and stated covariance (3, 3) of one point, base frame."""
    place = int(rng.integers(len(world.R_gripper2base)))
    reported = world.R_gripper2base[place], world.t_gripper2base[place] + rng.uniform(-0.02, 0.02, 3)
    turn = Rotation.from_rotvec(rng.normal(0, case.noise.rotation, 3)).as_matrix()
    true = turn @ reported[0], reported[1] + rng.normal(0, case.noise.translation, 3)
    point, pixel = stripe_point(rng, world, *true)
    seen = pixel + rng.normal(0, case.noise.stripe_px, 2)
    K, D, R, t, plane = found.calibration
    assert plane is not None
    points, covariances = cah.reprojectStripe(
        seen[None],
        K,
        D,
        plane,
        R_cam2gripper=R,
        t_cam2gripper=t,
        R_gripper2base=reported[0],
        t_gripper2base=reported[1],
        calibrationCovariance=found.summary.covariance,
        pixelSigmas=case.noise.stripe_px,
        robotTranslationSigma=found.summary.robotTranslationSigma,
        robotRotationSigma=found.summary.robotRotationSigma,
    )
    assert covariances is not None
    return points[0] - point, covariances[0]


def trial(case: Case, seed: int, number: int) -> tuple[Array, Array]:
    """Error (3) and stated covariance (3, 3)."""
    rng = np.random.default_rng([seed, number])
    world = case.world(rng)
    found = calibrate(world, world.record(rng, case.noise), settings(case.lens_model))
    return measured(rng, case, world, found)


def coverages(errors: Array, covariances: Array) -> tuple[list[float], float]:
    """Percentages within the 95 % interval of x, y, z, and within the 95 % ellipsoid."""
    deviations = np.sqrt(np.diagonal(covariances, axis1=1, axis2=2))
    inside = np.abs(errors) <= norm.ppf(0.975) * deviations
    squares = np.einsum("ti,ti->t", errors, np.linalg.solve(covariances, errors[..., None])[..., 0])
    return (100 * inside.mean(axis=0)).tolist(), 100 * float(np.mean(squares <= chi2.ppf(0.95, 3)))


def measure(workers: cluster.Workers, trials: int = 1000, seed: int = 1) -> Report:
    """All cases."""
    rows: list[list[Cell]] = []
    measures = []
    for case in CASES:
        pairs = workers.run(partial(trial, case, seed), trials, case.name)
        errors, covariances = (np.array(column) for column in zip(*pairs, strict=True))
        each, whole = coverages(errors, covariances)
        stated = float(np.sqrt(np.mean(np.trace(covariances, axis1=1, axis2=2))))
        rmse = float(np.sqrt(np.mean(np.sum(errors**2, axis=1))))
        rows.append([case.name, 1000 * rmse, 1000 * stated, rmse / stated, *each, whole])
        for name, share in (*zip("xyz", each, strict=True), ("ellipsoid", whole)):
            measures.append(
                Measure(f"{case.name}: {name}, coverage off {STATED:g} % by [%]", abs(share - STATED), SLACK)
            )
    columns = ("case", "RMSE [mm]", "stated [mm]", "ratio", "x [%]", "y [%]", "z [%]", "ellipsoid [%]")
    setup = (
        f"{trials} trials, seed {seed}; one point each, 0.1 px, at a place that the calibration has not seen. "
        "Coverage: share of the points inside the 95 % interval of each base coordinate, and inside the 95 % ellipsoid."
    )
    return Report(
        "Points measured with the calibrated laser", setup, [Table("Errors and coverage", columns, rows)], measures
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    return cluster.main(
        __doc__, lambda workers, o: measure(workers, o.trials, o.seed), 1000, "trials per case", arguments
    )


if __name__ == "__main__":
    sys.exit(main())
