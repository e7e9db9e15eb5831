# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""How flat the light plane of a real laser is: stripes by detectStripe, put into space by the board they lie on."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

import cv_active_handeye as cah
from cv_active_handeye.dataset import Dataset
from cv_active_handeye.workflow import BoardSpec
from cv_active_handeye.workflow.boards import find_board
from cv_active_handeye.workflow.compare import BoardCamera, board_poses
from cv_active_handeye.workflow.evidence import stripe_params

from .report import Cell, Table

Array = NDArray[np.float64]
MAX_DISTANCE = 0.05
"""Stripe points farther than this (m) from the board's centre may lie on something else."""


def on_board(pixels: Array, board2cam: Array, centre: Array, camera: BoardCamera) -> Array:
    """Where the rays of `pixels` meet the board plane, (M, 3) in the camera frame, near the board only."""
    rays = cv2.undistortPoints(pixels.reshape(-1, 1, 2), camera.camera_matrix, camera.distortion).reshape(-1, 2)
    rays = np.column_stack([rays, np.ones(len(rays))])
    normal, origin = board2cam[:3, 2], board2cam[:3, 3]
    points = rays * ((normal @ origin) / (rays @ normal))[:, None]
    near = np.linalg.norm(points - board2cam[:3, :3] @ centre - origin, axis=1) < MAX_DISTANCE
    return np.asarray(points[near], np.float64)


def laser_table(name: str, dataset: Dataset, camera: BoardCamera) -> Table:
    """RMS distance of all stripe points to one plane, robustly fitted."""
    points, objects = find_board(dataset, BoardSpec.parse("points"), lambda done, total: None)
    poses = board_poses(points, objects, camera.views, camera.camera_matrix, camera.distortion)
    params = stripe_params(dataset)
    found: list[Array] = []
    rows = 0
    for view, pose in zip(camera.views, poses, strict=True):
        image = dataset.laser_image(view)
        assert image is not None
        stripe, _ = cah.detectStripe(image, params=params)
        rows += len(stripe)
        if len(stripe):
            found.append(on_board(stripe, pose, objects.mean(axis=0), camera))
    cloud = np.concatenate(found)
    normal, offset, inliers = fit_plane(cloud)
    rms = float(np.sqrt(np.mean((cloud[inliers] @ normal - offset) ** 2)))
    share = rows / (len(camera.views) * dataset.camera.height)
    cells: list[Cell] = [len(camera.views), 100 * share, len(cloud), 100 * float(inliers.mean()), 1000 * rms]
    columns = ("images", "rows with a stripe [%]", "points on the board", "used [%]", "RMS distance to a plane [mm]")
    note = f"normal ({normal[0]:.4f}, {normal[1]:.4f}, {normal[2]:.4f}), distance {1000 * offset:.2f} mm"
    return Table(f"{name}: the laser stripe, put into space by the board", columns, [cells], note)


def fit_plane(cloud: Array) -> tuple[Array, float, NDArray[np.bool_]]:
    """Normal, offset and inliers (within three robust sigmas) of the plane through most of `cloud`."""
    inliers = np.ones(len(cloud), np.bool_)
    for _ in range(10):
        centre = cloud[inliers].mean(axis=0)
        normal = np.linalg.svd(cloud[inliers] - centre, full_matrices=False)[2][2]
        distance = np.abs((cloud - centre) @ normal)
        inliers = distance <= 3 * 1.4826 * np.median(distance[inliers])
    normal = normal if normal @ centre > 0 else -normal
    return normal, float(normal @ centre), inliers
