# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Recordings with nothing arranged: any mounting of the camera, any motion that may suffice. Metres.

Each set calls one function and returns its error beside its covariance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation
from scipy.stats import norm

import cv_active_handeye as cah

from .scene import FAR, HEIGHT, NEAR, WIDTH, Array

MIDDLE = 0.5 * (NEAR + FAR)
POSE_NOISE = 1e-3
"""Of the target's poses, rad and m, for one pixel of image noise."""


@dataclass(frozen=True)
class Found:
    """Truth - estimate and its covariance, of any rank."""

    error: Array
    covariance: Array

    def standardised(self) -> Array:
        """The components that are estimated, in standard deviations."""
        sigma = np.sqrt(np.diag(self.covariance))
        return np.asarray(self.error[sigma > 0] / sigma[sigma > 0])


def any_rotation(rng: np.random.Generator) -> Array:
    """Uniformly distributed."""
    return np.asarray(Rotation.random(random_state=rng).as_matrix())


def turned_by(R: Array, estimate: Array) -> Array:
    """Rotation error vector in the gripper frame: R = exp(error) estimate."""
    return np.asarray(Rotation.from_matrix(R @ estimate.T).as_rotvec())


class Cell:
    """A camera, how it sits on the flange, and where the base is."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.rng = rng
        f = rng.uniform(500, 2000)
        self.K = np.array([[f, 0, WIDTH / 2], [0, f, HEIGHT / 2], [0, 0, 1]])
        self.R_cam2gripper, self.t_cam2gripper = any_rotation(rng), rng.normal(0, 0.1, 3)
        self.scene2base, self.origin = any_rotation(rng), rng.normal(0, 0.5, 3)

    def gripper(self, cam2scene: Array, position: Array) -> tuple[Array, Array]:
        """R_gripper2base, t_gripper2base for a camera in the scene's frame."""
        R = self.scene2base @ cam2scene @ self.R_cam2gripper.T
        return R, self.origin + self.scene2base @ position - R @ self.t_cam2gripper

    def points(self, count: int) -> Array:
        """In the frame of a camera that sees all of them."""
        z = self.rng.uniform(NEAR, FAR, count)
        half = 0.45 * HEIGHT / self.K[0, 0]
        return np.column_stack([self.rng.uniform(-half, half, (count, 2)) * z[:, None], z])

    def project(self, X: Array, noise: float) -> Array:
        """Pixels of points in the camera frame."""
        x = X @ self.K.T
        return np.asarray(x[:, :2] / x[:, 2:] + self.rng.normal(0, noise, (len(X), 2)))


@dataclass(frozen=True)
class Translations:
    """calibrateHandEyeTranslations on one group; `flatness` scales one direction of the translations."""

    method: int
    flags: int
    count: int
    flatness: float = 1.0

    def __call__(self, rng: np.random.Generator, noise: float) -> Found:
        """One set."""
        cell = Cell(rng)
        frame = any_rotation(rng)
        offsets = [np.zeros(3), *(frame @ (rng.normal(0, 0.03, 3) * (1, 1, self.flatness)) for _ in range(self.count))]
        X = cell.points(60)
        R, t = zip(*(cell.gripper(np.eye(3), offset) for offset in offsets), strict=True)
        pixels = [cell.project(X - offset, noise) for offset in offsets]
        known = cell.K if self.flags & cah.TRANSLATIONS_FIX_K else None
        _, K, R_cam2gripper, covariance = cah.calibrateHandEyeTranslations(
            R, t, pixels, known, None, method=self.method, flags=self.flags
        )
        d = cell.K - K
        off = [d[0, 0], d[1, 1], d[0, 2], d[1, 2], d[0, 1], *turned_by(cell.R_cam2gripper, R_cam2gripper)]
        return Found(np.array(off), covariance)


@dataclass(frozen=True)
class Turns:
    """calibrateHandEyeRotation with K and R_cam2gripper known."""

    count: int

    def __call__(self, rng: np.random.Generator, noise: float) -> Found:
        """One set."""
        cell = Cell(rng)
        X = cell.points(40) - (0, 0, MIDDLE)
        R, t, pixels = [], [], []
        for _ in range(self.count):
            turn = Rotation.from_rotvec(rng.normal(0, (0.2, 0.2, 0.6))).as_matrix()
            position = turn @ (0, 0, -MIDDLE) + rng.normal(0, 0.03, 3)
            pose = cell.gripper(turn, position)
            R.append(pose[0])
            t.append(pose[1])
            pixels.append(cell.project((X - position) @ turn, noise))
        _, found, covariance = cah.calibrateHandEyeRotation(R, t, pixels, cell.K, None, cell.R_cam2gripper)
        return Found(cell.t_cam2gripper - found[:, 0], covariance)


@dataclass(frozen=True)
class Expansion:
    """estimateFOE; `scale` of the three components of the motion."""

    scale: tuple[float, float, float]

    def __call__(self, rng: np.random.Generator, noise: float) -> Found:
        """One set."""
        cell = Cell(rng)
        direction = rng.normal(0, self.scale)
        moved = 0.05 * direction / np.linalg.norm(direction)
        X = cell.points(100)
        x1, x2 = cell.project(X, noise), cell.project(X - moved, noise)
        _, foe, _, covariance = cah.estimateFOE(x1, x2)
        truth = _unit(cell.K @ moved)
        across = np.linalg.svd(truth[:, None])[0][:, 1:]  # along the unit sphere
        return Found((truth - foe[:, 0]) @ across, across.T @ covariance @ across)


@dataclass(frozen=True)
class Stripes:
    """calibrateLightPlane: groups of views, all on the same planes of the scene."""

    groups: int
    views: int
    surfaces: int

    def __call__(self, rng: np.random.Generator, noise: float) -> Found:
        """One set."""
        cell = Cell(rng)
        light = _light_plane(rng)
        normals = [_unit(np.append(rng.uniform(-0.8, 0.8, 2), -1)) for _ in range(self.surfaces)]
        offsets = rng.uniform(-0.03, 0.03, self.surfaces)
        R, t, pixels, views, ids = [], [], [], [], []
        for group in range(self.groups):
            turn = Rotation.from_rotvec(rng.normal(0, 0.25, 3) * (group > 0)).as_matrix()
            for view in range(self.views):
                position = turn @ (0, 0, -MIDDLE) + rng.normal(0, 0.03, 3) * (view > 0)
                pose = cell.gripper(turn, position)
                R.append(pose[0])
                t.append(pose[1])
                for surface, normal in enumerate(normals):
                    stripe = _stripe(light, turn.T @ normal, float(offsets[surface] - normal @ position))
                    inside = cell.project(stripe, noise)
                    inside = inside[((inside > 0) & (inside < (WIDTH, HEIGHT))).all(axis=1)]
                    if len(inside) >= 8:
                        pixels.append(inside)
                        views.append(len(R) - 1)
                        ids.append(surface)
        known = cell.K, None, cell.R_cam2gripper
        _, found, covariance = cah.calibrateLightPlane(R, t, pixels, views, ids, *known)
        return Found(light - found[:, 0], covariance)


def _unit(v: Array) -> Array:
    return np.asarray(v / np.linalg.norm(v))


def _light_plane(rng: np.random.Generator) -> Array:
    """n, d of a laser that crosses the optical axis near the scene at 10 to 40 degrees."""
    around, across = rng.uniform(0, 2 * np.pi), np.radians(rng.uniform(10, 40))
    n = np.array([np.cos(around) * np.cos(across), np.sin(around) * np.cos(across), np.sin(across)])
    return np.append(n, n[2] * MIDDLE + rng.uniform(-0.03, 0.03))


def _stripe(light: Array, normal: Array, offset: float) -> Array:
    """Points (60, 3) in the camera frame where the light meets the plane normal.X = offset; none when parallel."""
    along = np.cross(normal, light[:3])
    if np.linalg.norm(along) < 0.15:
        return np.zeros((0, 3))
    along = _unit(along)
    near = np.linalg.solve(np.array([normal, light[:3], along]), [offset, light[3], along[2] * MIDDLE])
    return np.asarray(near + np.linspace(-0.12, 0.12, 60)[:, None] * along)


@dataclass(frozen=True)
class TargetPoses:
    """calibrateHandEyeExtended; `turn`: standard deviation of the components of the robot's rotation vectors.

    The noise levels are estimated from a few poses, so the error is compared with the interval of Student's t.
    """

    count: int
    turn: float

    def __call__(self, rng: np.random.Generator, noise: float) -> Found:
        """One set."""
        cell = Cell(rng)
        target, position = any_rotation(rng), rng.normal(0, 1, 3)
        poses: list[tuple[Array, Array, Array, Array]] = []
        for _ in range(self.count):
            R, t = Rotation.from_rotvec(rng.normal(0, self.turn, 3)).as_matrix(), rng.normal(0, 0.5, 3)
            camera = R @ cell.R_cam2gripper
            jitter = Rotation.from_rotvec(rng.normal(0, POSE_NOISE * noise, 3)).as_matrix()
            seen = camera.T @ (position - R @ cell.t_cam2gripper - t) + rng.normal(0, POSE_NOISE * noise, 3)
            poses.append((R, t, camera.T @ target @ jitter, seen))
        _, R_cam2gripper, t_cam2gripper, summary = cah.calibrateHandEyeExtended(*zip(*poses, strict=True))
        off = [*turned_by(cell.R_cam2gripper, R_cam2gripper), *(cell.t_cam2gripper - t_cam2gripper[:, 0])]
        half = 0.5 * (summary.intervals95[:, 1] - summary.intervals95[:, 0])
        return Found(np.array(off), np.diag((half / norm.ppf(0.975)) ** 2))
