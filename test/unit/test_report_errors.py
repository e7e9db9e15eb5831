# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Errors against a truth: angles of all sizes, units, and which intervals hold it."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.calibrations import refined

from cv_active_handeye.report.errors import (
    angle_between_deg,
    calibration_errors,
    inside_intervals,
    rotation_angle_deg,
    rotation_vector_deg,
    true_parameters,
)

SIZES = (1e-9, 1e-7, 1e-5, 0.9e-3, 1.1e-3, 0.1, 1.0, 3.0, np.pi - 1e-4, np.pi)


@pytest.mark.parametrize("size", SIZES)
def test_rotation_angle_is_right_at_every_size(size: float) -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        axis = rng.normal(size=3)
        R = Rotation.from_rotvec(size * axis / np.linalg.norm(axis)).as_matrix()
        assert np.radians(rotation_angle_deg(R)) == pytest.approx(size, rel=1e-6, abs=1e-15)


@pytest.mark.parametrize("size", SIZES[:-1])
def test_rotation_vector_is_right_at_every_size(size: float) -> None:
    rng = np.random.default_rng(2)
    for _ in range(20):
        axis = rng.normal(size=3)
        vector = size * axis / np.linalg.norm(axis)
        found = np.radians(rotation_vector_deg(Rotation.from_rotvec(vector).as_matrix()))
        assert found == pytest.approx(vector, rel=1e-6, abs=1e-6 * size)


def test_rotation_angle_of_no_rotation_is_zero() -> None:
    assert rotation_angle_deg(np.eye(3)) == 0
    assert rotation_vector_deg(np.eye(3)).tolist() == [0, 0, 0]


@pytest.mark.parametrize("size", [1e-9, 1e-3, 1.0, 3.0])
def test_angle_between_is_right_at_every_size(size: float) -> None:
    a = np.array([0.3, -0.2, 0.9])
    turn = Rotation.from_rotvec(size * np.array([0.9, 0, -0.3]) / np.linalg.norm([0.9, 0, -0.3]))
    assert np.radians(angle_between_deg(a, 2 * turn.apply(a))) == pytest.approx(size, rel=1e-6)


def truth_of(**changes: object) -> SimpleNamespace:
    """The values of `refined()` as truth, some of them changed."""
    names = ("camera_matrix", "distortion_coefficients", "R_cam2gripper", "t_cam2gripper", "light_plane")
    return SimpleNamespace(**{name: getattr(refined(), name) for name in names} | changes)


def test_errors_are_in_the_units_people_measure_in() -> None:
    estimate = refined()
    K = estimate.camera_matrix * np.array([[1 / 1.01, 1, 1], [1, 1 / 0.98, 1], [1, 1, 1]])
    K[:2, 2] += [0.3, -0.4]
    turn = Rotation.from_rotvec(np.radians([0.003, 0, 0.004])).as_matrix()
    tilted = Rotation.from_rotvec(np.radians([0.02, 0, 0])).as_matrix() @ [0.0, 0.6, 0.8]
    truth = truth_of(
        camera_matrix=K,
        R_cam2gripper=turn @ estimate.R_cam2gripper,
        t_cam2gripper=estimate.t_cam2gripper + np.array([0, 3e-4, -4e-4]),
        light_plane=np.append(tilted, 0.3002),
    )
    errors = calibration_errors(estimate, truth)
    assert errors.fx_percent == pytest.approx(1, rel=1e-9)
    assert errors.fy_percent == pytest.approx(2, rel=1e-9)
    assert (errors.cx_px, errors.cy_px) == pytest.approx((0.3, 0.4))
    assert errors.rotation_deg == pytest.approx(0.005, rel=1e-9)
    assert errors.translation_mm == pytest.approx(0.5)
    assert errors.plane_normal_deg == pytest.approx(0.02, rel=1e-6)
    assert errors.plane_offset_mm == pytest.approx(0.2)


def test_without_a_light_plane_its_errors_are_none() -> None:
    for estimate, truth in ((refined(light_plane=None), truth_of()), (refined(), truth_of(light_plane=None))):
        errors = calibration_errors(estimate, truth)
        assert (errors.plane_normal_deg, errors.plane_offset_mm) == (None, None)
        assert "nx" not in true_parameters(estimate, truth)


def test_true_rotation_error_turns_the_estimate_into_the_truth() -> None:
    """True R = exp(rx, ry, rz) R_cam2gripper, as in the covariance."""
    vector = np.array([1e-4, -2e-5, 3e-8])
    estimate = refined()
    truth = truth_of(R_cam2gripper=Rotation.from_rotvec(vector).as_matrix() @ estimate.R_cam2gripper)
    values = true_parameters(estimate, truth)
    assert [values[name] for name in ("rx", "ry", "rz")] == pytest.approx(vector.tolist(), rel=1e-6, abs=1e-15)


def test_true_parameters_fill_up_short_distortion() -> None:
    values = true_parameters(refined(), truth_of(distortion_coefficients=np.array([0.1, 0.2, 0.3, 0.4])))
    assert [values[name] for name in ("k1", "k2", "p1", "p2", "k3")] == [0.1, 0.2, 0.3, 0.4, 0]


def test_only_intervals_of_what_was_estimated_are_counted() -> None:
    covariance = np.diag(np.full(20, 1e-6))
    covariance[4, 4] = 0  # skew was kept
    truth = truth_of()
    values = np.array(list(true_parameters(refined(), truth).values()))
    intervals = np.column_stack([values - 1e-3, values + 1e-3])
    intervals[0] += 1.0
    inside = inside_intervals(refined(covariance=covariance, intervals_95=intervals), truth)
    assert "skew" not in inside
    assert [name for name, holds in inside.items() if not holds] == ["fx"]
    assert len(inside) == 19
