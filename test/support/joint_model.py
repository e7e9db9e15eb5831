# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The problem of refineHandEye for scipy.optimize.least_squares: all unknowns at once, numerical derivatives.

Nothing is shared with C++: no point is eliminated, surfaces are z = a x + b y + c, poses are rotation vectors.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.sparse import csr_array
from scipy.spatial.transform import Rotation

from benchmark.world import Noise, Recording

Array = NDArray[np.float64]

NOISE = Noise(0.1, 0.03, 0.01, 0.05)
POSES = 16
"""Unknowns: fx, fy, cx, cy, k1, k2, k3, error of R, t, two tangents of n, d; then poses, surfaces, points."""


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
    weights: Array | None = None
    """Of the image points used (M), on their squares."""

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
        return np.asarray(errors / NOISE.point_px)

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
        points = self.point_errors(u)
        if self.weights is not None:
            points *= np.sqrt(self.weights)[:, None]
        return np.concatenate([points.ravel(), self.stripe_errors(u), priors.ravel()])

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

    def used(self, size: int, free: list[int]) -> NDArray[np.int64]:
        """Unknowns that are estimated: those below POSES only where `free`."""
        return np.array([*free, *range(POSES, size)])

    def solve(self, start: Array, free: list[int]) -> Array:
        """The unknowns of the least sum of squares."""
        used, best = self.used(len(start), free), start.copy()

        def at(x: Array) -> Array:
            u = best.copy()
            u[used] = x
            return self.residuals(u)

        options = {"atol": 1e-14, "btol": 1e-14, "conlim": 1e16, "maxiter": 10000, "regularize": False}
        sparsity = self.sparsity(len(start))[:, used]
        best[used] = least_squares(
            at, start[used], jac="3-point", jac_sparsity=sparsity, x_scale="jac",
            ftol=1e-14, xtol=1e-14, gtol=1e-12, tr_options=options,
        ).x  # fmt: skip
        J, scale = self.derivatives(best, used)
        best[used] -= scale * np.linalg.lstsq(J, self.residuals(best), rcond=None)[0]
        return best

    def derivatives(self, u: Array, used: NDArray[np.int64]) -> tuple[Array, Array]:
        """By central differences: the columns in units of their lengths, and those units."""
        columns = []
        for i in used:
            h = 1e-2 if i < 4 else 1e-3 if i < 7 else 1e-5
            step = h * np.eye(1, len(u), i)[0]
            columns.append((self.residuals(u + step) - self.residuals(u - step)) / (2 * h))
        J = np.stack(columns, axis=1)
        scale = 1 / np.linalg.norm(J, axis=0)
        return J * scale, scale

    def covariance(self, u: Array, free: list[int]) -> Array:
        """Of all unknowns, zero where they are not estimated. Of the model without weights (Huber)."""
        used = self.used(len(u), free)
        J, scale = replace(self, weights=None).derivatives(u, used)
        covariance = np.zeros((len(u), len(u)))
        covariance[np.ix_(used, used)] = np.linalg.inv(J.T @ J) * np.outer(scale, scale)
        return covariance

    def solve_huber(self, start: Array, free: list[int], limit: float) -> Array:
        """The least sum of Huber's losses over their mean slope, by weights that settle."""
        best, model = start, self
        for _ in range(15):
            best = model.solve(best, free)
            lengths = np.linalg.norm(self.point_errors(best), axis=1)
            clipped = lengths > limit
            assert clipped.any()
            pulls = np.where(clipped, limit / lengths, 1)
            model = replace(self, weights=pulls / np.mean(np.where(clipped, 0.5 * pulls, 1)))
        return best
