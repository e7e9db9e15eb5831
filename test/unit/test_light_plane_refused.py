# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Stripes that do not determine a light plane are refused, with what to do, by the functions and by the workflow."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import cv_active_handeye as cah

Array = NDArray[np.float64]
K = np.array([[1413.0, 0, 322], [0, 1409, 243], [0, 0, 1]])
LIGHT = np.append(np.array([0.0, -0.5, 0.13]) / np.hypot(0.5, 0.13), 0.13 * 0.5 / np.hypot(0.5, 0.13))
"""It meets horizontal surfaces along the image's x."""
DOWN = np.diag([1.0, -1, -1])
CENTRE = np.array([0.0, 0.0, 0.5])
TABLE = np.array([0.0, 0.2, 1.0, 0.0])
TILTED = np.array([-0.4, 0.1, 1.0, 0.01])
STAR = np.array([[0, 0, 0], [50, 0, 0], [0, 50, 0], [0, 0, 50], [-50, 30, -35]]) / 1000
TURNED = Rotation.from_euler("xyz", [8, 14, 5], degrees=True).as_matrix()


@dataclass
class Stripes:
    """Poses (the gripper is the camera), exact stripes on planes w.X = e, 300 points of the scene."""

    orientations: list[Array] = field(default_factory=list)
    positions: list[Array] = field(default_factory=list)
    planes: tuple[Array, ...] = (TABLE, TILTED)
    light: Array = field(default_factory=lambda: LIGHT)

    def group(self, moves: Array, turn: Array | None = None) -> Stripes:
        """Adds views of one orientation."""
        R = (np.eye(3) if turn is None else turn) @ DOWN
        self.orientations += [R] * len(moves)
        self.positions += list(CENTRE + moves)
        return self

    def segments(self) -> tuple[list[Array], list[int], list[int]]:
        """Points, views and surfaces; every surface has its own columns."""
        points, views, ids = [], [], []
        for view, (R, t) in enumerate(zip(self.orientations, self.positions, strict=True)):
            for k, plane in enumerate(self.planes):
                columns = np.linspace(40 + 280 * k, 290 + 280 * k, 80)
                line = (
                    (plane[3] - plane[:3] @ t) * self.light[:3] - self.light[3] * (R.T @ plane[:3])
                ) @ np.linalg.inv(K)
                points.append(np.column_stack([columns, -(line[0] * columns + line[2]) / line[1]]))
                views.append(view)
                ids.append(k)
        return points, views, ids

    def image_points(self) -> list[Array]:
        """Exact pixels of the scene."""
        scene = np.random.default_rng(2).uniform([-0.08, -0.06, -0.03], [0.08, 0.06, 0.05], (300, 3))
        seen = [(scene - t) @ R @ K.T for R, t in zip(self.orientations, self.positions, strict=True)]
        return [s[:, :2] / s[:, 2:] for s in seen]


def calibrate(stripes: Stripes, change: Callable[[Any, Any, Any], None] = lambda *_: None) -> Array:
    points, views, ids = stripes.segments()
    change(points, views, ids)
    arguments = (stripes.orientations, stripes.positions, points, views, ids)
    return np.ravel(cah.calibrateLightPlane(*arguments, K, None, np.eye(3))[1])


def refine(stripes: Stripes, change: Callable[[Any, Any, Any], None] = lambda *_: None) -> Array:
    points, views, ids = stripes.segments()
    change(points, views, ids)
    params = cah.RefineParams()
    params.flags = int(cah.REFINE_FIX_K | cah.REFINE_FIX_ROTATION | cah.REFINE_FIX_TRANSLATION)
    start = K, None, np.eye(3), np.zeros(3), None
    rng = np.random.default_rng(3)
    seen = [p + rng.normal(0, 0.02, p.shape) for p in stripes.image_points()]
    found = cah.refineHandEye(
        stripes.orientations,
        stripes.positions,
        seen,
        *start,
        stripePoints=points,
        stripeViews=views,
        surfaceIds=ids,
        params=params,
    )
    assert found[5] is not None
    return np.ravel(found[5])


BOTH = pytest.mark.parametrize("function", [calibrate, refine])


def two_groups() -> Stripes:
    return Stripes().group(STAR).group(STAR, TURNED)


@BOTH
def test_stripes_of_two_groups_give_the_true_plane(function: Callable[..., Array]) -> None:
    assert function(two_groups()) == pytest.approx(LIGHT, abs=1e-4)


@BOTH
def test_translations_along_the_stripe_only(function: Callable[..., Array]) -> None:
    along = np.array([[0, 0, 0], [50, 0, 0], [-50, 0, 0], [20, 0, 0]]) / 1000
    stripes = Stripes(planes=(TABLE,)).group(along)
    needed = r"along the stripe only; needed .* across|all translations are parallel; needed .* add one along"
    with pytest.raises(cah.error, match=f"t_gripper2base: .*({needed})"):
        function(stripes)


@BOTH
def test_light_plane_behind_the_camera(function: Callable[..., Array]) -> None:
    stripes = two_groups()
    mirrored = Stripes(stripes.orientations, [2 * CENTRE - t for t in stripes.positions], stripes.planes)
    points = mirrored.segments()[0]

    def swap(given: Any, *_: Any) -> None:
        given[:] = points

    with pytest.raises(cah.error, match=r"t_gripper2base: the stripes move against .* behind the camera; needed poses"):
        function(stripes, swap)


@BOTH
def test_surfaces_parallel_to_the_light_plane(function: Callable[..., Array]) -> None:
    parallel = np.append(DOWN @ LIGHT[:3], 0.0) * -1
    parallel[3] = parallel[:3] @ (CENTRE + DOWN @ (LIGHT[:3] * LIGHT[3])) + 1e-9
    stripes = Stripes(planes=(parallel,)).group(STAR)

    def noisy(points: Any, *_: Any) -> None:
        rng = np.random.default_rng(1)
        for p in points:
            p[:, 1] = 240 + rng.normal(0, 0.05, len(p))

    with pytest.raises(cah.error, match=r"stripePoints: .*(parallel to the light plane|stand still)"):
        function(stripes, noisy)


@BOTH
def test_stripe_of_one_view_only(function: Callable[..., Array]) -> None:
    def first_view(points: Any, views: Any, ids: Any) -> None:
        del points[2:], views[2:], ids[2:]

    with pytest.raises(cah.error, match=r"surfaceIds: no surface has its stripe in enough views; needed at least 3"):
        function(two_groups(), first_view)


@BOTH
def test_stripes_that_contradict_each_other_are_named(function: Callable[..., Array]) -> None:
    def scatter(points: Any, *_: Any) -> None:
        rng = np.random.default_rng(4)
        for p in points:
            p[:, 1] += rng.uniform(-60, 60)

    with pytest.raises(cah.error, match=r"surfaceIds: .*stripePoints\[\d+\]"):
        function(two_groups(), scatter)


@BOTH
def test_no_surface_is_known(function: Callable[..., Array]) -> None:
    def forget(points: Any, views: Any, ids: Any) -> None:
        ids[:] = [-1] * len(ids)

    with pytest.raises(cah.error, match="given no segment with a surface id"):
        function(two_groups(), forget)
