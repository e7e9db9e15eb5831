# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Try an installed wheel: calibrate a camera from made-up measurements and compare with the truth.

Needs numpy and the wheel only; with --cv2 first or --cv2 last also cv2, imported before or after the wheel, which has
to compute and to raise its own exceptions beside it. With --import-time it only prints what importing takes, as JSON.
Exit status 0 when everything is right.
"""

from __future__ import annotations

import argparse
import importlib
import json
import subprocess
import sys
import time
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def rotation(axis_angle: ArrayLike) -> Array:
    """Rodrigues' formula: the rotation matrix (3, 3) about an axis by an angle in degrees, given as one vector (3,)."""
    vector = np.radians(np.asarray(axis_angle, dtype=np.float64))
    angle = np.linalg.norm(vector)
    if angle == 0:
        return np.eye(3)
    x, y, z = vector / angle
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    result: Array = np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K
    return result


def gripper_poses() -> tuple[Array, Array]:
    """Two groups of five stops of equal orientation, and two more orientations with two stops each; metres."""
    corners = 0.05 * np.array([[0, 0, 0], [1, 0.1, 0], [0, 1, 0.2], [-0.2, 0, 1], [0.7, 0.7, 0.6]])
    turns = [(0, 0, 0), (20, -8, 5), (-12, 6, 80), (5, -22, -30)]
    rotations, translations = [], []
    for turn, stops in zip(turns, (5, 5, 2, 2), strict=True):
        R = rotation((180, 0, 0)) @ rotation(turn)
        for corner in corners[:stops]:
            rotations.append(R)
            translations.append(np.array([0.4, 0, 0]) - 0.55 * R[:, 2] + corner)
    return np.array(rotations), np.array(translations)


def check(what: str, error: float | np.floating[Any], limit: float) -> None:
    """Stop unless the error is within the limit."""
    print(f"{what}: error {error:.2g}, limit {limit:.2g}")
    if not error <= limit:
        sys.exit(f"{what} is wrong")


def calibrate(cah: ModuleType) -> None:
    """Camera matrix and hand-eye transform from image points with 0.1 px of noise."""
    rng = np.random.default_rng(7)
    K = np.array([[1413.0, 0, 322], [0, 1409, 236], [0, 0, 1]])
    R_cam2gripper, t_cam2gripper = rotation((3, -4, 95)), np.array([0.035, -0.06, 0.045])
    R, t = gripper_poses()
    scene = rng.uniform([0.25, -0.15, -0.06], [0.55, 0.15, 0.06], (80, 3))
    in_gripper = np.einsum("vnj,vjk->vnk", scene - t[:, None], R)
    homogeneous = (in_gripper - t_cam2gripper) @ R_cam2gripper @ K.T
    points = homogeneous[..., :2] / homogeneous[..., 2:] + rng.normal(0, 0.1, (len(R), len(scene), 2))

    _, found_K, _, found_R, found_t, _, summary = cah.refineHandEye(R, t, points, None, None, None, None, None)
    check("focal length [%]", 100 * np.abs(np.diag(found_K) / np.diag(K) - 1).max(), 0.1)
    check("R_cam2gripper [deg]", np.degrees(np.linalg.norm(found_R - R_cam2gripper) / np.sqrt(2)), 0.02)
    check("t_cam2gripper [mm]", 1000 * np.linalg.norm(found_t.ravel() - t_cam2gripper), 0.3)
    check("estimate of the image noise [px]", abs(summary.pointSigma - 0.1), 0.01)
    if not summary.usable:
        sys.exit(summary.message)


def detect_stripe(cah: ModuleType) -> None:
    """Centres of a rendered laser stripe."""
    centre = 60.3 + 0.01 * np.arange(160)
    image = (20 + 180 * np.exp(-0.5 * ((np.arange(120)[:, None] - centre) / 1.5) ** 2)).astype(np.uint8)
    stripe = cah.detectStripe(image)[0]
    check("columns without a stripe", 160 - len(stripe), 0)
    check("stripe [px]", np.abs(stripe[:, 1] - np.interp(stripe[:, 0], np.arange(160), centre)).max(), 0.05)


def refuse(cah: ModuleType) -> Exception:
    """What is raised for input that determines nothing."""
    try:
        cah.estimateFOE([[0, 0]], [[1, 1]])
    except cah.error as error:
        refused: Exception = error
        return refused
    sys.exit("estimateFOE made a result of one point")


def beside(cah: ModuleType, cv2: ModuleType) -> None:
    """Both compute, and each raises what is its own."""
    vector = np.array([0.3, -0.2, 0.5])
    check("cv2.Rodrigues", np.abs(cv2.Rodrigues(vector)[0] - rotation(np.degrees(vector))).max(), 1e-12)
    if isinstance(refuse(cah), cv2.error):
        sys.exit("an exception of the wheel is one of cv2")
    try:
        cv2.Rodrigues(np.zeros((2, 2)))
    except cv2.error as error:
        if isinstance(error, cah.error):
            sys.exit("an exception of cv2 is one of the wheel")
    else:
        sys.exit("cv2.Rodrigues made a rotation of 2 x 2 numbers")


def import_times(runs: int) -> dict[str, float]:
    """Seconds of a fresh interpreter that imports something, beyond one that imports nothing; the best of `runs`."""
    codes = "", "import numpy", "import cv_active_handeye"
    best = dict.fromkeys(codes, float("inf"))
    for _ in range(runs):
        for code in codes:
            start = time.perf_counter()
            subprocess.run([sys.executable, "-I", "-c", code], check=True)
            best[code] = min(best[code], time.perf_counter() - start)
    return {code: best[code] - best[""] for code in codes[1:]}


def main() -> None:
    """Try what the command line says."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cv2", choices=("none", "first", "last"), default="none")
    parser.add_argument("--import-time", type=int, metavar="RUNS")
    options = parser.parse_args()
    if options.import_time:
        print(json.dumps(import_times(options.import_time)))
        return
    order = {"none": ["cv_active_handeye"], "first": ["cv2", "cv_active_handeye"], "last": ["cv_active_handeye", "cv2"]}
    modules = {name: importlib.import_module(name) for name in order[options.cv2]}
    cah = modules.pop("cv_active_handeye")
    for cv2 in modules.values():
        beside(cah, cv2)
    calibrate(cah)
    detect_stripe(cah)
    refuse(cah)
    print("cv_active_handeye", cah.__version__, "is right beside", [cv2.__version__ for cv2 in modules.values()])


if __name__ == "__main__":
    main()
