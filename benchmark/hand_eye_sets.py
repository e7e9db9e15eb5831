# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Poses of robot and target for `hand_eye.py`: random ones as in OpenCV's own test, and bad ones."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from .protocol_sets import disturbed, opencv_pose, pose
from .scene import Array


@dataclass(frozen=True)
class PoseSet:
    """gripper2base and target2cam (V, 4, 4) as reported, true X = cam2gripper and target2base (4, 4).

    `t_shape`: in which translations are passed on.
    """

    gripper2base: Array
    target2cam: Array
    X: Array
    target: Array
    t_shape: tuple[int, int] = (3, 1)

    def disturbed(self, rng: np.random.Generator, camera: tuple[float, float], robot: tuple[float, float]) -> PoseSet:
        """Noise of the standard deviations rotation vector [rad], translation."""
        return replace(
            self,
            gripper2base=np.array([disturbed(rng, T, robot) for T in self.gripper2base]),
            target2cam=np.array([disturbed(rng, T, camera) for T in self.target2cam]),
        )


def recorded(views: PoseSet) -> tuple[list[Array], list[Array], list[Array], list[Array]]:
    """As `calibrateHandEye` takes them."""
    G, C = views.gripper2base, views.target2cam
    shape = (-1, *views.t_shape)
    return list(G[:, :3, :3]), list(G[:, :3, 3].reshape(shape)), list(C[:, :3, :3]), list(C[:, :3, 3].reshape(shape))


def exact(rng: np.random.Generator, gripper: list[Array]) -> PoseSet:
    """What the camera sees from these poses."""
    X, target = opencv_pose(rng, (10, 50), (0.05, 0.5)), opencv_pose(rng, (5, 85), (0.5, 3.5))
    return PoseSet(np.array(gripper), np.array([np.linalg.inv(T @ X) @ target for T in gripper]), X, target)


def views_of(rng: np.random.Generator, count: int, turn_deg: tuple[float, float]) -> PoseSet:
    """OpenCV's generator, with another range of angles."""
    return exact(rng, [opencv_pose(rng, turn_deg, (0.5, 1.5)) for _ in range(count)])


def _turning(rng: np.random.Generator, turns: Array) -> PoseSet:
    return exact(rng, [pose(Rotation.from_rotvec(turn).as_matrix(), rng.normal(0, 0.5, 3)) for turn in turns])


def _changed(rng: np.random.Generator, change: Callable[[Array, Array], tuple[Array, Array]]) -> PoseSet:
    good = views_of(rng, 10, (5, 45))
    gripper, target = change(good.gripper2base.copy(), good.target2cam.copy())
    return replace(good, gripper2base=gripper, target2cam=target)


def _turned(target: Array) -> Array:
    target[4, :3, :3] = Rotation.from_rotvec([1.2, 1.0, 0.7]).as_matrix() @ target[4, :3, :3]
    return target


BAD_SETS: dict[str, Callable[[np.random.Generator], PoseSet]] = {
    "nothing wrong": lambda rng: views_of(rng, 10, (5, 45)),
    "small turns (1.4 deg)": lambda rng: _turning(rng, rng.normal(0, np.radians(1.4), (10, 3))),
    "camera turned by 180 deg": lambda rng: _with_camera_turned(views_of(rng, 10, (5, 45))),
    "translations alone": lambda rng: _turning(rng, np.zeros((10, 3))),
    "turns about one axis": lambda rng: _turning(rng, np.outer(rng.uniform(-1, 1, 10), [0, 0, 1])),
    "no motion": lambda rng: _changed(rng, lambda G, C: (np.repeat(G[:1], 10, axis=0), np.repeat(C[:1], 10, axis=0))),
    "one translation off by 5 m": lambda rng: _changed(rng, lambda G, C: (G, C + _at(C, 4, 5.0))),
    "one rotation off by 98 deg": lambda rng: _changed(rng, lambda G, C: (G, _turned(C))),
    "two views swapped": lambda rng: _changed(rng, lambda G, C: (G, C[[0, 1, 5, 3, 4, 2, 6, 7, 8, 9]])),
    "images one pose late": lambda rng: _changed(rng, lambda G, C: (G, np.roll(C, 1, axis=0))),
    "robot's poses inverted": lambda rng: _changed(rng, lambda G, C: (np.linalg.inv(G), C)),
    "robot in mm, camera in m": lambda rng: _changed(rng, lambda G, C: (_scaled(G, 1000), C)),
    "translations 1 x 3": lambda rng: replace(views_of(rng, 10, (5, 45)), t_shape=(1, 3)),
}


def _at(C: Array, view: int, shift: float) -> Array:
    change = np.zeros_like(C)
    change[view, 0, 3] = shift
    return change


def _scaled(G: Array, factor: float) -> Array:
    G[:, :3, 3] *= factor
    return G


def _with_camera_turned(views: PoseSet) -> PoseSet:
    X = pose(np.diag([1.0, -1.0, -1.0]), views.X[:3, 3])
    seen = np.array([np.linalg.inv(T @ X) @ views.target for T in views.gripper2base])
    return replace(views, target2cam=seen, X=X)


def bad_set(kind: str, rng: np.random.Generator) -> PoseSet:
    """One of BAD_SETS."""
    return BAD_SETS[kind](rng)
