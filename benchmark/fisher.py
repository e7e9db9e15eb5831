# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The Cramér-Rao bound of one solution for everything: camera, lens, hand-eye transform, light plane, surfaces, points
and the robot's true poses, whose errors have a known standard deviation. Or of a board, whose pose is not known.

Derivatives are complex steps of the projection (exact to rounding); no code is shared with C++.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .scene import Array
from .world import NAMES, Noise, Recording, World

STEP = 1e-30
SHARED = 16
"""Parameters of the points; the light plane's come after them."""


def bound(world: World, noise: Noise, free: Sequence[str]) -> Array:
    """Covariance (20, 20) of NAMES that no unbiased estimator can undercut; zero where not in `free`.

    `free` names what is estimated of the camera, the lens and the hand-eye transform; the light plane always is.
    """
    return _solve(world, noise, free, None)[0]


def linear_solution(world: World, noise: Noise, free: Sequence[str], recording: Recording) -> tuple[Array, Array]:
    """The bound (20, 20), and an error (20), true - estimated, that reaches it: the one of the linearised problem.

    It needs the truth and the very noise of the recording. Over many recordings its RMS is that of the bound; beside
    it, what another estimator loses shows without the scatter that they have in common.
    """
    return _solve(world, noise, free, recording)


def _solve(world: World, noise: Noise, free: Sequence[str], recording: Recording | None) -> tuple[Array, Array]:
    V = len(world.R_gripper2base)
    S = 0 if world.stripes is None else len(world.stripes.surfaces)
    poses = SHARED + (3 + 3 * S if S else 0)
    total = np.zeros((poses + 6 * V + 1, poses + 6 * V + 1))
    shared = np.r_[0:SHARED, poses : len(total)]
    total[np.ix_(shared, shared)] = _points(world, recording) / noise.point_px**2
    if S:
        total += _stripes(world, recording) / noise.stripe_px**2
    used = np.array([name in free for name in NAMES[:SHARED]] + [True] * (poses - SHARED) + [False] * (6 * V + 1))
    corrections = np.zeros((V, 6)) if recording is None else recording.corrections()
    for first, sigma in ((0, noise.rotation), (3, noise.translation)):
        rows = poses + (np.arange(V)[:, None] * 6 + first + np.arange(3)).ravel()
        if sigma > 0:
            total[rows, rows] += 1 / sigma**2
            total[rows, -1] -= corrections[:, first : first + 3].ravel() / sigma**2
            used[rows] = True
    covariance = np.zeros_like(total)
    covariance[np.ix_(used, used)] = _inverse(total[np.ix_(used, used)])
    spread = np.zeros((len(NAMES), len(total)))
    spread[:SHARED, :SHARED] = np.eye(SHARED)
    if world.stripes is not None:
        spread[SHARED:, SHARED : SHARED + 3] = plane_tangent(world.stripes.light_plane)
    return np.asarray(spread @ covariance @ spread.T), np.asarray(-spread @ (covariance @ total[:, -1]))


def _inverse(information: Array) -> Array:
    """Inverse of a positive definite matrix of very different units."""
    scale = 1 / np.sqrt(np.diag(information))
    return np.asarray(np.linalg.inv(information * np.outer(scale, scale)) * np.outer(scale, scale))


def _slopes(stepped: Sequence[NDArray[Any]]) -> Array:
    """Derivatives, in a last axis, from values at complex steps."""
    return np.asarray(np.stack(stepped, axis=-1).imag / STEP)


def _pose_steps(world: World) -> list[tuple[Array, Array]]:
    """True poses (complex) of all views with one component stepped: rotation x, y, z, translation x, y, z."""
    steps = []
    for k in range(6):
        w = np.zeros(6, dtype=complex)
        w[k] = 1j * STEP
        turn = np.array([[1, -w[2], w[1]], [w[2], 1, -w[0]], [-w[1], w[0], 1]])
        steps.append((turn @ world.R_gripper2base, world.t_gripper2base + w[3:]))
    return steps


def _points(world: World, recording: Recording | None) -> Array:
    """Information (16 + 6 V + 1) of the image points at unit noise, points or the pose of the board eliminated.

    The last column is J^T e, e the noise of the recording.
    """
    reported = world.R_gripper2base, world.t_gripper2base
    p = world.parameters().astype(complex)
    V = len(world.R_gripper2base)
    seen = world.visible[..., None, None]
    unit = 1j * STEP * np.eye(SHARED)
    J = _slopes([world.project(p + unit[k], *reported, world.points) for k in range(SHARED)]) * seen
    P = _slopes([world.project(p, *pose, world.points) for pose in _pose_steps(world)]) * seen
    turned = np.cross(np.eye(3), world.points[:, None]).transpose(1, 0, 2) if world.board else np.zeros((0, 1, 3))
    moves = [*turned, *np.eye(3)]
    B = _slopes([world.project(p, *reported, world.points + 1j * STEP * move) for move in moves]) * seen
    e = np.zeros((*J.shape[:3], 1)) if recording is None else recording.image_noise(world)[..., None]
    total = np.zeros((SHARED + 6 * V + 1, SHARED + 6 * V + 1))
    total[:SHARED, :SHARED] = np.einsum("vnij,vnik->jk", J, J)
    total[:SHARED, -1:] = np.einsum("vnij,vnik->jk", J, e)
    mixed = [np.einsum("vnij,vnik->njk", J, B)]
    for v in range(V):
        own = slice(SHARED + 6 * v, SHARED + 6 * v + 6)
        total[own, own] = np.einsum("nij,nik->jk", P[v], P[v])
        total[own, :SHARED] = np.einsum("nij,nik->jk", P[v], J[v])
        total[:SHARED, own] = total[own, :SHARED].T
        total[own, -1:] = np.einsum("nij,nik->jk", P[v], e[v])
        mixed.append(np.einsum("nij,nik->njk", P[v], B[v]))
    mixed.append(np.einsum("vnij,vnik->njk", e, B))
    W, H = np.concatenate(mixed, axis=1), np.einsum("vnij,vnik->njk", B, B)
    if world.board:
        W, H = W.sum(axis=0, keepdims=True), H.sum(axis=0, keepdims=True)
    half = np.linalg.solve(np.linalg.cholesky(H), W.transpose(0, 2, 1)).reshape(-1, len(total))
    return np.asarray(total - half.T @ half)


def plane_tangent(plane: Array) -> Array:
    """(4, 3): the ways in which (n, d) can change while |n| = 1."""
    normal = plane[:3] / np.linalg.norm(plane[:3])
    tangent = np.linalg.svd(normal[None])[2][1:]
    basis = np.zeros((4, 3))
    basis[:3, :2], basis[3, 2] = tangent.T, 1
    return basis


def _stripes(world: World, recording: Recording | None) -> Array:
    """Information (16 + 3 + 3 S + 6 V + 1) of the stripe points at unit noise; last column as in `_points`."""
    stripes = world.stripes
    assert stripes is not None
    reported = world.R_gripper2base, world.t_gripper2base
    p, light, surfaces = world.parameters().astype(complex), stripes.light_plane, stripes.surfaces
    V, S = len(world.R_gripper2base), len(surfaces)
    moved: list[tuple[NDArray[Any], NDArray[Any], NDArray[Any]]] = []
    moved += [(p + 1j * STEP * unit, light, surfaces) for unit in np.eye(SHARED)]
    moved += [(p, light + 1j * STEP * way, surfaces) for way in plane_tangent(light).T]
    for s in range(S):
        moved += [
            (p, light, surfaces + 1j * STEP * np.outer(np.eye(S)[s], way)) for way in plane_tangent(surfaces[s]).T
        ]
    shared = _slopes([stripes.rows(world, *case, *reported) for case in moved])
    own = _slopes([stripes.rows(world, p, light, surfaces, *pose) for pose in _pose_steps(world)])
    J = np.zeros((*own.shape[:-1], len(moved) + 6 * V + 1))
    if recording is not None:
        J[..., -1] = recording.stripe_noise(world)
    J[..., : len(moved)] = shared
    for v in range(V):
        J[v, ..., len(moved) + 6 * v : len(moved) + 6 * v + 6] = own[v]
    J = J.reshape(-1, J.shape[-1])
    return np.asarray(J.T @ J)
