# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Accuracy of the closed forms against the Cramér-Rao bound.

Every trial is another scene, another motion and another noise: 30 points at 0.45 to 0.65 m, camera 640 x 480 with
f = 1413 px, four translations of 45 to 56 mm in each group, 0.1 px. The RMS error over all trials is compared with the
RMS of the trials' bounds: 1 is the best an unbiased estimator can do. Covariances are judged by normalised errors: 1 is
honest.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

import cv_active_handeye as cah

from . import bounds
from .report import Cell, Measure, Report, Table, finish, parser, progress
from .scene import Array, Scene, random_scene

SIGMA = 0.1
LIMIT, HONESTY = 1.1, 0.1
ALL, ZERO_SKEW = np.eye(8), np.delete(np.eye(8), 4, axis=1)
SQUARE = np.column_stack([np.eye(8)[:, 0] + np.eye(8)[:, 1], np.eye(8)[:, [2, 3, 5, 6, 7]]])
QUANTITIES = {
    "fx [px]": [0],
    "fy [px]": [1],
    "cx [px]": [2],
    "cy [px]": [3],
    "skew [px]": [4],
    "rotation [deg]": [5, 6, 7],
}
UNITS = np.array([1, 1, 1, 1, 1, *np.degrees([1, 1, 1])])


@dataclass(frozen=True)
class Case:
    """One way of using calibrateHandEyeTranslations; `free` are the parameters its flags leave free."""

    name: str
    flags: int = 0
    free: Array = field(default_factory=lambda: ALL)
    stops: tuple[int, ...] = (5,)
    missing: float = 0.0
    with_foe: bool = True

    @property
    def known(self) -> bool:
        """Whether the camera matrix is given."""
        return bool(self.flags & cah.TRANSLATIONS_FIX_K)

    def scene(self, rng: np.random.Generator) -> Scene:
        """A random scene for it."""
        return random_scene(rng, 30, self.stops, self.missing, square=bool(self.flags & cah.TRANSLATIONS_SQUARE_PIXELS))


CASES = (
    Case("four translations, K unknown"),
    Case("zero skew", cah.TRANSLATIONS_ZERO_SKEW, ZERO_SKEW),
    Case("square pixels", cah.TRANSLATIONS_SQUARE_PIXELS, SQUARE),
    Case("K known", cah.TRANSLATIONS_FIX_K, np.eye(8)[:, 5:]),
    Case("two groups of four", stops=(5, 5)),
    Case("two groups, 30 % of the points missing", stops=(5, 5), missing=0.3, with_foe=False),
)
ROTATION_STOPS = (5, 5, 2, 2)


@dataclass(frozen=True)
class Errors:
    """Of T trials: errors (T, n), bounds (T, n, n), returned covariances (T, n, n); and the number of failed calls."""

    errors: Array
    bounds: Array
    covariances: Array
    failed: int = 0

    def rmse(self, indices: Sequence[int]) -> float:
        """RMS length of the error in some parameters."""
        return float(np.sqrt(np.mean(np.sum(self.errors[:, indices] ** 2, axis=1))))

    def bound(self, indices: Sequence[int]) -> float:
        """RMS over the trials of the bound of the same."""
        return float(np.sqrt(np.mean(np.trace(self.bounds[:, indices][:, :, indices], axis1=1, axis2=2))))

    def ratio(self, indices: Sequence[int]) -> float:
        """RMSE over bound."""
        return self.rmse(indices) / self.bound(indices)

    def normalised(self, indices: Sequence[int]) -> float:
        """RMS of error over its own standard deviation, all components of a block together; 1 = honest covariance."""
        blocks = self.covariances[:, indices][:, :, indices]
        squares = np.einsum(
            "ti,ti->t", self.errors[:, indices], np.linalg.solve(blocks, self.errors[:, indices, None])[..., 0]
        )
        return float(np.sqrt(np.mean(squares) / len(indices)))


def translations_error(scene: Scene, K: Array, R: Array) -> Array:
    """Estimate against truth: fx, fy, cx, cy, skew [px] and rotation error vector in the gripper frame [rad]."""
    d = scene.camera_matrix - K
    w = Rotation.from_matrix(scene.R_cam2gripper @ R.T).as_rotvec()
    return np.array([d[0, 0], d[1, 1], d[0, 2], d[1, 2], d[0, 1], *w])


def translations_trials(
    case: Case, method: int, trials: int, seed: int, show: Callable[[int], None] = lambda done: None
) -> Errors:
    """Errors of calibrateHandEyeTranslations; trial i is the same scene for every method and every number of trials."""
    errors, covariances, bound, failed = [], [], [], 0
    for trial in range(trials):
        rng = np.random.default_rng([seed, trial])
        scene = case.scene(rng)
        seen = scene.observe(rng, SIGMA)
        K = scene.camera_matrix if case.known else None
        motion = scene.R_gripper2base, scene.t_gripper2base
        try:
            _, K_found, R, C = cah.calibrateHandEyeTranslations(*motion, seen, K, None, method=method, flags=case.flags)
        except cah.error:
            failed += 1
            continue
        errors.append(translations_error(scene, K_found, R))
        covariances.append(C)
        bound.append(bounds.translations_bound(scene, SIGMA, case.free))
        show(trial + 1)
    return Errors(np.array(errors), np.array(bound), np.array(covariances), failed)


@dataclass(frozen=True)
class PositionErrors:
    """Errors of t_cam2gripper (metres) with the true K and R, and with those of the translations."""

    true_camera: Errors
    estimated_camera: Errors
    joint_bound: float


def rotation_trials(
    trials: int, seed: int, missing: float = 0.0, show: Callable[[int], None] = lambda done: None
) -> PositionErrors:
    """Errors of calibrateHandEyeRotation on two groups of four translations and two more orientations of two stops."""
    known: list[tuple[Array, Array, Array]] = []
    chained: list[tuple[Array, Array, Array]] = []
    joint = []
    for trial in range(trials):
        rng = np.random.default_rng([seed, trial])
        scene = random_scene(rng, 30, ROTATION_STOPS, missing)
        seen = scene.observe(rng, SIGMA)
        motion = scene.R_gripper2base, scene.t_gripper2base
        given_known, given_estimated = bounds.rotation_bounds(
            scene, SIGMA, bounds.translations_bound(scene, SIGMA, ALL)
        )
        _, t, C = cah.calibrateHandEyeRotation(*motion, seen, scene.camera_matrix, None, scene.R_cam2gripper)
        known.append((scene.t_cam2gripper - t[:, 0], given_known, C))
        _, K, R, _ = cah.calibrateHandEyeTranslations(*motion, seen, None, None)
        _, t, C = cah.calibrateHandEyeRotation(*motion, seen, K, None, R)
        chained.append((scene.t_cam2gripper - t[:, 0], given_estimated, C))
        joint.append(np.trace(bounds.joint_bound(scene, SIGMA, ALL)[bounds.TRANSLATION, bounds.TRANSLATION]))
        show(trial + 1)
    return PositionErrors(_stack(known), _stack(chained), float(np.sqrt(np.mean(joint))))


def _stack(trials: list[tuple[Array, Array, Array]]) -> Errors:
    errors, bound, covariances = (np.array(column) for column in zip(*trials, strict=True))
    return Errors(errors, bound, covariances)


def translations_table(case: Case, metric: Errors, foe: Errors | None) -> Table:
    """One case: every quantity against its bound, METRIC and FOE."""
    rows: list[list[Cell]] = []
    for name, indices in QUANTITIES.items():
        if not np.any(case.free[indices]):
            continue
        unit = float(UNITS[indices[0]])
        row: list[Cell] = [name, unit * metric.bound(indices), unit * metric.rmse(indices), metric.ratio(indices)]
        row += [unit * foe.rmse(indices), foe.ratio(indices)] if foe else [None, None]
        row += [metric.normalised(indices), foe.normalised(indices) if foe else None]
        rows.append(row)
    columns = ("quantity", "bound", "METRIC RMSE", "/ bound", "FOE RMSE", "/ bound", "METRIC e/σ", "FOE e/σ")
    note = f"Failed calls: METRIC {metric.failed}" + (f", FOE {foe.failed}." if foe else "; FOE was not run.")
    return Table(f"calibrateHandEyeTranslations: {case.name}", columns, rows, note)


def position_table(found: dict[str, PositionErrors]) -> Table:
    """t_cam2gripper against its bounds."""
    rows: list[list[Cell]] = []
    every = [0, 1, 2]
    for name, position in found.items():
        for camera, errors in (("true", position.true_camera), ("estimated", position.estimated_camera)):
            honest = errors.normalised(every) if camera == "true" else None
            row: list[Cell] = [name, camera, 1000 * errors.bound(every), 1000 * errors.rmse(every), errors.ratio(every)]
            rows.append([*row, honest, 1000 * position.joint_bound])
    columns = ("points", "K, R", "bound [mm]", "RMSE [mm]", "/ bound", "e/σ", "bound of all at once [mm]")
    note = (
        "Estimated: the bound includes what the error of K and R, from the translations alone, does to t. The returned "
        "covariance is for given K and R. The last column is what a joint refinement could reach."
    )
    return Table(
        "calibrateHandEyeRotation: t_cam2gripper, two groups of four translations and two turns", columns, rows, note
    )


def translations_measures(case: Case, metric: Errors) -> list[Measure]:
    """Limits of one case: no failed call, RMSE at the bound, covariance honest."""
    free = {name.split()[0]: indices for name, indices in QUANTITIES.items() if np.any(case.free[indices])}
    honest = [metric.normalised(indices) for indices in free.values()]
    return [
        Measure(f"{case.name}: failed calls of METRIC", metric.failed, 0),
        *(
            Measure(f"{case.name}: {name}, RMSE / bound", metric.ratio(indices), LIMIT)
            for name, indices in free.items()
            if name != "skew"
        ),
        Measure(f"{case.name}: distance of e/σ from 1, largest", max(abs(x - 1) for x in honest), HONESTY),
    ]


def position_measures(name: str, position: PositionErrors) -> list[Measure]:
    """Limits of t_cam2gripper: RMSE at both bounds, covariance honest."""
    every = [0, 1, 2]
    what = f"t_cam2gripper, {name}"
    return [
        Measure(f"{what}, true K and R: RMSE / bound", position.true_camera.ratio(every), LIMIT),
        Measure(f"{what}, estimated K and R: RMSE / bound", position.estimated_camera.ratio(every), LIMIT),
        Measure(f"{what}: distance of e/σ from 1", abs(position.true_camera.normalised(every) - 1), HONESTY),
    ]


def measure(trials: int = 1000, seed: int = 1) -> Report:
    """All cases; the measures are those of the issue, and the same for the other ways of calling."""
    tables, measures = [], []
    for case in CASES:
        show = progress(trials, case.name)
        metric = translations_trials(case, cah.TRANSLATIONS_METRIC, trials, seed, show)
        foe = translations_trials(case, cah.TRANSLATIONS_FOE, trials, seed, show) if case.with_foe else None
        tables.append(translations_table(case, metric, foe))
        measures += translations_measures(case, metric)
    shares = {"all points seen": 0.0, "30 % of the points missing": 0.3}
    positions = {name: rotation_trials(trials, seed, share, progress(trials, name)) for name, share in shares.items()}
    tables.append(position_table(positions))
    for name, position in positions.items():
        measures += position_measures(name, position)
    setup = (
        f"{trials} trials, seed {seed}. Camera 640 x 480, f = 1413 px; 30 points at 0.45 to 0.65 m; four translations "
        "of 45 to 56 mm towards the corners of a tetrahedron in each group; 0.1 px noise. Every trial is a new scene, "
        "motion and noise. RMSE over all trials beside the RMS of the trials' Cramér-Rao bounds for the information "
        "the function uses. e/σ: RMS of the errors normalised by the returned covariance, 1 = honest."
    )
    return Report("Closed forms against the Cramér-Rao bound", setup, tables, measures)


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    line = parser(__doc__ or "")
    line.add_argument("--trials", type=int, default=1000, help="trials per case (default 1000; 100 take seconds)")
    line.add_argument("--seed", type=int, default=1, help="trial i uses the random numbers of (seed, i)")
    options = line.parse_args(arguments)
    return finish(measure(options.trials, options.seed), options.output)


if __name__ == "__main__":
    sys.exit(main())
