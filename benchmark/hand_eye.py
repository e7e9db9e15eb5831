# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""`calibrateHandEye` from poses: errors against the Cramér-Rao bound and OpenCV's methods, coverage, and bad data.

The bound is that of X and the pose of the target, with the errors of all reported poses unknown and their true standard
deviations as prior; derivatives are differences, no code is shared with C++.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

import cv_active_handeye as cah

from . import cluster
from .hand_eye_sets import BAD_SETS, PoseSet, bad_set, recorded, views_of
from .report import Cell, Measure, Report, Table
from .scene import Array

NAMES = ("TSAI", "PARK", "HORAUD", "ANDREFF", "DANIILIDIS", "REFINED")
MOTIONS = {
    "OpenCV's test, 10 views": (10, (5.0, 45.0)),
    "OpenCV's test, 5 views": (5, (5.0, 45.0)),
    "OpenCV's test, 30 views": (30, (5.0, 45.0)),
    "turns to 6 deg, 15 views": (15, (2.0, 6.0)),
    "turns to 170 deg, 10 views": (10, (20.0, 170.0)),
}
"""Views, and the range of their angles [deg]."""
NOISES = {
    "camera": ((0.002, 0.005), (0.0, 0.0)),
    "camera and robot": ((0.002, 0.005), (0.001, 0.001)),
    "robot": ((0.0002, 0.0005), (0.002, 0.001)),
}
"""Standard deviations of a component of rotation vector [rad] and translation [m]: target2cam, gripper2base."""
WRONG_DEG, WRONG_M = 1.0, 0.1
"""From here on an answer to exact data with something wrong is a wrong answer."""


def numbers_of(name: str) -> int:
    """The method's number, which is OpenCV's too."""
    return NAMES.index(name)


@dataclass(frozen=True)
class Trial:
    """Errors (6, 6) of the methods, rotation vector [rad] and translation [m], NaN = refused; the bound (6,).

    Of REFINED: whether its intervals hold the truth (6,), and how many views it left out.
    """

    errors: Array
    bound: Array
    hits: Array
    rejected: int


def seen(views: PoseSet, step: Array, errors: Array) -> Array:
    """Poses of the target (V, 6): rotation vector against the true one, and translation, up to a constant.

    `step`: of X and target; `errors` (V, 6): of the robot's poses.
    """
    turn = Rotation.from_rotvec
    X, target = turn(step[:3]).as_matrix() @ views.X[:3, :3], turn(step[6:9]).as_matrix() @ views.target[:3, :3]
    R = turn(errors[:, :3]).as_matrix() @ views.gripper2base[:, :3, :3] @ X
    t = views.gripper2base[:, :3, 3] + errors[:, 3:]
    t = t + np.einsum(
        "vij,j->vi", turn(errors[:, :3]).as_matrix() @ views.gripper2base[:, :3, :3], views.X[:3, 3] + step[3:6]
    )
    turned = R.transpose(0, 2, 1) @ target
    shift = np.einsum("vji,vj->vi", R, views.target[:3, 3] + step[9:] - t)
    difference = Rotation.from_matrix(turned @ views.target2cam[:, :3, :3].transpose(0, 2, 1)).as_rotvec()
    return np.hstack([difference, shift])


def bound(views: PoseSet, camera: tuple[float, float], robot: tuple[float, float]) -> Array:
    """Standard deviations (6,) of the rotation error vector and t_cam2gripper that no unbiased method can beat."""
    count, h = len(views.gripper2base), 1e-6
    none, zero = np.zeros(12), np.zeros((count, 6))
    by_step = np.array([(seen(views, e, zero) - seen(views, -e, zero)) / (2 * h) for e in h * np.eye(12)])
    by_error = np.array([(seen(views, none, zero + e) - seen(views, none, zero - e)) / (2 * h) for e in h * np.eye(6)])
    floor = 1e-9
    prior = np.repeat(np.maximum(robot, floor), 3) ** 2
    information = np.zeros((12, 12))
    for view in range(count):
        J = by_error[:, view].T
        covariance = np.diag(np.repeat(camera, 3) ** 2) + J @ np.diag(prior) @ J.T
        information += by_step[:, view] @ np.linalg.solve(covariance, by_step[:, view].T)
    return np.sqrt(np.diag(np.linalg.inv(information))[:6])


def error_of(views: PoseSet, R: Array, t: Array) -> Array:
    """(6,): true R = exp(error) R, true t = t + error; infinite when R is left-handed, NaN when not finite."""
    if not (np.isfinite(R).all() and np.isfinite(t).all()):
        return np.full(6, np.nan)
    if np.linalg.det(R) <= 0:
        return np.full(6, np.inf)
    turn = Rotation.from_matrix(views.X[:3, :3] @ R.T).as_rotvec()
    return np.append(turn, views.X[:3, 3] - t.ravel())


def answer(views: PoseSet, name: str, opencv: bool) -> Array | None:
    """Error of one method; None when it refuses."""
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)  # TSAI logs every failure
    call = cv2.calibrateHandEye if opencv else cah.calibrateHandEye
    try:
        R, t = call(*recorded(views), method=numbers_of(name))
    except (cv2.error, cah.error):
        return None
    return error_of(views, np.asarray(R), np.asarray(t))


def trial(motion: str, noise: str, seed: int, number: int) -> Trial:
    """One recording by OpenCV's methods and ours."""
    count, turn_deg = MOTIONS[motion]
    rng = np.random.default_rng([seed, number])
    true = views_of(rng, count, turn_deg)
    views = true.disturbed(rng, *NOISES[noise])
    errors = [answer(views, name, opencv=True) for name in NAMES[:5]]
    errors = [np.full(6, np.nan) if error is None else error for error in errors]
    try:
        _, R, t, summary = cah.calibrateHandEyeExtended(*recorded(views))
    except cah.error:
        return Trial(np.array([*errors, np.full(6, np.nan)]), bound(true, *NOISES[noise]), np.full(6, np.nan), 0)
    error = error_of(views, R, t)
    half = 0.5 * (summary.intervals95[:, 1] - summary.intervals95[:, 0])
    hits = (np.abs(error) <= half).astype(np.float64)
    return Trial(np.array([*errors, error]), bound(true, *NOISES[noise]), hits, len(summary.rejectedViews))


def rmse(errors: Array) -> float:
    """Of vectors (T, 3); NaN when one is."""
    return float(np.sqrt(np.mean(np.sum(errors**2, axis=1))))


def accuracy_rows(motion: str, noise: str, found: Sequence[Trial]) -> list[list[Cell]]:
    """Rotation and translation: RMSE of every method / bound."""
    errors, bounds = np.array([t.errors for t in found]), np.array([t.bound for t in found])
    rows: list[list[Cell]] = []
    for part, unit, name in ((slice(0, 3), np.degrees(1.0), "rotation [deg]"), (slice(3, 6), 1e3, "translation [mm]")):
        limit = rmse(bounds[:, part])
        refused = np.isnan(errors[:, :, 0])
        ratios = [
            rmse(errors[~refused[:, at]][:, at, part]) / limit if not refused[:, at].all() else None for at in range(6)
        ]
        rows.append([motion, noise, name, limit * unit, *ratios, int(refused[:, 5].sum())])
    return rows


def coverage_row(motion: str, noise: str, found: Sequence[Trial]) -> list[Cell]:
    """Share of intervals that hold the truth, and good views that were left out."""
    hits = np.array([t.hits for t in found if np.isfinite(t.hits).all()])
    views = MOTIONS[motion][0] * len(found)
    return [
        motion,
        noise,
        float(100 * hits[:, :3].mean()),
        float(100 * hits[:, 3:].mean()),
        float(100 * sum(t.rejected for t in found) / views),
    ]


def verdict(error: Array | None) -> str:
    """How a call on exact but bad data ended."""
    if error is None:
        return "refused"
    if not np.isfinite(error).all():
        return "NaN" if np.isnan(error).any() else "left-handed"
    angle, distance = float(np.degrees(np.linalg.norm(error[:3]))), float(np.linalg.norm(error[3:]))
    return "right" if angle < 1e-3 and distance < 1e-3 else f"{angle:.2g} / {distance:.2g}"


def is_wrong(text: str) -> bool:
    """Whether a caller would go on with a wrong answer."""
    if text in ("refused", "right"):
        return False
    return text in ("NaN", "left-handed") or any(
        value > limit for value, limit in zip(map(float, text.split(" / ")), (WRONG_DEG, WRONG_M), strict=True)
    )


def bad_tables(seed: int) -> tuple[list[Table], int]:
    """What every method does with bad data, OpenCV's and ours; the wrong answers of REFINED."""
    tables, wrong = [], 0
    for opencv, title in ((True, "Bad data: cv2.calibrateHandEye"), (False, "Bad data: calibrateHandEye")):
        names = NAMES[:5] if opencv else NAMES
        rows: list[list[Cell]] = []
        for kind in BAD_SETS:
            views = bad_set(kind, np.random.default_rng(seed))
            texts = [verdict(answer(views, name, opencv)) for name in names]
            wrong += 0 if opencv else is_wrong(texts[5])
            rows.append([kind, *texts])
        note = (
            "Ten exact poses but for what the first column says. Error of the rotation [deg] / of the translation [m]."
        )
        tables.append(Table(title, ("data", *names), rows, note))
    return tables, wrong


def measure(workers: cluster.Workers, trials: int = 300, seed: int = 1) -> Report:
    """Every motion with every noise, then bad data."""
    accuracy: list[list[Cell]] = []
    coverage: list[list[Cell]] = []
    for motion in MOTIONS:
        for noise in NOISES:
            found = workers.run(partial(trial, motion, noise, seed), trials, f"{motion}, {noise}")
            accuracy += accuracy_rows(motion, noise, found)
            coverage.append(coverage_row(motion, noise, found))
    tables, wrong = bad_tables(seed)
    ratios = [float(row[9]) for row in accuracy if isinstance(row[9], float)]
    few = [ratio for ratio, row in zip(ratios, accuracy, strict=True) if MOTIONS[str(row[0])][0] < 10]
    many = [ratio for ratio, row in zip(ratios, accuracy, strict=True) if MOTIONS[str(row[0])][0] >= 10]
    best = [min(float(cell) for cell in row[4:9] if isinstance(cell, float) and cell == cell) for row in accuracy]
    covered = [float(cell) for row in coverage for cell in row[2:4] if isinstance(cell, float)]
    measures = [
        Measure("10 views and more, levels estimated: RMSE / bound", max(many), 1.10),
        Measure("5 views, levels estimated: RMSE / bound", max(few), 1.25),
        Measure("REFINED: RMSE / that of the best of OpenCV's methods", max(np.divide(ratios, best)), 1.02),
        Measure("coverage of the 95 % intervals is off by [%]", max(abs(c - 95) for c in covered), 3.0),
        Measure("good views left out [%]", max(float(row[4] or 0) for row in coverage), 0.1),
        Measure("REFINED: wrong answers to bad data", wrong, 0),
    ]
    setup = (
        f"{trials} trials, seed {seed}. Poses as OpenCV's own test draws them, metres. Noise of a component, camera / "
        "robot: `camera` 2 mrad, 5 mm / none; `camera and robot` 2 mrad, 5 mm / 1 mrad, 1 mm (OpenCV's test); `robot` "
        "0.2 mrad, 0.5 mm / 2 mrad, 1 mm. RMSE / bound: 1 = nothing can be better. Trials in which a method refuses or "
        "returns NaN do not count for it."
    )
    columns = ("motion", "noise", "error of", "bound", *(f"{name} / bound" for name in NAMES), "REFINED refused")
    intervals = ("motion", "noise", "rotation [%]", "translation [%]", "good views left out [%]")
    all_tables = [
        Table("RMSE against the bound", columns, accuracy),
        Table("95 % intervals of calibrateHandEyeExtended that hold the truth", intervals, coverage),
        *tables,
    ]
    return Report("Hand-eye transform from poses of a target", setup, all_tables, measures)


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""

    def run(workers: cluster.Workers, options: argparse.Namespace) -> Report:
        return measure(workers, options.trials, options.seed)

    return cluster.main(__doc__, run, 300, "trials of every motion and noise", arguments)


if __name__ == "__main__":
    sys.exit(main())
