# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The simulated recordings and the Cramér-Rao bound of everything at once, against dense numerical derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmark import boards
from benchmark.fisher import bound
from benchmark.refine_trials import PINHOLE
from benchmark.scene import Array
from benchmark.stops import STOPS_12, STOPS_24, active_stops
from benchmark.stripes import Stripes, random_stripes
from benchmark.world import DISTORTED, NAMES, ROTATION, TRANSLATION, Noise, World, random_world

LENS = (*PINHOLE, "k1", "k2", "p1", "p2", "k3")


def small_world(seed: int, stripes: bool = False, board: bool = False) -> World:
    rng = np.random.default_rng(seed)
    motion = active_stops(rng, (3, 2, 1))
    world = random_world(rng, motion, 9, DISTORTED, random_stripes(rng, 2, 3) if stripes else None)
    return boards.put_board(rng, world, boards.corners(4, 3)) if board else world


def exact_world(world: World, unknowns: Array) -> tuple[World, Array, Array]:
    """World and true poses of all unknowns: parameters (16), poses (6 V), points (3 N) or board (6), planes."""
    V = len(world.R_gripper2base)
    own, poses, rest = unknowns[:16], unknowns[16 : 16 + 6 * V].reshape(V, 6), unknowns[16 + 6 * V :]
    K = np.array([[own[0], own[4], own[2]], [0, own[1], own[3]], [0, 0, 1]])
    R = Rotation.from_rotvec(own[10:13]).as_matrix() @ world.R_cam2gripper
    turns = Rotation.from_rotvec(poses[:, :3]).as_matrix()
    if world.board:
        points, rest = Rotation.from_rotvec(rest[:3]).apply(world.points) + rest[3:6], rest[6:]
    else:
        points, rest = rest[: world.points.size].reshape(-1, 3), rest[world.points.size :]
    stripes = world.stripes
    if stripes is not None:
        light = np.append(np.append(rest[:2], np.sqrt(1 - rest[:2] @ rest[:2])), rest[2])
        slopes = rest[3:].reshape(-1, 3)
        surfaces = np.column_stack([slopes[:, :2], np.ones(len(slopes)), slopes[:, 2]])
        stripes = Stripes(light, surfaces, stripes.columns)
    moved = World(
        K, own[5:10], R, own[13:16], world.R_gripper2base, world.t_gripper2base, points, world.visible, stripes
    )
    return moved, turns @ world.R_gripper2base, world.t_gripper2base + poses[:, 3:]


def start(world: World) -> Array:
    """The true values of all unknowns."""
    parts = [world.parameters(), np.zeros(6 * len(world.R_gripper2base))]
    parts.append(np.zeros(6) if world.board else world.points.ravel())
    if world.stripes is not None:
        surfaces = world.stripes.surfaces / world.stripes.surfaces[:, 2:3]
        parts += [world.stripes.light_plane[[0, 1, 3]], surfaces[:, [0, 1, 3]].ravel()]
    return np.concatenate(parts)


def dense_bound(world: World, noise: Noise, free: Sequence[str]) -> Array:
    """Covariance (20, 20) from central differences of the noise-free recording, nothing eliminated."""
    V = len(world.R_gripper2base)

    def predicted(unknowns: Array) -> Array:
        moved, R, t = exact_world(world, unknowns)
        seen = np.asarray(moved.project(moved.parameters(), R, t, moved.points), dtype=np.float64)[world.visible]
        whole = [seen.ravel() / noise.point_px, unknowns[16 : 16 + 6 * V] / prior]
        if moved.stripes is not None:
            whole.append(moved.stripes.segments(moved, R, t)[..., 1].ravel() / noise.stripe_px)
        return np.concatenate(whole)

    prior = np.tile([noise.rotation] * 3 + [noise.translation] * 3, V)
    truth = start(world)
    steps = 1e-6 * np.maximum(1, np.abs(truth))
    J = np.column_stack(
        [
            (predicted(truth + h * e) - predicted(truth - h * e)) / (2 * h)
            for h, e in zip(steps, np.eye(len(truth)), strict=True)
        ]
    )
    used = np.array([name in free for name in NAMES[:16]] + [True] * (len(truth) - 16))
    scale = np.linalg.norm(J[:, used], axis=0)
    covariance = np.zeros((len(truth), len(truth)))
    covariance[np.ix_(used, used)] = np.linalg.inv((J[:, used] / scale).T @ (J[:, used] / scale)) / np.outer(
        scale, scale
    )
    spread = np.zeros((20, len(truth)))
    spread[:16, :16] = np.eye(16)
    if world.stripes is not None:
        first = len(truth) - 3 - 3 * len(world.stripes.surfaces)
        n = world.stripes.light_plane
        spread[16:, first : first + 3] = [[1, 0, 0], [0, 1, 0], [-n[0] / n[2], -n[1] / n[2], 0], [0, 0, 1]]
    return np.asarray(spread @ covariance @ spread.T)


@pytest.mark.parametrize(
    ("stripes", "board", "free"), [(False, False, PINHOLE), (True, False, LENS), (False, True, PINHOLE)]
)
def test_the_bound_is_the_inverse_of_the_whole_information_matrix(
    stripes: bool, board: bool, free: Sequence[str]
) -> None:
    world = small_world(5, stripes, board)
    noise = Noise(0.2, 0.05, 0.02, 0.3)
    found, dense = bound(world, noise, free), dense_bound(world, noise, free)
    scale = np.sqrt(np.diag(dense))
    scale[scale == 0] = 1
    np.testing.assert_allclose(found / np.outer(scale, scale), dense / np.outer(scale, scale), atol=2e-3)


def test_an_exact_robot_is_the_limit_of_a_good_one() -> None:
    world = small_world(6)
    exact, good = (np.diag(bound(world, Noise(0.1, mm, mm), PINHOLE)) for mm in (0.0, 1e-7))
    np.testing.assert_allclose(exact, good, rtol=1e-4)


@pytest.mark.parametrize(
    ("stops", "noise", "points", "t_mm", "R_deg"),
    [
        (STOPS_12, Noise(), 60, 0.26, 0.030),
        (STOPS_24, Noise(), 60, 0.12, 0.016),
        (STOPS_12, Noise(robot_deg=0.01), 400, 0.14, 0.015),
        (STOPS_24, Noise(robot_deg=0.01), 400, 0.084, 0.0075),
    ],
)
def test_bounds_are_those_of_the_method(
    stops: tuple[int, ...], noise: Noise, points: int, t_mm: float, R_deg: float
) -> None:
    """Section 7 of the method's description; its stops are the same in kind only."""
    variances = []
    for trial in range(8):
        rng = np.random.default_rng([1, trial])
        variances.append(np.diag(bound(random_world(rng, active_stops(rng, stops), points), noise, PINHOLE)))
    mean = np.mean(variances, axis=0)
    assert 1000 * np.sqrt(mean[TRANSLATION].sum()) == pytest.approx(t_mm, rel=0.25)
    assert np.degrees(np.sqrt(mean[ROTATION].sum())) == pytest.approx(R_deg, rel=0.25)


def test_points_are_projected_as_by_opencv() -> None:
    world = replace(small_world(7), dist_coeffs=np.array([-0.1, 0.05, 0.001, -0.002, 0.02]))
    seen = np.asarray(world.project(world.parameters(), world.R_gripper2base, world.t_gripper2base, world.points))
    for R, t, pixels in zip(world.R_gripper2base, world.t_gripper2base, seen, strict=True):
        R_base2cam = (R @ world.R_cam2gripper).T
        turn, shift = cv2.Rodrigues(R_base2cam)[0], -R_base2cam @ (R @ world.t_cam2gripper + t)
        expected, _ = cv2.projectPoints(world.points, turn, shift, world.camera_matrix, world.dist_coeffs)
        np.testing.assert_allclose(pixels, expected[:, 0], atol=1e-8)


def test_stripes_lie_on_light_plane_and_surface() -> None:
    world = small_world(8, stripes=True)
    assert world.stripes is not None
    R, t = world.R_gripper2base, world.t_gripper2base
    segments = world.stripes.segments(world, R, t)
    n, d = world.stripes.light_plane[:3], world.stripes.light_plane[3]
    for view, of_view in enumerate(segments):
        for surface, pixels in zip(world.stripes.surfaces, of_view, strict=True):
            camera = world.camera_matrix, world.dist_coeffs, np.eye(3), np.eye(3)
            ideal = cv2.undistortPointsIter(pixels[:, None], *camera, (cv2.TERM_CRITERIA_EPS, 40, 1e-12))
            rays = np.column_stack([ideal[:, 0], np.ones(len(pixels))])
            in_camera = rays * (d / (rays @ n))[:, None]
            in_base = (in_camera @ world.R_cam2gripper.T + world.t_cam2gripper) @ R[view].T + t[view]
            np.testing.assert_allclose(in_base @ surface[:3], surface[3], atol=1e-7)


def test_a_recording_has_the_noise_that_was_asked_for() -> None:
    world = random_world(np.random.default_rng(1), active_stops(np.random.default_rng(1)), 200)
    recording = world.record(np.random.default_rng(2), Noise(0.3, 0.1, 0.05))
    exact = world.project(world.parameters(), recording.true_rotations, recording.true_translations, world.points)
    assert np.nanstd(recording.image_points - exact) == pytest.approx(0.3, rel=0.03)
    moved = recording.true_translations - recording.t_gripper2base
    assert np.std(moved) == pytest.approx(1e-4, rel=0.3)
    turned = Rotation.from_matrix(recording.true_rotations @ recording.R_gripper2base.transpose(0, 2, 1)).as_rotvec()
    assert np.degrees(np.std(turned)) == pytest.approx(0.05, rel=0.3)
    assert np.array_equal(np.isnan(recording.image_points[..., 0]), ~world.visible)
