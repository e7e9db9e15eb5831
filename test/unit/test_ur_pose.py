# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Pose vectors of a UR controller against the matrix exponential, also at angles near pi."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

from cv_active_handeye.robots.ur_pose import pose_matrix, pose_vector


def exponential(
    v: np.ndarray[tuple[int, ...], np.dtype[np.float64]],
) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    x, y, z = v
    return np.asarray(expm(np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])))


ANGLES = [0.0, 1e-12, 1e-6, 0.1, 1.0, 3.0, np.pi - 1e-3, np.pi - 1e-7, np.pi - 1e-12, np.pi]


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("sign", [1, -1])
def test_pose_matrix_is_the_exponential_and_pose_vector_its_inverse(angle: float, sign: int) -> None:
    rng = np.random.default_rng(7)
    for axis in [*np.eye(3), *(v / np.linalg.norm(v) for v in rng.standard_normal((20, 3)))]:
        t, turn = rng.uniform(-1, 1, 3), sign * angle * axis
        T = pose_matrix([*t, *turn])
        np.testing.assert_allclose(T[:3, :3], exponential(turn), atol=1e-13)
        np.testing.assert_array_equal(T[:3, 3], t)
        np.testing.assert_array_equal(T[3], [0, 0, 0, 1])
        vector = np.array(pose_vector(T))
        assert np.linalg.norm(vector[3:]) <= np.pi + 1e-12
        np.testing.assert_allclose(exponential(vector[3:]), T[:3, :3], atol=1e-9)
        np.testing.assert_allclose(pose_matrix(vector), T, atol=1e-9)


def test_pose_matrix_takes_both_vectors_of_one_turn() -> None:
    rng = np.random.default_rng(8)
    for v in rng.uniform(-3, 3, (50, 3)):
        other = v * (1 - 2 * np.pi / np.linalg.norm(v))
        np.testing.assert_allclose(pose_matrix([0, 0, 0, *v]), pose_matrix([0, 0, 0, *other]), atol=1e-13)


@pytest.mark.parametrize("vector", [[0.0] * 5, [0.0] * 7, [0, 0, 0, 0, 0, np.nan], [np.inf, 0, 0, 0, 0, 0]])
def test_pose_matrix_refuses_what_is_no_pose(vector: list[float]) -> None:
    with pytest.raises(ValueError, match="needs six finite numbers"):
        pose_matrix(vector)
