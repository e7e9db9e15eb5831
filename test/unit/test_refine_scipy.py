# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""refineHandEye against scipy.optimize.least_squares on the same problem: same optimum, same covariance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from support.joint_model import NOISE, POSES, Model

import cv_active_handeye as cah
from benchmark.stops import STOPS_12, active_stops
from benchmark.stripes import random_stripes
from benchmark.world import NAMES, Recording, World, random_world

Array = NDArray[np.float64]

ORDER = ["fx", "fy", "cx", "cy", "k1", "k2", "k3", "rx", "ry", "rz", "tx", "ty", "tz"]
AT = [NAMES.index(name) for name in ORDER]
"""Where the first unknowns of the model are in the covariance."""


def settings(lens: int, huber: float | None) -> cah.RefineParams:
    """All noise levels given."""
    params = cah.RefineParams()
    params.lensModel, params.huberThreshold, params.rejectThreshold = lens, huber or 1e6, 1e6
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


def refine(
    made: World, seen: Recording, lens: int, board: Array | None, sigmas: Array | None, huber: float | None
) -> Answer:
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
    huber: float | None = None,
) -> None:
    """The optimum agrees to 1e-5 of a standard deviation (1e-3 where Huber's loss clips), the covariance to 1e-3."""
    ours = refine(made, seen, lens, board, sigmas, huber)
    weights = np.ones(made.visible.shape) if sigmas is None else sigmas
    model = Model(seen, made.visible, ours.unknowns[:2], ours.R_cam2gripper, ours.light, weights, board)
    free = [*range(4 + LENSES[lens]), *range(7, 13), *([] if ours.light is None else [13, 14, 15])]
    near = 1e-5 if huber is None else 1e-3
    best = model.solve(start(made, seen, ours, board), free)
    if huber is not None:
        best = model.solve_huber(best, free, huber)
    covariance = model.covariance(best, free)
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


def test_huber() -> None:
    """One image point in twenty is off by 5 to 8 sigma; nothing is left out."""
    made, seen = world(5)
    rng = np.random.default_rng(55)
    wrong = made.visible & (rng.random(made.visible.shape) < 0.05)
    away = rng.normal(size=(int(wrong.sum()), 2))
    away *= NOISE.point_px * rng.uniform(5, 8, (len(away), 1)) / np.linalg.norm(away, axis=1, keepdims=True)
    seen.image_points[wrong] += away
    compare(made, seen, huber=2.5)
