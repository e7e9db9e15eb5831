# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Arm kinematics against elementary rotations, published values, finite differences and scipy."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from cv_active_handeye.robots.kinematics import ARMS, SerialArm, UnreachableError, arm, straight_line

Array = NDArray[np.float64]
UR5E, DENSO = ARMS["ur5e"], ARMS["denso_vp6242"]
both_arms = pytest.mark.parametrize("robot", [UR5E, DENSO], ids=lambda a: a.name)


def random_joints(robot: SerialArm, rng: np.random.Generator) -> Array:
    """Joints well inside the limits and away from singularities."""
    low = np.maximum(robot.lower, -np.pi) + 0.1
    high = np.minimum(robot.upper, np.pi) - 0.1
    while True:
        q = rng.uniform(low, high)
        if robot.sigma_min(q) > 1.5 * robot.smallest_sigma:
            return np.asarray(q)


def by_elementary_motions(robot: SerialArm, q: Array) -> Array:
    pose = np.eye(4)
    for a, d, alpha, sign, offset, joint in zip(
        robot.a, robot.d, robot.alpha, robot.sign, robot.offset, q, strict=True
    ):
        for axis, angle, shift in (("z", sign * joint + offset, [0, 0, d]), ("x", alpha, [a, 0, 0])):
            step = np.eye(4)
            step[:3, :3] = Rotation.from_euler(axis, angle).as_matrix()
            step[:3, 3] = shift
            pose = pose @ step
    return pose


@both_arms
def test_forward_equals_product_of_elementary_motions(robot: SerialArm) -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        q = random_joints(robot, rng)
        np.testing.assert_allclose(robot.forward(q), by_elementary_motions(robot, q), atol=1e-14)


def test_forward_of_ur5e_at_zero_is_the_published_pose() -> None:
    # UR's own sheet: arm stretched along -x, x = a2 + a3, y = -(d4 + d6), z = d1 - d5.
    expected = np.array([[1, 0, 0, -0.8172], [0, 0, -1, -0.2329], [0, 1, 0, 0.0628], [0, 0, 0, 1.0]])
    np.testing.assert_allclose(UR5E.forward(np.zeros(6)), expected, atol=1e-12)


def test_forward_of_vp6242_with_elbow_at_90_has_the_lengths_of_the_drawing() -> None:
    pose = DENSO.forward(np.radians([0, 0, 90, 0, 90, 0]))
    np.testing.assert_allclose(pose[:3, 3], [0.21, 0, 0.28 + 0.21 + 0.075 - 0.07], atol=1e-12)
    np.testing.assert_allclose(pose[:3, 2], [0, 0, -1], atol=1e-12)


def test_reach_of_vp6242_is_that_of_the_data_sheet() -> None:
    q = np.radians([[0, 90, j3, 0, 0, 0] for j3 in np.linspace(20, 160, 141)])
    wrist = DENSO.forward(q)[:, :3, 3] - 0.07 * DENSO.forward(q)[:, :3, 2]
    assert np.linalg.norm(wrist - [0, 0, 0.28], axis=1).max() == pytest.approx(0.432, abs=0.0015)


@both_arms
def test_jacobian_equals_finite_differences(robot: SerialArm) -> None:
    q, h = random_joints(robot, np.random.default_rng(2)), 1e-6
    J = robot.jacobian(q)
    for i in range(6):
        plus, minus = robot.forward(q + h * np.eye(6)[i]), robot.forward(q - h * np.eye(6)[i])
        turn = Rotation.from_matrix(plus[:3, :3] @ minus[:3, :3].T).as_rotvec() / (2 * h)
        numeric = np.concatenate([(plus - minus)[:3, 3] / (2 * h), turn])
        np.testing.assert_allclose(J[:, i], numeric, atol=1e-8)


@both_arms
def test_inverse_all_contains_the_joints_the_pose_was_made_of(robot: SerialArm) -> None:
    rng = np.random.default_rng(3)
    for _ in range(15):
        q = random_joints(robot, rng)
        solutions = robot.inverse_all(robot.forward(q))
        np.testing.assert_allclose(
            robot.forward(solutions), np.tile(robot.forward(q), (len(solutions), 1, 1)), atol=1e-9
        )
        assert np.abs(np.exp(1j * solutions) - np.exp(1j * q)).max(axis=1).min() < 1e-7


def test_inverse_all_finds_the_eight_branches_of_ur5e() -> None:
    q = np.radians([20, -100, 110, -100, -80, 15])
    assert len(UR5E.inverse_all(UR5E.forward(q))) == 8


@both_arms
def test_inverse_agrees_with_scipy_optimisation(robot: SerialArm) -> None:
    rng = np.random.default_rng(4)
    q = random_joints(robot, rng)
    pose = robot.forward(q)
    start = q + 0.05 * rng.standard_normal(6)

    def error(x: Array) -> Array:
        return np.asarray((by_elementary_motions(robot, x) - pose)[:3].ravel())

    found = least_squares(error, start, xtol=1e-15, ftol=1e-15)
    np.testing.assert_allclose(robot.inverse(pose, near=start), found.x, atol=1e-7)


@both_arms
def test_inverse_keeps_margins_and_prefers_comfortable_solutions(robot: SerialArm) -> None:
    pose = robot.forward(random_joints(robot, np.random.default_rng(5)))
    q = robot.inverse(pose)
    assert robot.limit_margin(q).min() >= robot.margin
    assert robot.sigma_min(q) >= robot.smallest_sigma
    np.testing.assert_allclose(robot.forward(q), pose, atol=1e-9)


def test_inverse_near_keeps_whole_turns() -> None:
    q = np.radians([20, -100, 110, -100, -80, 200])
    np.testing.assert_allclose(UR5E.inverse(UR5E.forward(q), near=q + 0.01), q, atol=1e-8)


def test_inverse_beyond_joint_limit_names_joint_value_and_limits() -> None:
    pose = DENSO.forward(np.radians([10, 20, 168, 5, -30, 0]))
    with pytest.raises(
        UnreachableError, match=r"VP-6242: joint 3 would be at 168\.0 deg; its limits are 20 to 160 deg"
    ):
        DENSO.inverse(pose)


def test_inverse_out_of_reach_names_distance_and_reach() -> None:
    pose = np.eye(4)
    pose[:3, 3] = 0.6, 0.0, 0.35
    with pytest.raises(UnreachableError, match=r"\(600, 0, 350\) mm cannot be taken: its wrist is 600 mm .* 432 mm"):
        DENSO.inverse(pose)


def test_inverse_at_wrist_singularity_says_so() -> None:
    pose = DENSO.forward(np.radians([0, 20, 90, 0, 0.5, 0]))
    with pytest.raises(UnreachableError, match=r"near a singularity: smallest singular value 0\.00"):
        DENSO.inverse(pose)


def test_follow_stays_on_the_straight_line() -> None:
    start = np.radians([10, 10, 80, 20, 70, 30])
    end = DENSO.forward(start)
    end[:3, 3] += [0.03, -0.05, 0.04]
    end[:3, :3] = Rotation.from_rotvec([0.1, -0.2, 0.1]).as_matrix() @ end[:3, :3]
    path = DENSO.follow(start, end)
    poses = DENSO.forward(path)
    np.testing.assert_allclose(poses, straight_line(DENSO.forward(start), end, 0.005, 1.0), atol=1e-9)
    assert np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1).max() <= 0.005 + 1e-9
    assert np.abs(np.diff(path, axis=0)).max() < 0.1


@both_arms
def test_follow_in_long_steps_ends_in_the_joints_of_short_ones(robot: SerialArm) -> None:
    rng, followed = np.random.default_rng(3), 0
    for _ in range(25):
        start = random_joints(robot, rng)
        end = robot.forward(start)
        end[:3, 3] += robot.reach * rng.uniform(-0.25, 0.25, 3)
        end[:3, :3] = Rotation.from_rotvec(rng.uniform(-0.6, 0.6, 3)).as_matrix() @ end[:3, :3]
        try:
            short, long = robot.follow(start, end), robot.follow(start, end, 0.08 * robot.reach, 2.5)
        except UnreachableError:  # a long step may also be too long
            continue
        np.testing.assert_allclose(long[-1], short[-1], atol=1e-8)
        followed += 1
    assert followed >= 8


def test_follow_to_a_pose_out_of_reach_says_where_on_the_way() -> None:
    start = np.radians([0, 20, 80, 0, 60, 0])
    end = DENSO.forward(start)
    end[0, 3] += 0.3
    with pytest.raises(UnreachableError, match=r"on the way"):
        DENSO.follow(start, end)


@pytest.mark.parametrize(
    ("pose", "text"),
    [
        (np.eye(3), r"finite 4 x 4 matrix, got shape \(3, 3\)"),
        (np.full((4, 4), np.nan), "finite 4 x 4 matrix"),
        (np.diag([1.0, 1.0, -1.0, 1.0]), r"needs a rotation"),
        (np.diag([1.001, 1.0, 1.0, 1.0]), r"error of 0\.002"),
        (np.eye(4) + np.eye(4)[[0]].T @ [[0, 0, 0, 1e9]], r"within 100 m of the base, got 1e\+09 m"),
    ],
)
def test_inverse_and_follow_refuse_what_is_no_pose(pose: Array, text: str) -> None:
    with pytest.raises(ValueError, match=text):
        UR5E.inverse(pose)
    with pytest.raises(ValueError, match=text):
        UR5E.follow(np.radians([0, -90, 90, -90, -90, 0]), pose)


def test_arm_with_unknown_name_lists_the_known_ones() -> None:
    with pytest.raises(ValueError, match=r"needs one of \['denso_vp6242', .*'ur5e'\], got 'kuka'"):
        arm("kuka")


@pytest.mark.parametrize(
    ("name", "position_mm"),
    [
        ("ur3e", (-456.75, -223.15, 66.5)),
        ("ur5e", (-817.2, -232.9, 62.8)),
        ("ur10e", (-1184.25, -290.7, 60.85)),
        ("ur16e", (-838.4, -290.7, 60.85)),
    ],
)
def test_forward_of_stretched_ur_arms_is_the_sum_of_their_lengths(
    name: str, position_mm: tuple[float, float, float]
) -> None:
    T = arm(name).forward(np.zeros(6))
    np.testing.assert_allclose(1000 * T[:3, 3], position_mm, atol=1e-9)
    np.testing.assert_allclose(T[:3, :3], [[1, 0, 0], [0, 0, -1], [0, 1, 0]], atol=1e-12)
