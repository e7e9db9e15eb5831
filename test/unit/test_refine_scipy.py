# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""refineHandEye against scipy.optimize.least_squares on the same problem: same optimum, same covariance.

The model is written out here once more: all unknowns at once, no point eliminated, numerical derivatives.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.sparse import csr_array
from scipy.spatial.transform import Rotation

import cv_active_handeye as cah
from benchmark.stops import STOPS_12, active_stops
from benchmark.stripes import random_stripes
from benchmark.world import NAMES, Noise, Recording, World, random_world

Array = NDArray[np.float64]

NOISE = Noise(0.1, 0.03, 0.01, 0.05)
CAMERA, HAND, POSES = slice(0, 7), slice(7, 13), 16
"""Unknowns: fx, fy, cx, cy, k1, k2, k3; error of R, t of the hand; (n, d); then poses, surfaces, the object, points."""
ORDER = ["fx", "fy", "cx", "cy", "k1", "k2", "k3", "rx", "ry", "rz", "tx", "ty", "tz"]
AT = [NAMES.index(name) for name in ORDER]


@dataclass(frozen=True)
class Model:
    """Measurements and where the unknowns are counted from. `known`: the points' own coordinates, if they are known."""

    seen: Recording
    visible: NDArray[np.bool_]
    focal: Array
    """fx, fy: how large a pixel is for the stripes."""
    R_cam2gripper: Array
    light: Array | None
    sigmas: Array
    known: Array | None = None
    huber: Callable[[Array], Array] = lambda errors: errors

    @property
    def views(self) -> int:
        return len(self.seen.R_gripper2base)

    @property
    def surfaces(self) -> int:
        return len(set(self.seen.surface_ids))

    @property
    def first_point(self) -> int:
        return POSES + 6 * self.views + 3 * self.surfaces

    def cameras(self, u: Array) -> tuple[Array, Array]:
        """R_cam2base and centres."""
        corrections = u[POSES : POSES + 6 * self.views].reshape(-1, 6)
        R = Rotation.from_rotvec(corrections[:, :3]).as_matrix() @ self.seen.R_gripper2base
        X = Rotation.from_rotvec(u[7:10]).as_matrix() @ self.R_cam2gripper
        return R @ X, np.einsum("vij,j->vi", R, u[10:13]) + self.seen.t_gripper2base + corrections[:, 3:]

    def point_errors(self, u: Array) -> Array:
        """(M, 2), in sigmas."""
        R, centre = self.cameras(u)
        points = u[self.first_point :]
        if self.known is None:
            X = points.reshape(-1, 3)
        else:
            X = Rotation.from_rotvec(points[:3]).apply(self.known) + points[3:]
        Y = np.einsum("vij,vnj->vni", R.transpose(0, 2, 1), X[None] - centre[:, None])
        ray = Y[..., :2] / Y[..., 2:]
        r2 = (ray**2).sum(axis=-1, keepdims=True)
        image = u[:2] * ray * (1 + r2 * (u[4] + r2 * (u[5] + r2 * u[6]))) + u[2:4]
        errors = (image - self.seen.image_points)[self.visible] / self.sigmas[self.visible, None]
        return self.huber(np.asarray(errors / NOISE.point_px))

    def light_plane(self, u: Array) -> Array:
        """n, d: n moves across its start."""
        assert self.light is not None
        across = np.linalg.svd(self.light[None, :3])[2][1:]
        n = self.light[:3] + u[13:15] @ across
        return np.append(n / np.linalg.norm(n), u[15])

    def stripe_errors(self, u: Array) -> Array:
        """(2 S), in sigmas: distance of two image points from each stripe predicted, in pixels as large as K says."""
        if self.light is None:
            return np.zeros(0)
        R, centre = self.cameras(u)
        light = self.light_plane(u)
        views = np.repeat(self.seen.stripe_views, 2)
        a, b, c = u[POSES + 6 * self.views : self.first_point].reshape(-1, 3)[np.repeat(self.seen.surface_ids, 2)].T
        w = np.stack([-a, -b, np.ones_like(a)], axis=1)  # z = a x + b y + c
        e = c - (w * centre[views]).sum(axis=1)
        line = e[:, None] * light[:3] - light[3] * np.einsum("mij,mi->mj", R[views], w)
        pixels = np.concatenate(self.seen.stripe_points)
        target = (pixels - u[2:4]) / u[:2]
        ray = target.copy()
        for _ in range(30):
            r2 = (ray**2).sum(axis=1, keepdims=True)
            ray = target / (1 + r2 * (u[4] + r2 * (u[5] + r2 * u[6])))
        distance = (line[:, :2] * ray).sum(axis=1) + line[:, 2]
        per_pixel = line[:, :2] / self.focal
        return np.asarray(distance / np.linalg.norm(per_pixel, axis=1) / NOISE.stripe_px)

    def residuals(self, u: Array) -> Array:
        corrections = u[POSES : POSES + 6 * self.views].reshape(-1, 6)
        priors = corrections / np.repeat([NOISE.rotation, NOISE.translation], 3)
        return np.concatenate([self.point_errors(u).ravel(), self.stripe_errors(u), priors.ravel()])

    def sparsity(self, size: int) -> csr_array:
        """Found by trying: which residual hangs on which unknown."""
        view, point = np.nonzero(self.visible)
        points = np.zeros((len(view), 2, size), np.int8)
        points[..., :13] = 1
        rows = np.arange(len(view))
        for k in range(6):
            points[rows, :, POSES + 6 * view + k] = 1
        if self.known is None:
            for k in range(3):
                points[rows, :, self.first_point + 3 * point + k] = 1
        else:
            points[..., self.first_point :] = 1
        stripes = np.zeros((2 * len(self.seen.stripe_points), size), np.int8)
        stripes[:, :POSES] = 1
        for i, (v, s) in enumerate(zip(self.seen.stripe_views, self.seen.surface_ids, strict=True)):
            stripes[2 * i : 2 * i + 2, POSES + 6 * v : POSES + 6 * v + 6] = 1
            stripes[2 * i : 2 * i + 2, POSES + 6 * self.views + 3 * s :][:, :3] = 1
        priors = np.eye(size, dtype=np.int8)[POSES : POSES + 6 * self.views]
        return csr_array(np.concatenate([points.reshape(-1, size), stripes, priors]))

    def solve(self, start: Array, free: list[int]) -> tuple[Array, Array]:
        """The optimum, and the covariance of all unknowns; those below POSES that are not in `free` stay."""
        used = np.array([*free, *range(POSES, len(start))])

        def at(x: Array) -> Array:
            u = start.copy()
            u[used] = x
            return self.residuals(u)

        options = {"atol": 1e-14, "btol": 1e-14, "maxiter": 10000, "regularize": False}
        found = least_squares(
            at, start[used], jac="3-point", jac_sparsity=self.sparsity(len(start))[:, used], x_scale="jac",
            ftol=1e-14, xtol=1e-14, gtol=1e-12, tr_options=options,
        )  # fmt: skip
        J = csr_array(cast(csr_array, found.jac)).toarray()
        scale = 1 / np.linalg.norm(J, axis=0)
        best = start.copy()
        best[used] = found.x - scale * np.linalg.lstsq(J * scale, found.fun, rcond=None)[0]
        covariance = np.zeros((len(start), len(start)))
        covariance[np.ix_(used, used)] = np.linalg.inv((J * scale).T @ (J * scale)) * np.outer(scale, scale)
        return best, covariance


def settings(lens: int, huber: float = 1e6) -> cah.RefineParams:
    """All noise levels given."""
    params = cah.RefineParams()
    params.lensModel, params.huberThreshold, params.rejectThreshold = lens, huber, 1e6
    params.pointSigma, params.stripeSigma = NOISE.point_px, NOISE.stripe_px
    params.robotTranslationSigma, params.robotRotationSigma = NOISE.translation, NOISE.rotation
    return params


LENSES = {cah.LENS_FIXED: 0, cah.LENS_K1: 1, cah.LENS_K1_K2: 2}
"""How many coefficients they estimate."""


def world(seed: int, lens: int = cah.LENS_K1_K2, stripes: bool = False) -> tuple[World, Recording]:
    """Forty points at 12 stops; two image points for each stripe segment."""
    rng = np.random.default_rng(seed)
    laser = random_stripes(rng, 4, 2) if stripes else None
    distortion = np.array([-0.12, 0.08, 0, 0, 0]) * (np.arange(5) < LENSES[lens])
    made = random_world(rng, active_stops(rng, STOPS_12), 40, distortion, laser)
    return made, made.record(rng, NOISE)


@dataclass(frozen=True)
class Answer:
    """Of refineHandEye: the calibration, and the same as unknowns of the model (without poses and what follows)."""

    R_cam2gripper: Array
    light: Array | None
    unknowns: Array
    summary: cah.RefineSummary


def refine(made: World, seen: Recording, lens: int, board: Array | None, sigmas: Array | None, huber: float) -> Answer:
    """With all noise levels given, from the truth without distortion."""
    stripes: dict[str, Any] = {}
    plane = None
    if made.stripes is not None:
        plane = made.stripes.light_plane
        stripes = {"stripePoints": seen.stripe_points, "stripeViews": seen.stripe_views}
        stripes |= {"surfaceIds": seen.surface_ids, "stripeSigmas": np.ones(len(seen.stripe_points))}
    motion = seen.R_gripper2base, seen.t_gripper2base
    hand = made.R_cam2gripper, made.t_cam2gripper
    _, K, D, R, t, light, summary = cah.refineHandEye(
        *motion, seen.image_points, made.camera_matrix, np.zeros(5), *hand, plane,
        objectPoints=board, pointSigmas=sigmas, params=settings(lens, huber), **stripes,
    )  # fmt: skip
    assert summary.usable, summary.message
    assert not summary.rejectedViews
    assert not summary.rejectedObservations.any()
    found = [K[0, 0], K[1, 1], K[0, 2], K[1, 2], *D[[0, 1, 4], 0], 0, 0, 0, *t[:, 0], 0, 0]
    if light is None:
        return Answer(R, None, np.array([*found, 0]), summary)
    return Answer(R, light[:, 0], np.array([*found, light[3, 0]]), summary)


def compare(
    made: World,
    seen: Recording,
    lens: int = cah.LENS_K1_K2,
    board: Array | None = None,
    sigmas: Array | None = None,
    huber: float = 1e6,
) -> None:
    """The optimum agrees to 1e-6 of a standard deviation (1e-3 where Huber's loss clips), the covariance to 1e-3."""
    ours = refine(made, seen, lens, board, sigmas, huber)
    weights = np.ones(made.visible.shape) if sigmas is None else sigmas
    clip = modified(ours.summary.residuals, made.visible, weights, huber)
    model = Model(seen, made.visible, ours.unknowns[:2], ours.R_cam2gripper, ours.light, weights, board, clip)
    free = [*range(4 + LENSES[lens]), *range(7, 13), *([] if ours.light is None else [13, 14, 15])]
    best, covariance = model.solve(start(made, seen, ours, board), free)
    near = 1e-6 if huber > 100 else 1e-3
    deviations = np.sqrt(np.diag(covariance))
    np.testing.assert_allclose((best[free] - ours.unknowns[free]) / deviations[free], 0, atol=near)
    poses = slice(POSES, POSES + 6 * model.views)
    corrections = ours.summary.poseCorrections.ravel()
    np.testing.assert_allclose((best[poses] - corrections) / deviations[poses], 0, atol=10 * near)

    spread = np.zeros((20, POSES))
    spread[AT, np.arange(13)] = 1
    if ours.light is not None:
        spread[16:19, 13:15], spread[19, 15] = np.linalg.svd(ours.light[None, :3])[2][1:].T, 1
    expected = spread @ covariance[:POSES, :POSES] @ spread.T
    unit = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    assert np.count_nonzero(unit.diagonal()) == len(free) + (ours.light is not None)
    np.testing.assert_allclose(ours.summary.covariance / (unit + 1e-300), expected / (unit + 1e-300), atol=1e-3)


def start(made: World, seen: Recording, ours: Answer, board: Array | None) -> Array:
    """Unknowns a little beside the truth; the rotation is counted from that of `ours`."""
    K, aside = made.camera_matrix, Rotation.from_rotvec([1e-3, -1e-3, 2e-3]).as_matrix()
    turn = Rotation.from_matrix(aside @ made.R_cam2gripper @ ours.R_cam2gripper.T).as_rotvec()
    camera = [K[0, 0] + 4, K[1, 1] - 4, K[0, 2] + 2, K[1, 2] - 2, 0, 0, 0]
    planes = np.zeros((0, 4)) if made.stripes is None else made.stripes.surfaces
    surfaces = [(-n[0] / n[2], -n[1] / n[2], n[3] / n[2]) for n in planes]
    poses = np.zeros(6 * len(seen.R_gripper2base))
    shared = [*camera, *turn, *made.t_cam2gripper + 1e-3, 0, 0, 1.01 * ours.unknowns[15]]
    return np.concatenate([shared, poses, np.ravel(surfaces), np.ravel(made.points if board is None else np.zeros(6))])


def modified(errors: Array, visible: NDArray[np.bool_], sigmas: Array, limit: float) -> Callable[[Array], Array]:
    """Vectors as long as the root of Huber's loss over the mean slope that it has at these errors."""
    lengths = np.linalg.norm(errors.reshape(*visible.shape, 2)[visible], axis=1) / sigmas[visible] / NOISE.point_px
    slope = float(np.mean(np.where(lengths <= limit, 1, 0.5 * limit / lengths)))

    def scaled(values: Array) -> Array:
        r = np.linalg.norm(values, axis=1, keepdims=True)
        length = np.where(r <= limit, r, np.sqrt(limit * np.maximum(2 * r - limit, 0)))
        return np.asarray(values * length / np.maximum(r, 1e-300) / np.sqrt(slope))

    return scaled


@pytest.mark.parametrize("lens", LENSES)
def test_points(lens: int) -> None:
    compare(*world(1, lens), lens)


def test_points_and_stripes() -> None:
    compare(*world(2, stripes=True))


def test_points_of_unequal_quality() -> None:
    made, seen = world(3)
    compare(made, seen, sigmas=np.random.default_rng(3).uniform(0.5, 2, made.visible.shape))


def test_a_board() -> None:
    made, seen = world(4)
    compare(made, seen, board=made.points)
