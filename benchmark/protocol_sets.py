# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Simulations by which others test hand-eye calibration, as read in their sources: OpenCV's, Koide's and ViSP's."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from .boards import corners
from .scene import Array

OPENCV_VIEWS = 10
OPENCV_TARGET_NOISE, OPENCV_ROBOT_NOISE = (0.002, 0.005), (0.001, 0.001)
"""Standard deviations per component: rotation vector [rad], translation [m]."""
OPENCV_SIZE, OPENCV_K = np.array([1280.0, 960.0]), np.array([[600.0, 0, 640], [0, 600, 480], [0, 0, 1]])
OPENCV_BOARD, OPENCV_PIXEL = corners(9, 6, 0.1), 0.2
KOIDE_K = np.array([[300.0, 0, 320], [0, 300, 240], [0, 0, 1]])
KOIDE_BOARD = corners(7, 5, 0.1)


@dataclass(frozen=True)
class BoardSet:
    """V reported robot poses (V, 4, 4), target2cam (measured or true), images of the board, true cam2gripper."""

    gripper2base: Array
    target2cam: Array
    cam2gripper: Array
    camera_matrix: Array
    board: Array
    image_points: Array


def pose(rotation: Array, translation: Array) -> Array:
    """(4, 4)."""
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = rotation, translation
    return T


def project(K: Array, target2cam: Array, board: Array) -> Array:
    """Pixels (V, N, 2) of the board's points."""
    in_camera = board @ target2cam[:, :3, :3].transpose(0, 2, 1) + target2cam[:, None, :3, 3]
    homogeneous = in_camera @ K.T
    return np.asarray(homogeneous[..., :2] / homogeneous[..., 2:], dtype=np.float64)


def opencv_pose(rng: np.random.Generator, turn_deg: tuple[float, float], shift: tuple[float, float]) -> Array:
    """OpenCV's generator: axis uniform in [-1, 1]^3 and not normalised, shift with random signs."""
    turn = Rotation.from_rotvec(rng.uniform(-1, 1, 3) * np.radians(rng.uniform(*turn_deg)))
    return pose(turn.as_matrix(), rng.uniform(*shift, 3) * rng.choice([-1, 1], 3))


def disturbed(rng: np.random.Generator, T: Array, noise: tuple[float, float]) -> Array:
    """Noise added to rotation vector and translation, as OpenCV does."""
    rotation = Rotation.from_matrix(T[:3, :3]).as_rotvec() + rng.normal(0, noise[0], 3)
    return pose(Rotation.from_rotvec(rotation).as_matrix(), T[:3, 3] + rng.normal(0, noise[1], 3))


def opencv_poses(rng: np.random.Generator) -> BoardSet:
    """OpenCV's own test: poses of the target are given with noise; there are no images."""
    X, target = opencv_pose(rng, (10, 50), (0.05, 0.5)), opencv_pose(rng, (5, 85), (0.5, 3.5))
    gripper = [opencv_pose(rng, (5, 45), (0.5, 1.5)) for _ in range(OPENCV_VIEWS)]
    seen = [disturbed(rng, np.linalg.inv(T @ X) @ target, OPENCV_TARGET_NOISE) for T in gripper]
    reported = np.array([disturbed(rng, T, OPENCV_ROBOT_NOISE) for T in gripper])
    return BoardSet(reported, np.array(seen), X, OPENCV_K, OPENCV_BOARD, np.zeros((OPENCV_VIEWS, 0, 2)))


def opencv_images(rng: np.random.Generator, robot: tuple[float, float] = OPENCV_ROBOT_NOISE) -> BoardSet:
    """OpenCV's test with a camera: the same poses, kept where a wide camera sees the whole board, and noisy corners."""
    while True:
        X, target = opencv_pose(rng, (10, 50), (0.05, 0.5)), opencv_pose(rng, (5, 85), (0.5, 3.5))
        gripper = [opencv_pose(rng, (5, 45), (0.5, 1.5)) for _ in range(300)]
        target2cam = np.array([np.linalg.inv(T @ X) @ target for T in gripper])
        pixels = project(OPENCV_K, target2cam, OPENCV_BOARD)
        sees = ((pixels > 0) & (pixels < OPENCV_SIZE)).all(axis=(1, 2))
        sees &= (target2cam[:, 2, 3] > 0.7) & (np.abs(target2cam[:, 2, 2]) > 0.3)
        used = np.flatnonzero(sees)[:OPENCV_VIEWS]
        if len(used) == OPENCV_VIEWS:
            break
    pixels = pixels[used] + rng.normal(0, OPENCV_PIXEL, pixels[used].shape)
    reported = np.array([disturbed(rng, gripper[view], robot) for view in used])
    return BoardSet(reported, target2cam[used], X, OPENCV_K, OPENCV_BOARD, pixels)


def koide_direction(rng: np.random.Generator, dimensions: int, count: int) -> Array:
    """Unit vectors (count, dimensions) as Koide's program draws them: uniform in [-1.5, 0.5], then normalised."""
    drawn = rng.uniform(-1.5, 0.5, (count, dimensions))
    return np.asarray(drawn / np.linalg.norm(drawn, axis=1, keepdims=True))


def koide_set(rng: np.random.Generator, pixel: float, translation: float, rotation_deg: float) -> BoardSet:
    """Koide & Menegatti 2019: a 7 x 5 board seen from a grid of 3 x 3 x 2 places, the optical axis through its middle.

    Noise: `pixel` px and `translation` m along random directions, `rotation_deg` about random axes.
    """
    turn = Rotation.from_rotvec(np.radians(rng.normal(0, 90)) * koide_direction(rng, 3, 1)[0]).as_matrix()
    hand2eye = pose(turn, rng.normal(0, 0.3) * koide_direction(rng, 3, 1)[0])
    target = pose(np.eye(3), np.array([1.0, 0, 0]))
    places = [(1 + 0.5 * x, 0.5 * y, 0.75 + 0.25 * z) for z in range(2) for y in (-1, 0, 1) for x in (-1, 0, 1)]
    reported, target2cam = [], []
    for place in places:
        eye2world = pose(_looking_at(target[:3, 3] - place), np.array(place))
        shift = rng.normal(0, translation) * koide_direction(rng, 3, 1)[0]
        spin = Rotation.from_rotvec(np.radians(rng.normal(0, rotation_deg)) * koide_direction(rng, 3, 1)[0])
        world2hand = np.linalg.inv(eye2world @ hand2eye)
        reported.append(np.linalg.inv(pose(spin.as_matrix(), shift) @ world2hand))
        target2cam.append(np.linalg.inv(eye2world) @ target)
    poses = np.array(target2cam)
    pixels = project(KOIDE_K, poses, KOIDE_BOARD)
    away = koide_direction(rng, 2, pixels[..., 0].size).reshape(pixels.shape)
    pixels += away * rng.normal(0, pixel, (*pixels.shape[:-1], 1))
    cam2gripper = np.asarray(np.linalg.inv(hand2eye), dtype=np.float64)
    return BoardSet(np.array(reported), poses, cam2gripper, KOIDE_K, KOIDE_BOARD, pixels)


def _looking_at(direction: Array) -> Array:
    """Rotation whose z axis is `direction`: the shortest turn from looking straight down, x backwards."""
    down = np.diag([-1.0, 1, -1])
    wanted = direction / np.linalg.norm(direction)
    axis = np.cross(down[:, 2], wanted)
    angle = np.arctan2(np.linalg.norm(axis), down[:, 2] @ wanted)
    length = np.linalg.norm(axis)
    return np.asarray(Rotation.from_rotvec(angle * axis / length if length else axis).as_matrix() @ down)


def visp_set() -> BoardSet:
    """ViSP's unit test: six exact poses, one small motion after the other; here with exact images of a board."""
    X = pose(Rotation.from_rotvec(np.radians([10, -10, 25])).as_matrix(), np.array([0.1, 0.2, 0.3]))
    steps = [(0, 0, 0, np.pi / 8, 0, 0), (0, 0, 0, 0, np.pi / 8, 0), (0, 0, 0, 0, 0, np.pi / 10)]
    target2cam, gripper = [pose(np.eye(3), np.array([0, 0, 0.5]))], [np.eye(4)]
    for step in [*steps, (0.5, 0, 0, 0, 0, 0), (0, 0.8, 0, 0, 0, 0)]:
        moved = pose(Rotation.from_rotvec(step[3:]).as_matrix(), np.array(step[:3]))
        target2cam.append(np.linalg.inv(moved) @ target2cam[-1])
        gripper.append(gripper[-1] @ X @ moved @ np.linalg.inv(X))
    board = corners()
    return BoardSet(
        np.array(gripper), np.array(target2cam), X, KOIDE_K, board, project(KOIDE_K, np.array(target2cam), board)
    )
