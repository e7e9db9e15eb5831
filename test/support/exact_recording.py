# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A recording without noise: poses, image points and laser stripes of a known calibration, projected by OpenCV."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Recording:
    """What robot and camera report (first block), and the calibration behind it (second block). Metres and pixels."""

    R_gripper2base: Array
    t_gripper2base: Array
    imagePoints: Array
    stripePoints: list[Array]
    stripeViews: list[int]
    surfaceIds: list[int]
    surfaceImagePoints: Array
    """Of scene points that lie on the surfaces of the stripes; those of imagePoints do not."""

    cameraMatrix: Array
    distCoeffs: Array
    R_cam2gripper: Array
    t_cam2gripper: Array
    lightPlane: Array


def gripper_poses() -> tuple[Array, Array]:
    """Two groups of five stops (four translations each), and two more orientations with two stops each."""
    corners = 0.05 * np.array([[0, 0, 0], [1, 0.1, 0], [0, 1, 0.2], [-0.2, 0, 1], [0.7, 0.7, 0.6]])
    down = Rotation.from_euler("x", 180, degrees=True)
    turns = [(0, 0, 0), (20, -8, 5), (-12, 6, 80), (5, -22, -30)]
    rotations, translations = [], []
    for k, (turn, stops) in enumerate(zip(turns, (5, 5, 2, 2), strict=True)):
        rotation = down * Rotation.from_euler("xyz", turn, degrees=True)
        optical_axis = rotation.as_matrix()[:, 2]
        for stop in range(stops):
            rotations.append(rotation.as_matrix())
            translations.append(np.array([0.4, 0.1 * k, 0]) - 0.55 * optical_axis + corners[stop + (k > 1)])
    return np.array(rotations), np.array(translations)


def to_camera(points: Array, R: Array, t: Array, X: Array, x: Array) -> Array:
    """Scene points (N, 3) of the base frame in the camera frame of one view."""
    result: Array = ((points - t) @ R - x) @ X
    return result


def stripe_in_camera(surface: Array, light: Array) -> Array:
    """Forty points of the line in which two planes (n, d) of the camera frame meet, around the optical axis."""
    direction = np.cross(surface[:3], light[:3])
    direction /= np.linalg.norm(direction)
    origin = np.linalg.solve(np.array([surface[:3], light[:3], direction]), [surface[3], light[3], 0.0])
    origin -= direction * (origin[0] * direction[0] + origin[1] * direction[1])
    result: Array = origin + np.linspace(-0.06, 0.06, 40)[:, None] * direction
    return result


@cache
def exact_recording(bump_mm: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Recording:
    """The recording, with the camera moved in the gripper by `bump_mm`; the same object every time."""
    rng = np.random.default_rng(7)
    K = np.array([[1413.0, 0.0, 322.0], [0.0, 1409.0, 236.0], [0.0, 0.0, 1.0]])
    D = np.array([-0.08, 0.05, 0.0007, -0.0004, 0.0])
    X = Rotation.from_euler("xyz", [3, -4, 95], degrees=True).as_matrix()
    x = np.array([0.035, -0.06, 0.045]) + np.array(bump_mm) / 1000
    light = np.array([0.05, 0.87, 0.45, 0.0])
    light[:3] /= np.linalg.norm(light[:3])
    light[3] = 0.5 * light[2]
    R, t = gripper_poses()
    scene = rng.uniform([0.25, -0.15, -0.06], [0.55, 0.45, 0.06], (60, 3))
    surfaces = np.array([[0.1, 0.05, 1, 0.02], [-0.35, 0.1, 1, -0.15], [0.15, 0.4, 1, 0.1]])
    surfaces /= np.linalg.norm(surfaces[:, :3], axis=1, keepdims=True)

    def image(points: Array) -> Array:
        pixels, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), K, D)
        return np.asarray(pixels.reshape(-1, 2), dtype=np.float64)

    stripes, views, ids, on_surfaces = [], [], [], []
    for i in range(len(R)):
        for j, (*normal, distance) in enumerate(surfaces):
            to_base = R[i] @ X
            origin = R[i] @ x + t[i]
            in_camera = np.append(np.array(normal) @ to_base, distance - np.dot(normal, origin))
            points = stripe_in_camera(in_camera, light)
            on_surfaces.append(points[::8] @ to_base.T + origin)
            stripes.append(image(points))
            views.append(i)
            ids.append(j)
    image_points, surface_points = (
        np.array([image(to_camera(points, R[i], t[i], X, x)) for i in range(len(R))])
        for points in (scene, np.concatenate(on_surfaces))
    )
    return Recording(R, t, image_points, stripes, views, ids, surface_points, K, D, X, x, light)
