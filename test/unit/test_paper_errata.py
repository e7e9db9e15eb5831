# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""doc/paper/errata.md, the formulas: on exact data the paper's miss the truth, ours give it. Metres and pixels."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.linalg import rq
from scipy.spatial.transform import Rotation
from support.exact_recording import to_camera

import cv_active_handeye as cah
from benchmark.scene import Array, Scene, random_scene

SEED = 5
NOTHING_MISSING = np.random.default_rng(0), 0.0
AXIS, SECOND_AXIS = np.array([0.48, -0.64, 0.6]), np.array([0.8, 0.6, 0.0])
"""Of the pure rotations, camera frame."""


@pytest.fixture(scope="module")
def scene() -> Scene:
    """Five views of one orientation: four translations, no three coplanar."""
    return random_scene(np.random.default_rng(SEED), 30, (5,))


def with_views(scene: Scene, R: Array, t: Array) -> Scene:
    return replace(scene, R_gripper2base=R, t_gripper2base=t, visible=np.ones((len(R), len(scene.points)), bool))


def with_pure_rotation(scene: Scene, *axes: Array) -> Scene:
    """The scene, and for every axis (camera frame) one more view: the gripper of the last one turned by 15 degrees."""
    last, in_gripper = scene.R_gripper2base[-1], scene.R_cam2gripper
    turned = [last @ Rotation.from_rotvec(np.radians(15) * in_gripper @ axis).as_matrix() for axis in axes]
    R = np.concatenate([scene.R_gripper2base, turned])
    return with_views(scene, R, np.concatenate([scene.t_gripper2base, [scene.t_gripper2base[-1]] * len(axes)]))


def with_camera_moved_by(scene: Scene, c: Array) -> Scene:
    """The first view, and a second one with the camera moved by c (camera frame)."""
    R, t = scene.R_gripper2base[0], scene.t_gripper2base[0]
    return with_views(scene, np.array([R, R]), np.array([t, t + R @ scene.R_cam2gripper @ c]))


def pixels(scene: Scene) -> Array:
    return scene.observe(*NOTHING_MISSING)


def in_camera(scene: Scene, view: int) -> Array:
    R, t = scene.R_gripper2base[view], scene.t_gripper2base[view]
    return to_camera(scene.points, R, t, scene.R_cam2gripper, scene.t_cam2gripper)


def homogeneous(seen: Array) -> Array:
    return np.insert(seen, 2, 1.0, axis=1)


def unit(v: Array) -> Array:
    return np.asarray(v / np.linalg.norm(v, axis=0))


def degrees_between(a: Array, b: Array) -> float:
    a, b = unit(np.ravel(a)), unit(np.ravel(b))
    return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b)))


def rays(K: Array, e: Array | list[float]) -> Array:
    """Unit vectors along K^-1 e, column by column."""
    return unit(np.asarray(np.linalg.solve(K, e), dtype=np.float64))


def departure(R: Array) -> float:
    """From a rotation: largest number in R^T R - I."""
    return float(np.max(np.abs(R.T @ R - np.eye(3))))


def foe(seen1: Array, seen2: Array) -> Array:
    return cah.estimateFOE(seen1, seen2, method=cah.FOE_LEAST_SQUARES)[1][:, 0]


def foes(scene: Scene, seen: Array) -> tuple[Array, Array]:
    """Columns: translations b of the gripper from the first view, gripper frame, and their FOEs."""
    b = (scene.t_gripper2base[1:] - scene.t_gripper2base[0]) @ scene.R_gripper2base[0]
    return b.T, np.array([foe(seen[0], other) for other in seen[1:]]).T


def equation_13(b: Array, c: Array) -> Array:
    """R = B C^-1 of three translations b and unit directions c of the camera's motion."""
    return np.asarray(unit(b) @ np.asarray(np.linalg.inv(c), dtype=np.float64))


def equations_17(b: Array, e: Array) -> Array:
    """Two rows per translation for the nine entries of P: unit directions in b, FOEs as pixels."""
    rows = []
    for bi, (u, v, w) in zip(unit(b).T, e.T, strict=True):
        rows += [[*bi, 0, 0, 0, *(-u / w * bi)], [0, 0, 0, *bi, *(-v / w * bi)]]
    return np.array(rows)


def equation_30(k: float, c: Array, K: Array, seen1: Array, seen2: Array) -> Array:
    """Depth z_c1 from the image x-coordinates."""
    return np.asarray(k * (K[0] @ c - c[2] * seen2[:, 0]) / (seen2[:, 0] - seen1[:, 0]))


def test_sign_of_27_puts_the_scene_behind_the_camera() -> None:
    c = np.array([0.04, 0.01, 0.02])
    scene = with_camera_moved_by(random_scene(np.random.default_rng(SEED), 30, (1,)), c)
    X1, X2, k = in_camera(scene, 0), in_camera(scene, 1), float(np.linalg.norm(c))
    K, (seen1, seen2) = scene.camera_matrix, pixels(scene)
    motion = rays(K, foe(seen1, seen2))
    np.testing.assert_allclose(motion, c / k, atol=1e-9)

    np.testing.assert_allclose(X1 - X2, np.tile(k * motion, (30, 1)), atol=1e-9)
    printed, ours = equation_30(k, motion, K, seen1, seen2), equation_30(-k, motion, K, seen1, seen2)
    assert printed.max() < -0.4
    np.testing.assert_allclose(ours, X1[:, 2], rtol=1e-8)


def test_foe_of_3_has_no_pixel_for_a_sideways_translation(scene: Scene) -> None:
    c = np.array([0.03, -0.04, 0.0])
    moved = with_camera_moved_by(scene, c)
    seen1, seen2 = pixels(moved)
    lines = np.cross(homogeneous(seen1), homogeneous(seen2))
    lines /= np.linalg.norm(lines[:, :2], axis=1, keepdims=True)
    printed, _, rank, _ = np.linalg.lstsq(lines[:, :2], -lines[:, 2], rcond=1e-9)
    assert rank == 1
    assert degrees_between(rays(scene.camera_matrix, [*printed, 1]), c) > 45

    ours = foe(seen1, seen2)
    assert abs(ours[2]) < 1e-12
    assert degrees_between(rays(scene.camera_matrix, ours), c) < 1e-9


def test_foe_of_3_as_a_pixel_does_not_tell_forward_from_backward(scene: Scene) -> None:
    c = np.array([0.01, -0.02, -0.05])
    seen1, seen2 = pixels(with_camera_moved_by(scene, c))
    ours = foe(seen1, seen2)
    printed = rays(scene.camera_matrix, [*(ours[:2] / ours[2]), 1])
    assert degrees_between(printed, c) > 180 - 1e-6

    assert degrees_between(rays(scene.camera_matrix, ours), c) < 1e-8
    np.testing.assert_allclose(foe(seen2, seen1), -ours, atol=1e-12)


def test_rotation_of_13_needs_the_camera_matrix(scene: Scene) -> None:
    four = with_views(scene, scene.R_gripper2base[:4], scene.t_gripper2base[:4])
    seen, K = pixels(four), scene.camera_matrix
    b, e = foes(four, seen)
    guess = K @ np.diag([1.1, 1.1, 1.0])
    printed = equation_13(b, rays(guess, e))
    assert departure(printed) > 0.02
    assert degrees_between(printed[:, 2], scene.R_cam2gripper[:, 2]) > 1
    exact = equation_13(b, rays(K, e))
    np.testing.assert_allclose(exact, scene.R_cam2gripper, atol=1e-9)

    views = four.R_gripper2base, four.t_gripper2base, seen
    _, camera_matrix, ours, _ = cah.calibrateHandEyeTranslations(*views, None, None)
    np.testing.assert_allclose(camera_matrix, K, atol=1e-6)
    np.testing.assert_allclose(ours, scene.R_cam2gripper, atol=1e-9)


def test_rotation_of_13_is_no_rotation_with_noise(scene: Scene) -> None:
    four = with_views(scene, scene.R_gripper2base[:4], scene.t_gripper2base[:4])
    seen = four.observe(np.random.default_rng(SEED), 0.1)
    b, e = foes(four, seen)
    printed = equation_13(b, rays(scene.camera_matrix, e))
    assert departure(printed) > 2e-4

    fixed: dict[str, Any] = {"flags": cah.TRANSLATIONS_FIX_K}
    views = four.R_gripper2base, four.t_gripper2base
    ours = cah.calibrateHandEyeTranslations(*views, seen, scene.camera_matrix, None, **fixed)[2]
    assert departure(ours) < 1e-12
    assert np.linalg.norm(ours - scene.R_cam2gripper) < np.linalg.norm(printed - scene.R_cam2gripper)

    exact = pixels(four)[:3]
    two = cah.calibrateHandEyeTranslations(views[0][:3], views[1][:3], exact, scene.camera_matrix, None, **fixed)[2]
    np.testing.assert_allclose(two, scene.R_cam2gripper, atol=1e-9)


def test_camera_matrix_of_18_hangs_on_the_guess(scene: Scene) -> None:
    seen, K = pixels(scene), scene.camera_matrix
    b, e = foes(scene, seen)
    P = np.linalg.svd(equations_17(b, e))[2][-1].reshape(3, 3)
    P /= np.cbrt(np.linalg.det(P)) / np.cbrt(np.linalg.det(K))
    np.testing.assert_allclose(P, K @ scene.R_cam2gripper.T, atol=1e-6)

    guess = K @ np.diag([1.1, 1.1, 1.0])
    R = equation_13(b[:, :3], rays(guess, e[:, :3]))
    P *= np.linalg.norm(np.linalg.inv(R)[2]) / np.linalg.norm(P[2])
    printed = P @ R
    assert abs(printed[0, 0] - K[0, 0]) > 50
    assert max(abs(printed[1, 0]), abs(printed[2, 0]), abs(printed[2, 1])) > 1e-3

    upper, rotation = rq(P)
    signs = np.diag(np.sign(np.diag(upper)))
    np.testing.assert_allclose(upper @ signs / abs(upper[2, 2]), K, atol=1e-6)
    np.testing.assert_allclose((signs @ rotation).T, scene.R_cam2gripper, atol=1e-9)
    views = scene.R_gripper2base, scene.t_gripper2base, seen
    _, ours, R_ours, _ = cah.calibrateHandEyeTranslations(*views, None, None, method=cah.TRANSLATIONS_FOE)
    np.testing.assert_allclose(ours, K, atol=1e-6)
    np.testing.assert_allclose(R_ours, scene.R_cam2gripper, atol=1e-9)


def test_equations_17_of_four_translations_need_no_three_coplanar(scene: Scene) -> None:
    t = scene.t_gripper2base.copy()
    t[4] = t[0] + 0.6 * (t[1] - t[0]) - 0.7 * (t[2] - t[0])
    coplanar = with_views(scene, scene.R_gripper2base, t)
    seen = pixels(coplanar)
    b, e = foes(coplanar, seen)
    sizes = np.linalg.svd(equations_17(b, e), compute_uv=False)
    assert np.linalg.matrix_rank(b, tol=1e-3) == 3
    assert sizes[7] < 1e-9 * sizes[0]
    assert np.linalg.svd(equations_17(*foes(scene, pixels(scene))), compute_uv=False)[7] > 1e-6 * sizes[0]

    views = coplanar.R_gripper2base, coplanar.t_gripper2base, seen
    with pytest.raises(cah.error, match="coplanar"):
        cah.calibrateHandEyeTranslations(*views, None, None, method=cah.TRANSLATIONS_FOE)
    ours = cah.calibrateHandEyeTranslations(*views, None, None)[2]
    np.testing.assert_allclose(ours, scene.R_cam2gripper, atol=1e-9)


def turn_of_34(scene: Scene) -> tuple[Array, Array, Array]:
    """^C R_H R_H ^H R_C of the last two views, its inverse as in (35), and ^C t_H."""
    R_H = scene.R_gripper2base[-1].T @ scene.R_gripper2base[-2]
    R, t = scene.R_cam2gripper, scene.t_cam2gripper
    return R.T @ R_H @ R, R.T @ R_H.T @ R, -R.T @ t


def test_translation_of_36_misses_an_inverse(scene: Scene) -> None:
    turned = with_pure_rotation(scene, AXIS)
    forth, back, t = turn_of_34(turned)
    X5, X6 = in_camera(turned, -2), in_camera(turned, -1)
    np.testing.assert_allclose(X6, X5 @ forth.T + t - forth @ t, atol=1e-12)

    X7 = X6 @ back.T
    printed, ours = X5 + (forth - np.eye(3)) @ t, X5 + (back - np.eye(3)) @ t
    np.testing.assert_allclose(ours, X7, atol=1e-12)
    shift = np.linalg.norm(X7 - X5, axis=1)
    assert np.all(shift > 0.01)
    assert np.all(np.linalg.norm(printed - X7, axis=1) > 1.9 * shift)


def test_depth_ratio_of_39_misses_the_pixel(scene: Scene) -> None:
    turned = with_pure_rotation(scene, AXIS)
    _, back, _ = turn_of_34(turned)
    K, seen6 = scene.camera_matrix, homogeneous(pixels(turned)[-1])
    X7 = in_camera(turned, -1) @ back.T
    truth = (X7 @ K.T)[:, :2] / X7[:, 2:]
    G = K @ back @ np.linalg.inv(K)
    numerators = (seen6 @ G.T)[:, :2]
    printed, ours = numerators / G[2].sum(), numerators / (seen6 @ G[2])[:, None]
    assert np.linalg.norm(printed - truth, axis=1).min() > 10
    np.testing.assert_allclose(ours, truth, atol=1e-8)


def test_inverse_of_43_does_not_exist(scene: Scene) -> None:
    moved = replace(scene, t_cam2gripper=scene.t_cam2gripper + 0.05 * scene.R_cam2gripper @ AXIS)
    ways = []
    for truth in (scene, moved):
        turned = with_pure_rotation(truth, AXIS)
        forth, back, _ = turn_of_34(turned)
        for matrix in (forth - np.eye(3), back - np.eye(3)):
            sizes = np.linalg.svd(matrix, compute_uv=False)
            assert sizes[2] < 1e-14 < 0.1 < sizes[1]
        ways.append((in_camera(turned, -1) @ back.T - in_camera(turned, -2)).mean(axis=0))
    # Two cameras 50 mm apart make the same imaginary translation: (43) would have to give both.
    np.testing.assert_allclose(ways[1], ways[0], atol=1e-12)
    assert np.linalg.norm(ways[0]) > 0.01


def test_one_pure_rotation_leaves_the_axis_and_a_second_one_closes_it(scene: Scene) -> None:
    def translation(turned: Scene, flags: int = 0) -> tuple[Array, Array]:
        views = turned.R_gripper2base, turned.t_gripper2base, pixels(turned)
        camera = scene.camera_matrix, None, scene.R_cam2gripper
        _, t, covariance = cah.calibrateHandEyeRotation(*views, *camera, flags=flags)
        return t[:, 0], covariance

    one = with_pure_rotation(scene, AXIS)
    with pytest.raises(cah.error, match="axis") as refused:
        translation(one)
    assert refused.value.code == -7
    partial, covariance = translation(one, cah.ROTATION_ALLOW_PARTIAL)
    axis = scene.R_cam2gripper @ AXIS
    along = axis @ scene.t_cam2gripper
    assert abs(along) > 0.01
    np.testing.assert_allclose(partial, scene.t_cam2gripper - along * axis, atol=1e-9)
    assert np.all(np.isinf(np.diag(covariance)))

    two = with_pure_rotation(scene, AXIS, SECOND_AXIS)
    np.testing.assert_allclose(translation(two)[0], scene.t_cam2gripper, atol=1e-9)
