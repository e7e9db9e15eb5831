# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The exact recording with laser images, and calibrations that are off by what their covariance says."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from support.calibrations import refined
from support.exact_recording import exact_recording, stripe_in_camera

import cv_active_handeye as cah
from cv_active_handeye.calibration import Calibration
from cv_active_handeye.calibration_format import NoiseLevel, NoiseLevels
from cv_active_handeye.dataset import CameraInfo, Dataset, LaserInfo

Array = NDArray[np.float64]

SIGMA = 1.5
"""Half width of the drawn stripe, px."""

CALIBRATION_SIGMAS = np.array([0.3, 0.3, 0.2, 0.2, 0, 0, 0, 0, 0, 0, *[5e-5] * 3, *[5e-5] * 3, 1e-4, 0, 0, 5e-5])
"""In the order of `PARAMETERS`. ny and nz follow from nx, since n keeps its length and turns about one axis only."""

ROBOT_M, ROBOT_RAD = 2e-5, 5e-5


def stripe_image(stripe: Array, seed: int | None = None) -> NDArray[np.uint8]:
    """A Gaussian stripe through pixels (M, 2) on a dark image with noise; columns outside of the stripe stay dark."""
    order = np.argsort(stripe[:, 0])
    columns = np.arange(640)
    centre = np.interp(columns, stripe[order, 0], stripe[order, 1], left=-99, right=-99)
    profile = np.exp(-0.5 * ((np.arange(480)[:, None] - centre) / SIGMA) ** 2)
    noise = np.random.default_rng(int(stripe[0, 1] * 1e6) if seed is None else seed).normal(0, 1, (480, 640))
    return np.asarray(np.clip(20 + 180 * profile + noise, 0, 255), np.uint8)


class Stop(NamedTuple):
    """Pose of the gripper, and the stripe (M, 2) px that the camera sees there; None = the laser is off."""

    R: Array
    t: Array
    stripe: Array | None


def laser_dataset(
    folder: Path, surfaces: Sequence[int | None], turned: bool = False, robot_seed: int | None = None
) -> Dataset:
    """One view for every entry of `surfaces`: the stripe crosses this surface; None = the laser is off.

    turned: image and laser with swapped axes; robot_seed: see `record`.
    """
    truth = exact_recording()
    stripes = [None if k is None else truth.stripePoints[3 * view + k] for view, k in enumerate(surfaces)]
    poses = zip(truth.R_gripper2base, truth.t_gripper2base, stripes, strict=False)
    return record(folder, [Stop(*stop) for stop in poses], turned, robot_seed)


def record(folder: Path, stops: Sequence[Stop], turned: bool = False, robot_seed: int | None = None) -> Dataset:
    """A data set with a laser image for every stop. robot_seed: the robot is off by `ROBOT_M`, `ROBOT_RAD`."""
    rng, off = np.random.default_rng(robot_seed), robot_seed is not None
    camera = CameraInfo(width=480, height=640) if turned else CameraInfo(width=640, height=480)
    laser = LaserInfo(stripe="vertical" if turned else "horizontal")
    dataset = Dataset.create(folder, camera=camera, laser=laser)
    for R, t, stripe in stops:
        image = np.full((480, 640), 20, np.uint8) if stripe is None else stripe_image(stripe, robot_seed)
        turn = Rotation.from_rotvec(off * ROBOT_RAD * rng.normal(size=3)).as_matrix()
        shift = off * ROBOT_M * rng.normal(size=3)
        dataset.add_view(turn @ R, t + shift, laser_image=np.ascontiguousarray(image.T) if turned else image)
    return dataset


def stops_through(point: Array, surface: Array, views: Sequence[int]) -> tuple[list[Stop], Array]:
    """The recording's stops `views`, moved until their stripes show `point` (base frame, on the plane `surface` (4,))
    near the middle of the image; and its pixels (V, 2)."""
    truth = exact_recording()
    n, d, X, x = truth.lightPlane[:3], truth.lightPlane[3], truth.R_cam2gripper, truth.t_cam2gripper
    in_light = np.array([0.01, 0.0, (d - 0.01 * n[0]) / n[2]])
    stops, pixels = [], []
    for view in views:
        R = truth.R_gripper2base[view]
        t = point - R @ (X @ in_light + x)
        in_camera = np.append(surface[:3] @ R @ X, surface[3] - surface[:3] @ (R @ x + t))
        seen = np.vstack([stripe_in_camera(in_camera, truth.lightPlane), in_light])
        image = cv2.projectPoints(seen, np.zeros(3), np.zeros(3), truth.cameraMatrix, truth.distCoeffs)[0]
        found: Array = image.reshape(-1, 2).astype(np.float64)
        stops.append(Stop(R, t, found[:-1]))
        pixels.append(found[-1])
    return stops, np.array(pixels)


def true_plane(surface: int) -> Array:
    """Plane (w, e), w.X = e in the base frame, of the recording's surface, from its true stripes."""
    truth = exact_recording()
    points = np.concatenate([true_points(view, truth.stripePoints[3 * view + surface]) for view in range(14)])
    middle = points.mean(axis=0)
    w = np.linalg.svd(points - middle)[2][2]
    return np.append(w, w @ middle)


def true_points(view: int, pixels: Array) -> Array:
    """Pixels (M, 2) of a stripe without noise as points in the base frame."""
    truth = exact_recording()
    points, _ = cah.reprojectStripe(
        pixels,
        truth.cameraMatrix,
        truth.distCoeffs,
        truth.lightPlane,
        R_cam2gripper=truth.R_cam2gripper,
        t_cam2gripper=truth.t_cam2gripper,
        R_gripper2base=truth.R_gripper2base[view],
        t_gripper2base=truth.t_gripper2base[view],
    )
    return points


def calibration_of_truth(seed: int | None = None, **changes: object) -> Calibration:
    """The recording's calibration with errors drawn from its covariance; without `seed` it has none."""
    truth, rng = exact_recording(), np.random.default_rng(seed)
    n, axis = truth.lightPlane[:3], np.cross(truth.lightPlane[:3], [1.0, 0, 0])
    J = np.diag(CALIBRATION_SIGMAS)
    J[16:19, 16] = CALIBRATION_SIGMAS[16] * np.cross(axis / np.linalg.norm(axis), n)
    e = np.zeros(20) if seed is None else J @ rng.normal(size=20)
    normal = n + e[16:19]
    K = truth.cameraMatrix + np.array([[e[0], e[4], e[2]], [0, e[1], e[3]], [0, 0, 0]])
    known = NoiseLevel(level=0.02, lower=0.02, upper=0.02, estimated=False)
    levels = NoiseLevels(
        image_points=known,
        stripes=known,
        robot_translation=known.model_copy(update={"level": ROBOT_M}),
        robot_rotation=known.model_copy(update={"level": ROBOT_RAD}),
    )
    values = {
        "camera_matrix": K,
        "distortion_coefficients": truth.distCoeffs,
        "R_cam2gripper": Rotation.from_rotvec(e[10:13]).as_matrix() @ truth.R_cam2gripper,
        "t_cam2gripper": truth.t_cam2gripper + e[13:16],
        "light_plane": np.append(normal / np.linalg.norm(normal), truth.lightPlane[3] + e[19]),
        "covariance": J @ J.T,
        "noise_levels": levels,
    }
    return refined(**(values | changes))
