# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Hand-eye calibration by the test protocols of others: OpenCV's, Koide's (RA-L 2019) and ViSP's.

OpenCV's protocol has no images: it adds noise to poses of the target, half of which are behind any camera. It is run as
it is for OpenCV's methods. For refineHandEye, which works on images, a wide camera (1280 x 960, f = 600 px) and a 9 x 6
board of 0.1 m squares are put in: motions, hand-eye transforms and robot noise are drawn as in the protocol, poses that
do not see the whole board are drawn again, and 0.2 px of noise on the corners give the poses of the target the
protocol's 2 mrad. OpenCV's methods get the same images through solvePnP.

Koide's protocol has images and is run as it is, over its three sweeps. ViSP's is its unit test without noise. K is
known in all of them. Not run, because they have poses only, with noise that no image gives: Wise's and crigroup's.
Profilers over a plane are another sensor.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from functools import partial

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

import cv_active_handeye as cah

from . import cluster
from .boards import METHODS, hand_eye
from .protocol_sets import BoardSet, koide_set, opencv_images, opencv_poses, visp_set
from .refine_trials import settings
from .report import Cell, Measure, Report, Table
from .scene import Array

OURS = "ours, board"
NAMES = [*METHODS, OURS]
SWEEPS = {
    "pixel noise [px]": [(sigma, 0.01, 0.01) for sigma in (0.0, 1.0, 2.0, 3.0, 4.0, 5.0)],
    "translation noise [m]": [(0.1, sigma, 0.01) for sigma in (0.0, 0.05, 0.10, 0.15, 0.20, 0.25)],
    "rotation noise [deg]": [(0.1, 0.01, sigma) for sigma in (0.0, 2.0, 4.0, 6.0, 8.0, 10.0)],
}
EXACT, TIE, MAX_REFUSED = 1e-6, 1.02, 5.0


def errors(board_set: BoardSet, R: Array, t: Array) -> Array:
    """Rotation [deg] and translation [mm] of cam2gripper."""
    X = board_set.cam2gripper
    turn = Rotation.from_matrix(X[:3, :3] @ R.T).magnitude()
    return np.array([np.degrees(turn), 1000 * np.linalg.norm(X[:3, 3] - t)])


def opencv_errors(board_set: BoardSet, target2cam: Array) -> Array:
    """(5, 2), NaN where a method fails."""
    gripper = board_set.gripper2base
    robot = list(gripper[:, :3, :3]), list(gripper[:, :3, 3])
    found = hand_eye(*robot, list(target2cam[:, :3, :3]), list(target2cam[:, :3, 3]))
    return np.array([errors(board_set, *found[name]) if name in found else [np.nan, np.nan] for name in METHODS])


def measured_poses(board_set: BoardSet) -> Array:
    """target2cam (V, 4, 4) by solvePnP."""
    poses = np.tile(np.eye(4), (len(board_set.image_points), 1, 1))
    for T, seen in zip(poses, board_set.image_points, strict=True):
        _, turn, shift = cv2.solvePnP(board_set.board, seen, board_set.camera_matrix, np.zeros(5))
        T[:3, :3], T[:3, 3] = cv2.Rodrigues(turn)[0], shift.ravel()
    return poses


def our_errors(board_set: BoardSet, target2cam: Array) -> Array:
    """(2,): refineHandEye with known points, K known, from OpenCV's result (Park); NaN when refused."""
    gripper = board_set.gripper2base
    robot = list(gripper[:, :3, :3]), list(gripper[:, :3, 3])
    R, t = hand_eye(*robot, list(target2cam[:, :3, :3]), list(target2cam[:, :3, 3]))["Park"]
    params = settings(cah.LENS_FIXED, flags=cah.REFINE_FIX_K)
    start = board_set.camera_matrix, None, R, t, None
    try:
        found = cah.refineHandEye(*robot, board_set.image_points, *start, objectPoints=board_set.board, params=params)
    except cah.error:
        return np.array([np.nan, np.nan])
    return errors(board_set, found[3], found[4].ravel())


def images_trial(make: Callable[[np.random.Generator], BoardSet], seed: int, number: int) -> tuple[Array, Array]:
    """Errors (6, 2) of all methods on images; errors (V, 6) of solvePnP's poses: rotation vector, translation."""
    board_set = make(np.random.default_rng([seed, number]))
    measured = measured_poses(board_set)
    turns = Rotation.from_matrix(measured[:, :3, :3] @ board_set.target2cam[:, :3, :3].transpose(0, 2, 1)).as_rotvec()
    off = np.column_stack([turns, (measured - board_set.target2cam)[:, :3, 3]])
    return np.vstack([opencv_errors(board_set, measured), our_errors(board_set, measured)]), off


def poses_trial(seed: int, number: int) -> Array:
    """Errors (5, 2) of OpenCV's methods in OpenCV's own protocol."""
    board_set = opencv_poses(np.random.default_rng([seed, number]))
    return opencv_errors(board_set, board_set.target2cam)


def koide(pixel: float, translation: float, rotation_deg: float, rng: np.random.Generator) -> BoardSet:
    """Arguments in the order that partial needs."""
    return koide_set(rng, pixel, translation, rotation_deg)


def opencv_table(own: Array, images: Array, off: Array) -> Table:
    """RMSE, median and largest error: the protocol as it is, and with images."""
    rows: list[list[Cell]] = []
    for title, found in (("as it is", own), ("with images", images)):
        for at, name in enumerate(NAMES[: found.shape[1]]):
            cells: list[Cell] = [title, name, int(np.isnan(found[:, at, 0]).sum())]
            for part in (0, 1):
                e = found[:, at, part]
                cells += [float(np.sqrt(np.nanmean(e**2))), float(np.nanmedian(e)), float(np.nanmax(e))]
            rows.append(cells)
    columns = (
        "protocol",
        "method",
        "failed",
        *(f"{w} {u}" for u in ("[deg]", "[mm]") for w in ("RMSE", "median", "max")),
    )
    turn, shift = (1000 * float(np.sqrt(np.mean(part**2))) for part in (off[..., :3], off[..., 3:]))
    note = (
        "Noise of the target's poses that solvePnP gives with images, RMS per component: "
        f"{turn:.2f} mrad, {shift:.2f} mm (protocol: 2 mrad, 5 mm)."
    )
    return Table("OpenCV's protocol", columns, rows, note)


def sweep_table(title: str, values: Sequence[float], found: Sequence[Array]) -> Table:
    """RMSE of every method over one sweep."""
    rows: list[list[Cell]] = []
    for value, errors_of in zip(values, found, strict=True):
        rmse = np.sqrt(np.nanmean(errors_of**2, axis=0))
        refused = int(np.isnan(errors_of[:, -1, 0]).sum())
        rows.append([f"{value:g}", *rmse[:, 0].tolist(), *rmse[:, 1].tolist(), refused])
    columns = (title, *(f"{name} {unit}" for unit in ("[deg]", "[mm]") for name in NAMES), "ours refused")
    return Table(f"Koide's protocol over {title}: RMSE", columns, rows)


def against_best(name: str, found: Array) -> list[Measure]:
    """RMSE of ours over the best of OpenCV's, rotation and translation."""
    rmse = np.sqrt(np.nanmean(found**2, axis=0))
    ratio = rmse[-1] / rmse[:-1].min(axis=0)
    return [
        Measure(f"{name}: {what}, ours / best of OpenCV", float(r), TIE)
        for what, r in zip(("rotation", "t"), ratio, strict=True)
    ]


def refused(name: str, found: Sequence[Array], limit: float) -> Measure:
    """Percentage of trials in which ours refuses; where t is no better known than a tenth of the distance it may."""
    return Measure(f"{name}: refused [%]", 100 * float(np.mean(np.isnan(np.concatenate(found)[:, -1, 0]))), limit)


def measure(workers: cluster.Workers, trials: int = 100, seed: int = 1) -> Report:
    """All protocols."""
    own = np.array(workers.run(partial(poses_trial, seed), 10 * trials, "OpenCV's protocol"))
    pairs = workers.run(partial(images_trial, opencv_images, seed), 2 * trials, "OpenCV's protocol with images")
    images, off = (np.array(column) for column in zip(*pairs, strict=True))
    tables, measures = [opencv_table(own, images, off)], against_best("OpenCV's protocol with images", images)
    measures.append(refused("OpenCV's protocol with images", [images], 0))
    for swept, (title, settings_of) in enumerate(SWEEPS.items()):
        found, values = [], [setting[swept] for setting in settings_of]
        for setting in settings_of:
            trial = partial(images_trial, partial(koide, *setting), seed)
            found.append(np.array([one[0] for one in workers.run(trial, trials, f"Koide, {title} {setting[swept]:g}")]))
            measures += against_best(f"Koide, {title} {setting[swept]:g}", found[-1])
        tables.append(sweep_table(title, values, found))
        measures.append(refused(f"Koide, {title}", found, MAX_REFUSED))
    exact = visp_set()
    found_exact = np.vstack([opencv_errors(exact, exact.target2cam), our_errors(exact, exact.target2cam)])
    rows: list[list[Cell]] = [[name, *row.tolist()] for name, row in zip(NAMES, found_exact, strict=True)]
    tables.append(Table("ViSP's unit test, without noise", ("method", "rotation [deg]", "t [mm]"), rows))
    measures.append(
        Measure("ViSP's unit test: larger of rotation [deg] and t [mm]", float(found_exact[-1].max()), EXACT)
    )
    setup = (
        f"{10 * trials}, {2 * trials} and {trials} trials, seed {seed}. K known. OpenCV's protocol: ten poses; as it "
        "is, noise is added to poses and half of the targets are behind the camera, so only OpenCV's methods can be "
        "run; with images: motions as in the protocol, seen by a wide camera before a large board, 0.2 px. Koide's: 18 "
        "poses, 0.1 px, 0.01 m, 0.01 deg where not swept. ours: refineHandEye on the corners, noise levels estimated, "
        "from Park's result."
    )
    return Report("Test protocols of others", setup, tables, measures)


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    return cluster.main(
        __doc__, lambda workers, o: measure(workers, o.trials, o.seed),
        100, "trials per setting, as published", arguments,
    )


if __name__ == "__main__":
    sys.exit(main())
