# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Cramér-Rao bounds: what no unbiased estimator can be better than, from the Fisher information of the image points.

All scene points are unknown. The derivatives are complex steps of the projection (exact to rounding), and share nothing
with the C++ code. Parameters: fx, fy, cx, cy, skew, rotation error vector (3), t_cam2gripper (3).
"""

from __future__ import annotations

import numpy as np

from .scene import Array, Scene

PARAMETERS = 11
CAMERA = slice(0, 8)
TRANSLATION = slice(8, 11)


def jacobians(scene: Scene) -> tuple[Array, Array]:
    """Derivatives of the pixels by the parameters (V, N, 2, 11) and by each point's own coordinates (V, N, 2, 3)."""
    step = 1e-30
    parameters = scene.parameters().astype(complex)
    by_parameters = np.stack(
        [scene.project(parameters + 1j * step * unit, scene.points).imag / step for unit in np.eye(PARAMETERS)], axis=-1
    )
    by_points = np.stack(
        [scene.project(parameters, scene.points + 1j * step * unit).imag / step for unit in np.eye(3)], axis=-1
    )
    return by_parameters, by_points


def information(scene: Scene, sigma: float, tracks: list[list[int]]) -> Array:
    """Fisher information (11, 11) of the parameters with the points eliminated.

    `tracks`: lists of views within which a point counts as one unknown. One list with all views: the full problem. One
    list per group of equal orientation: the problem of the translations alone, which does not know that the groups see
    the same points (t_cam2gripper has no information there).
    """
    J, B = jacobians(scene)
    total = np.zeros((PARAMETERS, PARAMETERS))
    for views in tracks:
        seen = scene.visible[views]
        used = seen.sum(axis=0) >= 2
        weight = seen[:, used, None, None]
        Jg, Bg = J[views][:, used] * weight, B[views][:, used] * weight
        points = np.einsum("vnij,vnik->njk", Bg, Bg)
        mixed = np.einsum("vnij,vnik->njk", Bg, Jg)
        total += np.einsum("vnij,vnik->jk", Jg, Jg)
        total -= np.einsum("njk,njl->kl", mixed, np.linalg.solve(points, mixed))
    result: Array = total / sigma**2
    return result


def translations_bound(scene: Scene, sigma: float, free: Array) -> Array:
    """Covariance (8, 8) of K and R from the translations alone; `free` (8, k) are the directions that are not fixed."""
    S = information(scene, sigma, scene.groups)[CAMERA, CAMERA]
    return np.asarray(free @ np.linalg.inv(free.T @ S @ free) @ free.T)


def rotation_bounds(scene: Scene, sigma: float, camera_covariance: Array) -> tuple[Array, Array]:
    """Covariances (3, 3) of t_cam2gripper: for K and R known, and for K and R estimated from the translations.

    The second one adds what the error of K and R (`camera_covariance`, 8 x 8) does to t. The two parts are not
    correlated: within one group a change of t is a change of all points, which the translations do not see.
    """
    S = information(scene, sigma, [list(range(len(scene.R_gripper2base)))])
    known = np.asarray(np.linalg.inv(S[TRANSLATION, TRANSLATION]), dtype=np.float64)
    influence = known @ S[TRANSLATION, CAMERA]
    return known, np.asarray(known + influence @ camera_covariance @ influence.T)


def joint_bound(scene: Scene, sigma: float, free: Array) -> Array:
    """Covariance (11, 11) when everything is estimated at once from all views: what a refinement can reach."""
    S = information(scene, sigma, [list(range(len(scene.R_gripper2base)))])
    basis = np.zeros((PARAMETERS, free.shape[1] + 3))
    basis[CAMERA, : free.shape[1]] = free
    basis[TRANSLATION, free.shape[1] :] = np.eye(3)
    return np.asarray(basis @ np.linalg.inv(basis.T @ S @ basis) @ basis.T)
