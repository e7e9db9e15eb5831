# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What OpenCV makes of a board: calibrateCamera, then the five methods of calibrateHandEye."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from cv2.typing import MatLike
from scipy.spatial.transform import Rotation

from .scene import CENTRE, FOCAL, HEIGHT, WIDTH, Array
from .stops import board_stop
from .world import Recording, World, in_image

METHODS = {
    "Tsai": cv2.CALIB_HAND_EYE_TSAI,
    "Park": cv2.CALIB_HAND_EYE_PARK,
    "Horaud": cv2.CALIB_HAND_EYE_HORAUD,
    "Andreff": cv2.CALIB_HAND_EYE_ANDREFF,
    "Daniilidis": cv2.CALIB_HAND_EYE_DANIILIDIS,
}
NO_DISTORTION = cv2.CALIB_FIX_K1 | cv2.CALIB_FIX_K2 | cv2.CALIB_FIX_K3 | cv2.CALIB_ZERO_TANGENT_DIST
MARGIN_PX = 5.0


def corners(columns: int = 9, rows: int = 6, square: float = 0.02) -> Array:
    """Corners (N, 3) of a board, its middle at the origin; metres."""
    grid = np.mgrid[0:columns, 0:rows].reshape(2, -1).T - [(columns - 1) / 2, (rows - 1) / 2]
    return np.column_stack([square * grid, np.zeros(len(grid))])


def put_board(rng: np.random.Generator, world: World, board: Array) -> World:
    """The same cameras before a board that lies at CENTRE, turned a little; each view sees the corners in its image."""
    turn = Rotation.from_euler("xyz", rng.uniform(-3, 3, 3), degrees=True)
    points = CENTRE + turn.apply(board)
    return replace(world, points=points, visible=in_image(world, points), board=True, stripes=None)


def board_stops(rng: np.random.Generator, views: int, board: Array) -> tuple[Array, Array]:
    """R_cam2base and positions of the camera; stops that do not see the whole board are drawn again."""
    found: list[tuple[Array, Array]] = []
    while len(found) < views:
        R, position = board_stop(rng)
        in_camera = (CENTRE + board - position) @ R
        pixels = FOCAL * in_camera[:, :2] / in_camera[:, 2:]
        if np.all(np.abs(pixels) < np.array([WIDTH, HEIGHT]) / 2 - MARGIN_PX):
            found.append((R, position))
    orientations, positions = (np.array(column) for column in zip(*found, strict=True))
    return orientations, positions


@dataclass(frozen=True)
class BoardCalibration:
    """calibrateCamera's K, and the hand-eye transform (R, t) of every method that returned one."""

    camera_matrix: Array
    hand_eye: dict[str, tuple[Array, Array]]


def opencv(recording: Recording, board: Array, known_camera: Array | None = None, least: int = 6) -> BoardCalibration:
    """OpenCV on the corners seen (views with fewer than `least` are left out); no distortion, as is true."""
    views = [v for v, seen in enumerate(recording.image_points) if np.isfinite(seen[:, 0]).sum() >= least]
    seen = [np.isfinite(recording.image_points[v][:, 0]) for v in views]
    objects = [board[used].astype(np.float32) for used in seen]
    images = [recording.image_points[v][used].astype(np.float32) for v, used in zip(views, seen, strict=True)]
    if known_camera is None:
        size = (WIDTH, HEIGHT)
        _, K, _, turns, shifts = cv2.calibrateCamera(objects, images, size, np.eye(3), np.zeros(5), flags=NO_DISTORTION)
    else:
        K = known_camera
        poses = [cv2.solvePnP(o, i, K, np.zeros(5)) for o, i in zip(objects, images, strict=True)]
        turns, shifts = [pose[1] for pose in poses], [pose[2] for pose in poses]
    R_target2cam = [cv2.Rodrigues(turn)[0] for turn in turns]
    robot = list(recording.R_gripper2base[views]), list(recording.t_gripper2base[views])
    return BoardCalibration(np.asarray(K, dtype=np.float64), hand_eye(*robot, R_target2cam, shifts))


def hand_eye(
    R_gripper2base: Sequence[MatLike],
    t_gripper2base: Sequence[MatLike],
    R_target2cam: Sequence[MatLike],
    t_target2cam: Sequence[MatLike],
) -> dict[str, tuple[Array, Array]]:
    """R_cam2gripper, t_cam2gripper (3) of every method; those that fail or return NaN are left out."""
    found = {}
    for name, method in METHODS.items():
        try:
            R, t = cv2.calibrateHandEye(R_gripper2base, t_gripper2base, R_target2cam, t_target2cam, method=method)
        except cv2.error:
            continue
        if np.isfinite(R).all() and np.isfinite(t).all():
            found[name] = np.asarray(R, dtype=np.float64), np.asarray(t, dtype=np.float64).ravel()
    return found


def hand_eye_error(world: World, R: Array, t: Array) -> Array:
    """Rotation [deg] and translation [mm] between a hand-eye transform and the true one."""
    turn = Rotation.from_matrix(world.R_cam2gripper @ R.T).magnitude()
    return np.array([np.degrees(turn), 1000 * np.linalg.norm(world.t_cam2gripper - np.ravel(t))])
