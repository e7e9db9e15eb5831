# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A recording with noise of image and robot, and the summary that a refinement of it would have.

Nothing is estimated: the residuals are the noise itself and the covariance is that of the model linearised at the
truth, so that every number has the size it has in earnest.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import cv_active_handeye as cah
from cv_active_handeye.calibration import Calibration, Rms
from cv_active_handeye.dataset import CameraInfo, Dataset, LaserInfo
from cv_active_handeye.workflow import Evidence, StripeSegment

Array = NDArray[np.float64]

NAMES = ["fx", "fy", "cx", "cy", "skew", "k1", "k2", "p1", "p2", "k3"]
NAMES += ["rx", "ry", "rz", "tx", "ty", "tz", "nx", "ny", "nz", "d"]
FREE = [0, 1, 2, 3, 5, 6, 10, 11, 12, 13, 14, 15]
WIDTH, HEIGHT = 640, 480
K = np.array([[1413.0, 0.0, 322.0], [0.0, 1409.0, 236.0], [0.0, 0.0, 1.0]])
D = np.array([-0.08, 0.05, 0.0, 0.0, 0.0])
R_CAM2GRIPPER = Rotation.from_euler("xyz", [3, -4, 95], degrees=True).as_matrix()
T_CAM2GRIPPER = np.array([0.035, -0.06, 0.045])
LIGHT_PLANE = np.append(np.array([0.05, 0.87, 0.45]) / np.linalg.norm([0.05, 0.87, 0.45]), 0.182)
TRUTH = np.concatenate([[K[0, 0], K[1, 1], K[0, 2], K[1, 2], 0], D, np.zeros(3), T_CAM2GRIPPER, LIGHT_PLANE])

POINT_SIGMA, STRIPE_SIGMA = 0.1, 0.05
TRANSLATION_SIGMA, ROTATION_SIGMA = 2e-5, 2e-4
DISTANCE = 0.4
STOPS = np.array([[0, 0, 0], [40, 0, 0], [0, 40, 0], [10, 10, 40]]) / 1000


@dataclass
class RefinedRecording:
    """What `write_report` takes; `summary` has the attributes of `cah.RefineSummary`."""

    dataset: Dataset
    calibration: Calibration
    evidence: Evidence
    summary: Any


def refined_recording(
    folder: Path, *, views: int = 16, points: int = 150, laser: bool = True, description: str = ""
) -> RefinedRecording:
    """Four stops an orientation; one image point of a hundred is wrong and left out, as is one stripe segment."""
    rng = np.random.default_rng(3)
    cameras = _camera_poses(views)
    scene = _scene(points)
    exact = np.array([_project(TRUTH, R, t, scene) for R, t in cameras])
    exact[((exact < 0) | (exact > [WIDTH - 1, HEIGHT - 1])).any(axis=2)] = np.nan
    noise = rng.normal(0, POINT_SIGMA, exact.shape)
    rejected = (rng.random(exact.shape[:2]) < 0.01) & np.isfinite(exact[:, :, 0])
    noise[rejected] += rng.normal(0, 6, (int(rejected.sum()), 2))
    corrections = rng.normal(0, np.repeat([ROTATION_SIGMA, TRANSLATION_SIGMA], 3), (views, 6))

    dataset = _dataset(folder, cameras, corrections, laser, description)
    evidence = Evidence(exact + noise, _segments(views) if laser else ())
    summary = _summary(len(evidence.segments), _covariance(laser).copy(), exact - (exact + noise))
    summary.rejectedObservations = rejected.astype(np.uint8)
    summary.poseCorrections = corrections
    summary.scenePoints = scene + np.array([0.4, 0.1, 0.0])
    summary.viewRms = _view_rms(summary.residuals, rejected)
    summary.rms = float(np.sqrt(2) * np.nanstd(summary.residuals[~rejected]))
    summary.stripeResiduals = rng.normal(0, STRIPE_SIGMA, (len(evidence.segments), 2))
    if laser:
        summary.rejectedSegments = [7]
        summary.stripeResiduals[7] = np.nan
        summary.stripeResiduals[2::3] = np.nan
        summary.stripeGroups = np.array([[0, 4, 11, 3, 0.0031, 0.00042], [4, 4, 12, 3, np.inf, np.inf]])
    return RefinedRecording(dataset, _calibration(dataset, evidence, laser), evidence, summary)


def _scene(points: int) -> Array:
    return np.random.default_rng(8).uniform([-0.12, -0.1, -0.02], [0.12, 0.1, 0.02], (points, 3))


def _camera_poses(views: int) -> list[tuple[Array, Array]]:
    """Camera to scene: tilted by up to 25 degrees, turned about the axis by all angles, looking at the origin."""
    poses = []
    for view in range(views):
        group, stop = divmod(view, len(STOPS))
        around, tilt = 2.4 * group, 0 if group == 0 else 18 + 3 * (group % 4)
        turn = Rotation.from_euler("ZXZ", [np.degrees(around), 180 + tilt, 75 * group], degrees=True)
        R = turn.as_matrix()
        poses.append((R, -DISTANCE * R[:, 2] + R @ STOPS[stop]))
    return poses


def _project(parameters: Array, R: Array, t: Array, scene: Array) -> Array:
    """Pixels of `scene` (N, 3) for a camera-to-scene pose at the true hand-eye; `parameters` as NAMES, errors for X."""
    fx, fy, cx, cy, skew = parameters[:5]
    E = Rotation.from_rotvec(parameters[10:13]).as_matrix()
    gripper = (scene - t) @ R @ R_CAM2GRIPPER.T + T_CAM2GRIPPER
    in_camera = (gripper - parameters[13:16]) @ E @ R_CAM2GRIPPER
    matrix = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])
    pixels, _ = cv2.projectPoints(in_camera, np.zeros(3), np.zeros(3), matrix, parameters[5:10])
    result: Array = pixels.reshape(-1, 2).astype(np.float64)
    result[:, 0] += skew * (result[:, 1] - cy) / fy
    return result


@cache
def _covariance(laser: bool) -> Array:
    """(20, 20) of sixteen views of 150 points; points and pose corrections are eliminated, the lens model is k1, k2."""
    size, views = len(FREE), 16
    cameras, scene = _camera_poses(views), _scene(150)
    normal = np.diag(np.repeat([0, 1 / ROTATION_SIGMA**2, 1 / TRANSLATION_SIGMA**2], [size, 3 * views, 3 * views]))
    blocks = [_jacobians(v, cameras, scene) for v in range(views)]
    for j in range(len(scene)):
        J, P = (np.concatenate([block[k][j] for block in blocks]) for k in (0, 1))
        normal += J.T @ (J - P @ np.linalg.pinv(P) @ J)
    C = np.zeros((20, 20))
    C[np.ix_(FREE, FREE)] = np.linalg.inv(normal)[:size, :size]
    if laser:
        C[16:, 16:] = np.diag([4e-5, 3e-5, 6e-5, 2e-5]) ** 2
        C[18, 19] = C[19, 18] = 0.8 * 6e-5 * 2e-5
    return C


def _jacobians(view: int, cameras: list[tuple[Array, Array]], scene: Array) -> tuple[Array, Array]:
    """Of the pixels in sigmas by parameters and pose corrections (N, 2, P), and by the points (N, 2, 3)."""
    R, t = cameras[view]
    base = _project(TRUTH, R, t, scene)
    J = np.zeros((*base.shape, len(FREE) + 6 * len(cameras)))
    for column, (i, step) in enumerate(zip(FREE, np.repeat([1e-2, 1e-5, 1e-6], [4, 2, 6]), strict=True)):
        J[:, :, column] = (_project(TRUTH + step * np.eye(20)[i], R, t, scene) - base) / step
    P = np.zeros((*base.shape, 3))
    for k, step in enumerate(1e-6 * np.eye(3)):
        rotation, translation = len(FREE) + 3 * view + k, len(FREE) + 3 * (len(cameras) + view) + k
        J[:, :, rotation] = (_project(TRUTH, Rotation.from_rotvec(step).as_matrix() @ R, t, scene) - base) / 1e-6
        J[:, :, translation] = (_project(TRUTH, R, t + step, scene) - base) / 1e-6
        P[:, :, k] = (_project(TRUTH, R, t, scene + step) - base) / 1e-6
    weight = np.where(((base >= 0) & (base <= [WIDTH - 1, HEIGHT - 1])).all(axis=1), 1 / POINT_SIGMA, 0.0)
    return J * weight[:, None, None], P * weight[:, None, None]


def _summary(segments: int, C: Array, residuals: Array) -> SimpleNamespace:
    sigmas = np.sqrt(np.diag(C))
    levels = np.array([POINT_SIGMA, STRIPE_SIGMA if segments else np.nan, TRANSLATION_SIGMA, ROTATION_SIGMA])
    lens = [[312.4, 5, 0, 302.4], [18.1, 4, 0.0012, 10.1], [2.9, 3, 0.41, -3.1], [0.4, 1, 0.53, -1.6], [0, 0, 1, 0]]
    return SimpleNamespace(
        usable=True,
        message="usable: a point at the working distance of 0.4 is known to 0.00029 (unit of t_gripper2base, 95 %)",
        stopReason="relative change of the cost below 1e-12",
        iterations=17,
        parameterNames=list(NAMES),
        covariance=C,
        standardDeviations=sigmas[:, None],
        degreesOfFreedom=np.full((20, 1), 60.0),
        intervals95=np.column_stack([TRUTH - 2.0 * sigmas, TRUTH + 2.0 * sigmas]),
        pointSigma=POINT_SIGMA,
        stripeSigma=STRIPE_SIGMA,
        robotTranslationSigma=TRANSLATION_SIGMA,
        robotRotationSigma=ROTATION_SIGMA,
        noiseLevels=np.column_stack([levels, 0.93 * levels, 1.09 * levels, np.ones(4)]),
        chiSquare=1591.2,
        chiSquareDof=1604.0,
        chiSquarePValue=0.585,
        lensModel=int(getattr(cah, "LENS_K1_K2", 2)),
        lensTests=np.array(lens),
        stripeGroups=np.zeros((0, 6)),
        residuals=residuals,
        rejectedViews=[],
        rejectedSegments=[],
        culprits=[],
        weakDirections=[],
        workingDistance=DISTANCE,
        toolCovariance=C[13:16, 13:16] + DISTANCE**2 * np.trace(C[10:13, 10:13]) / 3 * np.eye(3),
    )


def _view_rms(residuals: Array, rejected: NDArray[np.bool_]) -> Array:
    used = np.where(rejected[:, :, None], np.nan, residuals)
    result: Array = np.sqrt(np.nanmean((used**2).sum(axis=2), axis=1))[:, None]
    return result


def _dataset(
    folder: Path, cameras: list[tuple[Array, Array]], corrections: Array, laser: bool, description: str
) -> Dataset:
    camera = CameraInfo(width=WIDTH, height=HEIGHT)
    dataset = Dataset.create(folder, camera=camera, laser=LaserInfo() if laser else None, description=description)
    for (R, t), correction in zip(cameras, corrections, strict=True):
        R_gripper2base = R @ R_CAM2GRIPPER.T
        t_gripper2base = t - R_gripper2base @ T_CAM2GRIPPER + np.array([0.4, 0.1, 0.0])
        wrong = Rotation.from_rotvec(correction[:3]).inv().as_matrix()
        dataset.add_view(wrong @ R_gripper2base, t_gripper2base - correction[3:])
    return dataset


def _segments(views: int) -> tuple[StripeSegment, ...]:
    """Three segments a view, the last of a surface that is not known."""
    u = np.linspace(0, 170, 40)
    found = []
    for view, piece in itertools.product(range(views), range(3)):
        points = np.column_stack([40 + 195 * piece + u, 240 + 4 * view - 0.02 * u])
        found.append(StripeSegment(view, points, piece if piece < 2 else -1))
    return tuple(found)


def _calibration(dataset: Dataset, evidence: Evidence, laser: bool) -> Calibration:
    return Calibration(
        software_version=cah.__version__,
        dataset_sha256=dataset.sha256(),
        constraints=("zero_skew",),
        image_width=WIDTH,
        image_height=HEIGHT,
        camera_matrix=K,
        distortion_coefficients=D,
        R_cam2gripper=R_CAM2GRIPPER,
        t_cam2gripper=T_CAM2GRIPPER,
        light_plane=LIGHT_PLANE if laser else None,
        parameter_names=tuple(NAMES),
        covariance=np.zeros((20, 20)),
        rms=Rms(translations_px=0.1, rotation_px=0.1),
        views=len(dataset),
        points=evidence.image_points.shape[1],
        observations=int(np.isfinite(evidence.image_points[:, :, 0]).sum()),
        stripe_segments=len(evidence.segments),
    )
