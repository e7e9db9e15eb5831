# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""predictHandEyeCovariance against the Cramér-Rao bound of an independent program and against refined recordings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import cv_active_handeye as cah
from benchmark import boards
from benchmark.fisher import bound
from benchmark.planning import OPENCV, PAPERS, PLANNED, Reached, draw
from benchmark.planning_cells import PAPER, PlanningCell, board_world, refined_error
from benchmark.refine_trials import PINHOLE, settings
from benchmark.scene import HEIGHT, WIDTH, Array
from benchmark.stops import STOPS_12, active_stops
from benchmark.world import DISTORTED, TRANSLATION, Noise, World, in_image, random_world

NOISE = Noise(0.1, 0.02, 0.01)


def world_in_image(seed: int, dist_coeffs: Array | None = None) -> World:
    """Every point is seen wherever it is in the image, and none is at its very edge."""
    rng = np.random.default_rng(seed)
    world = random_world(rng, active_stops(rng, STOPS_12), 80, dist_coeffs)
    seen = world.project(world.parameters(), world.R_gripper2base, world.t_gripper2base, world.points)
    edge = (np.abs(seen - (WIDTH - 0.5, HEIGHT - 0.5)) < 1).any(axis=(0, 2))
    world = replace(world, points=world.points[~edge])
    return replace(world, visible=in_image(world, world.points))


def predicted(world: World, params: cah.RefineParams) -> tuple[float, Array]:
    sigma, covariance, _, seen = cah.predictHandEyeCovariance(
        world.R_gripper2base,
        world.t_gripper2base,
        world.points,
        (WIDTH, HEIGHT),
        world.camera_matrix,
        world.dist_coeffs,
        world.R_cam2gripper,
        world.t_cam2gripper,
        params=params,
    )
    assert seen.ravel().tolist() == world.visible[:, world.visible.sum(axis=0) >= 2].sum(axis=1).tolist()
    return sigma, covariance


@pytest.mark.parametrize(
    ("flags", "lens", "free"),
    [
        (0, cah.LENS_FIXED, PINHOLE),
        (cah.REFINE_FIX_K, cah.LENS_FIXED, PINHOLE[4:]),
        (cah.REFINE_SKEW, cah.LENS_FIXED, (*PINHOLE, "skew")),
        (0, cah.LENS_K1_K2, (*PINHOLE, "k1", "k2")),
        (cah.REFINE_FIX_ROTATION, cah.LENS_FIXED, (*PINHOLE[:4], *PINHOLE[7:])),
    ],
)
def test_prediction_is_the_cramer_rao_bound(flags: int, lens: int, free: tuple[str, ...]) -> None:
    for seed in (1, 2):
        world = world_in_image(seed, DISTORTED if lens == cah.LENS_K1_K2 else None)
        sigma, covariance = predicted(world, settings(lens, NOISE, flags))
        expected = bound(world, NOISE, free)
        size = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
        used = size > 0
        np.testing.assert_array_equal(covariance[~used], 0)
        np.testing.assert_allclose(covariance[used] / size[used], expected[used] / size[used], atol=1e-5)
        assert sigma == pytest.approx(np.sqrt(np.diag(expected)[TRANSLATION].sum()), rel=1e-5)


def test_exact_robot_is_predicted_without_corrections() -> None:
    world, exact = world_in_image(3), Noise(0.1, 0.0, 0.0)
    sigma, _ = predicted(world, settings(cah.LENS_FIXED, exact))
    assert sigma == pytest.approx(np.sqrt(np.diag(bound(world, exact, PINHOLE))[TRANSLATION].sum()), rel=1e-5)
    assert sigma < 0.8 * predicted(world, settings(cah.LENS_FIXED, NOISE))[0]


def test_unit_of_length_scales_the_prediction() -> None:
    world = world_in_image(4)
    in_mm = replace(
        world,
        t_gripper2base=1000 * world.t_gripper2base,
        t_cam2gripper=1000 * world.t_cam2gripper,
        points=1000 * world.points,
    )
    params = settings(cah.LENS_FIXED, NOISE)
    metres, _ = predicted(world, params)
    params.robotTranslationSigma *= 1000
    assert predicted(in_mm, params)[0] == pytest.approx(1000 * metres, rel=1e-9)


def test_refined_recordings_of_planned_stops_scatter_as_predicted() -> None:
    """100 trials know an RMS error of three coordinates to 4 to 7 %."""
    cell = PlanningCell.simulated("ur5e", 1)
    poses = cell.paper(12, 1)
    world = cell.world(poses)
    squares = [refined_error(world, np.random.default_rng([5, number]))[1] for number in range(100)]
    sigma_mm = 1000 * predicted_sigma(cell, poses)
    assert sigma_mm == pytest.approx(np.sqrt(np.mean(squares)), rel=0.15)


def predicted_sigma(cell: PlanningCell, poses: list[Array]) -> float:
    stops, truth = np.array(poses), cell.truth
    return cah.predictHandEyeCovariance(
        stops[:, :3, :3],
        stops[:, :3, 3],
        truth.points,
        truth.image_size,
        truth.camera_matrix,
        None,
        truth.T_cam2gripper[:3, :3],
        truth.T_cam2gripper[:3, 3],
        params=truth.params,
    )[0]


def test_stops_of_the_benchmark_have_their_numbers_and_see_scene_and_board() -> None:
    cell = PlanningCell.simulated("ur5e", 1)
    for stops in PAPER:
        poses = cell.paper(stops, 1)
        assert len(poses) == stops
        assert cell.world(poses).visible.sum(axis=1).min() > 50
        board = board_world(cell.world(poses), np.random.default_rng(1), stops)
        assert board.visible.mean() > 0.97
        assert board.visible.shape == (stops, len(boards.corners()))
        assert cell.seconds_nearest_next(board) > stops


def test_row_and_picture_of_the_benchmark(tmp_path_factory: pytest.TempPathFactory) -> None:
    found = [
        Reached(way, "ur5e", stops, None if way == OPENCV else 0.11, np.array([0.02, 0.1]), 60.0 * stops)
        for way in (PLANNED, PAPERS, OPENCV)
        for stops in (12, 24)
    ]
    assert found[0].off_percent == pytest.approx(10)
    assert found[0].row() == ["ur5e", 12, PLANNED, 0.11, 0.1, pytest.approx(10), 0.02, 720.0]
    assert found[-1].off_percent is None
    path = tmp_path_factory.mktemp("picture") / "planning.png"
    draw(path, found)
    assert path.stat().st_size > 10000
