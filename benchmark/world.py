# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A simulated camera, laser and robot before points and planes, and noisy recordings of them. Metres and pixels.

The robot reports the poses it was told and stands a little elsewhere: true R = exp(w) R_gripper2base; w and the error
of t_gripper2base are normal with the robot's standard deviations, in the base frame.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from .scene import CENTRE, FAR, FOCAL, HEIGHT, NEAR, WIDTH, Array
from .stripes import Stripes

NAMES = (
    *("fx", "fy", "cx", "cy", "skew", "k1", "k2", "p1", "p2", "k3"),
    *("rx", "ry", "rz", "tx", "ty", "tz", "nx", "ny", "nz", "d"),
)
"""The parameters in the order of cah.RefineSummary; rx, ry, rz: true R = exp(r) R_cam2gripper."""
CAMERA, DISTORTION, ROTATION, TRANSLATION, PLANE = (
    slice(0, 5),
    slice(5, 10),
    slice(10, 13),
    slice(13, 16),
    slice(16, 20),
)
DISTORTED = np.array([-0.12, 0.08, 0, 0, 0])
"""k1, k2 of the distorted lens."""


@dataclass(frozen=True)
class Noise:
    """Standard deviations: pixels per coordinate, stripe across, and of every coordinate of the robot's pose."""

    point_px: float = 0.1
    robot_mm: float = 0.02
    robot_deg: float = 0.005
    stripe_px: float = 0.1

    @property
    def translation(self) -> float:
        """Metres."""
        return self.robot_mm / 1000

    @property
    def rotation(self) -> float:
        """Radians."""
        return float(np.radians(self.robot_deg))

    def segment_px(self, points: int) -> float:
        """Of the two points, one RMS extent from the middle, that say as much as all `points` of a stripe segment."""
        return self.stripe_px * float(np.sqrt(2 / points))


@dataclass(frozen=True)
class Recording:
    """What the calibration gets: reported poses, image points (V, N, 2), stripe segments; and the true poses."""

    R_gripper2base: Array
    t_gripper2base: Array
    image_points: Array
    true_rotations: Array
    true_translations: Array
    stripe_points: list[Array] = field(default_factory=list)
    stripe_views: list[int] = field(default_factory=list)
    surface_ids: list[int] = field(default_factory=list)

    def corrections(self) -> Array:
        """(V, 6): true R = exp(w) R_gripper2base, true t = t_gripper2base + e; w, e."""
        turns = Rotation.from_matrix(self.true_rotations @ self.R_gripper2base.transpose(0, 2, 1)).as_rotvec()
        return np.hstack([turns, self.true_translations - self.t_gripper2base])

    def image_noise(self, world: World) -> Array:
        """(V, N, 2), 0 where not seen."""
        exact = world.project(world.parameters(), self.true_rotations, self.true_translations, world.points)
        return np.asarray(np.nan_to_num(self.image_points - exact))

    def stripe_noise(self, world: World) -> Array:
        """(V, S, M), of the rows."""
        assert world.stripes is not None
        exact = world.stripes.segments(world, self.true_rotations, self.true_translations)
        return np.asarray((np.array(self.stripe_points).reshape(exact.shape) - exact)[..., 1])


@dataclass(frozen=True)
class World:
    """Truth: camera, distortion (5), hand-eye transform, V commanded poses, N points in the base, who sees which.

    `board`: the points belong to one rigid body of known shape, whose pose in the base frame is not known.
    """

    camera_matrix: Array
    dist_coeffs: Array
    R_cam2gripper: Array
    t_cam2gripper: Array
    R_gripper2base: Array
    t_gripper2base: Array
    points: Array
    visible: NDArray[np.bool_]
    stripes: Stripes | None = None
    board: bool = False

    def parameters(self) -> Array:
        """The first 16 of NAMES; the rotation error vector is zero."""
        K = self.camera_matrix
        camera = [K[0, 0], K[1, 1], K[0, 2], K[1, 2], K[0, 1]]
        return np.array([*camera, *self.dist_coeffs, 0, 0, 0, *self.t_cam2gripper])

    def project(
        self, parameters: NDArray[Any], R_gripper2base: Array, t_gripper2base: Array, points: NDArray[Any]
    ) -> NDArray[Any]:
        """Pixels (V, N, 2) of points (N, 3) in base coordinates; analytic, so that complex steps differentiate it."""
        a, b, c, *t = parameters[10:16]
        turn = np.array([[1, -c, b], [c, 1, -a], [-b, a, 1]])
        in_gripper = (points[None] - t_gripper2base[:, None]) @ R_gripper2base
        in_camera = (in_gripper - np.array(t)) @ turn @ self.R_cam2gripper
        return pixels(parameters, in_camera[..., :2] / in_camera[..., 2:])

    def record(self, rng: np.random.Generator, noise: Noise) -> Recording:
        """One recording with Gaussian noise."""
        V = len(self.R_gripper2base)
        turns = Rotation.from_rotvec(rng.normal(0, noise.rotation, (V, 3))).as_matrix()
        R, t = turns @ self.R_gripper2base, self.t_gripper2base + rng.normal(0, noise.translation, (V, 3))
        seen = np.asarray(self.project(self.parameters(), R, t, self.points), dtype=np.float64)
        seen += rng.normal(0, noise.point_px, seen.shape)
        seen[~self.visible] = np.nan
        recording = Recording(self.R_gripper2base, self.t_gripper2base, seen, R, t)
        if self.stripes is None:
            return recording
        segments = self.stripes.segments(self, R, t)
        for segment in segments:
            segment[..., 1] += rng.normal(0, noise.stripe_px, segment.shape[:-1])
        views, surfaces = np.indices((V, len(self.stripes.surfaces))).reshape(2, -1).tolist()
        return replace(
            recording,
            stripe_points=list(segments.reshape(-1, *segments.shape[2:])),
            stripe_views=views,
            surface_ids=surfaces,
        )


def pixels(parameters: NDArray[Any], ray: NDArray[Any]) -> NDArray[Any]:
    """Pixels (..., 2) of viewing rays (x, y, 1), given as (..., 2): OpenCV's distortion, then the camera matrix."""
    fx, fy, cx, cy, skew, k1, k2, p1, p2, k3 = parameters[:10]
    x, y = ray[..., 0], ray[..., 1]
    r2 = x * x + y * y
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    u = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
    v = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
    return np.stack([fx * u + skew * v + cx, fy * v + cy], axis=-1)


def random_world(
    rng: np.random.Generator,
    motion: tuple[Array, Array],
    points: int = 60,
    dist_coeffs: Array | None = None,
    stripes: Stripes | None = None,
) -> World:
    """Camera, mounting and points at random; every point is in the image of at least three views."""
    focal = FOCAL * np.array([1, rng.uniform(0.995, 1.005)])
    K = np.array([[focal[0], 0, WIDTH / 2], [0, focal[1], HEIGHT / 2], [0, 0, 1]])
    K[:2, 2] += rng.uniform(-10, 10, 2)
    D = np.zeros(5) if dist_coeffs is None else dist_coeffs
    half = np.array([0.2, 0.2, 0.5 * (FAR - NEAR)])
    return replace(fill(rng, mount(rng, motion, K, D), points, half), stripes=stripes)


def fill(
    rng: np.random.Generator, world: World, points: int, half: Array, turn: Array | None = None, views: int = 3
) -> World:
    """Points in a box about CENTRE with half edges `half`, turned by `turn`, each in `views` views or more."""
    turn = np.eye(3) if turn is None else turn
    chosen, seen = np.zeros((0, 3)), np.zeros((len(world.R_gripper2base), 0), bool)
    while len(chosen) < points:
        drawn = CENTRE + rng.uniform(-half, half, (8 * points, 3)) @ turn.T
        visible = in_image(world, drawn)
        kept = visible.sum(axis=0) >= views
        chosen, seen = np.concatenate([chosen, drawn[kept]]), np.concatenate([seen, visible[:, kept]], axis=1)
    return replace(world, points=chosen[:points], visible=seen[:, :points])


def mount(rng: np.random.Generator, motion: tuple[Array, Array], K: Array, D: Array) -> World:
    """A world without points: the camera, mounted at random, moves as `motion` (R_cam2base, positions) says."""
    R_cam2gripper = Rotation.random(random_state=rng).as_matrix()
    t_cam2gripper = rng.uniform(-0.1, 0.1, 3)
    R_gripper2base = motion[0] @ R_cam2gripper.T
    t_gripper2base = motion[1] - R_gripper2base @ t_cam2gripper
    nothing = np.zeros((0, 3)), np.zeros((len(motion[0]), 0), bool)
    return World(K, D, R_cam2gripper, t_cam2gripper, R_gripper2base, t_gripper2base, *nothing)


def in_image(world: World, points: Array) -> NDArray[np.bool_]:
    """(V, N): which points (N, 3) are in the image of which view."""
    seen = world.project(world.parameters(), world.R_gripper2base, world.t_gripper2base, points)
    depths = (
        (points[None] - world.t_gripper2base[:, None]) @ world.R_gripper2base - world.t_cam2gripper
    ) @ world.R_cam2gripper[:, 2]
    return np.asarray(((seen >= 0) & (seen < (WIDTH, HEIGHT))).all(axis=-1) & (depths > 0))
