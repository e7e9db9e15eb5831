# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""DENSO's P- and T-type poses against scipy, at random and where angles are hard."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from cv_active_handeye.robots.base import RobotError
from cv_active_handeye.robots.bcap_packets import Value
from cv_active_handeye.robots.denso_pose import matrix_from_p, matrix_from_t, numbers, p_from_matrix, t_from_matrix

Array = NDArray[np.float64]
NEAR = (0.0, 1e-13, 1e-9, 1e-6, 1e-3, 0.1)


def pose(rotation: Rotation, mm: tuple[float, float, float] = (412.5, -33.25, 207.0)) -> Array:
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = rotation.as_matrix(), np.array(mm) / 1000
    return out


def angles_of_all_kinds() -> Array:
    """RX, RY, RZ (deg): at random, near RY = +-90, near +-180, and multiples of 90."""
    rng = np.random.default_rng(4)
    out = [*rng.uniform(-180, 180, (300, 3))]
    for off in NEAR:
        for sign in (-1, 1):
            out += [np.array([a, sign * (90 - off), b]) for a, b in rng.uniform(-180, 180, (5, 2))]
            out += [np.array([sign * (180 - off), b, sign * (off - 180)]) for b in rng.uniform(-90, 90, 5)]
    out += [np.array([a, b, c]) * 90.0 for a in range(-2, 3) for b in (-1, 0, 1) for c in range(-2, 3)]
    return np.array(out)


def test_p_type_is_turns_about_fixed_axes_x_y_z_as_scipy_has_them() -> None:
    for angles in angles_of_all_kinds():
        wanted = pose(Rotation.from_euler("xyz", angles, degrees=True))
        np.testing.assert_allclose(matrix_from_p([412.5, -33.25, 207.0, *angles, 5]), wanted, atol=1e-15)


def test_matrix_to_p_type_and_back_loses_nothing_anywhere() -> None:
    for angles in angles_of_all_kinds():
        wanted = pose(Rotation.from_euler("xyz", angles, degrees=True))
        values = p_from_matrix(wanted)
        assert values[6] == -1
        assert all(-180 <= value <= 180 for value in values[3:6])
        assert abs(values[4]) <= 90
        np.testing.assert_allclose(matrix_from_p(values), wanted, atol=1e-15)
        rotation = Rotation.from_euler("xyz", values[3:6], degrees=True).as_matrix()
        np.testing.assert_allclose(rotation, wanted[:3, :3], atol=1e-15)


def test_matrix_to_p_type_gives_scipys_angles_where_they_are_unique() -> None:
    rng = np.random.default_rng(5)
    for rotation in Rotation.random(200, rng=rng):
        np.testing.assert_allclose(
            p_from_matrix(pose(rotation))[3:6], rotation.as_euler("xyz", degrees=True), atol=1e-9
        )


def test_half_turns_have_the_same_matrix_with_either_sign() -> None:
    for off in NEAR:
        plus = matrix_from_p([0, 0, 0, 180 - off, 0, 180 - off])
        minus = matrix_from_p([0, 0, 0, -180 - off, 0, -180 - off])
        np.testing.assert_allclose(plus, minus, atol=1e-15)


def test_t_type_is_the_y_and_z_columns() -> None:
    rng = np.random.default_rng(6)
    for rotation in Rotation.random(100, rng=rng):
        wanted = pose(rotation)
        values = t_from_matrix(wanted, 5.0)
        np.testing.assert_allclose(values[3:6], rotation.apply([0, 1, 0]), atol=1e-15)
        np.testing.assert_allclose(values[6:9], rotation.apply([0, 0, 1]), atol=1e-15)
        assert values[9] == 5
        np.testing.assert_allclose(matrix_from_t(values), wanted, atol=1e-15)


def test_t_type_with_rounded_vectors_becomes_a_rotation() -> None:
    rng = np.random.default_rng(7)
    for rotation in Rotation.random(50, rng=rng):
        matrix = matrix_from_t(np.round(t_from_matrix(pose(rotation)), 4))
        np.testing.assert_allclose(matrix[:3, :3].T @ matrix[:3, :3], np.eye(3), atol=1e-15)
        assert np.linalg.det(matrix[:3, :3]) == pytest.approx(1)
        assert (Rotation.from_matrix(matrix[:3, :3]).inv() * rotation).magnitude() < 3e-4


@pytest.mark.parametrize("spoilt", [(3, 1.01), (6, 0.98), (7, np.nan)])
def test_t_type_that_is_no_rotation_is_refused(spoilt: tuple[int, float]) -> None:
    values = [0.0, 0, 0, 1, 0, 0, 0, 1, 0, -1]
    values[spoilt[0]] = spoilt[1]
    with pytest.raises(RobotError, match="unit vectors at right angles"):
        matrix_from_t(values)


@pytest.mark.parametrize("answer", [None, "text", [1.0], [1.0, "x"], [1.0, np.inf], 3])
def test_answers_that_are_no_numbers_are_refused_by_name(answer: Value) -> None:
    with pytest.raises(RobotError, match="CurPos: needs 2 finite numbers"):
        numbers(answer, 2, "CurPos")
