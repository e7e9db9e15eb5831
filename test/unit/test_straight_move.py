# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A straight move as its watcher sees it."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from support.denso_emulator import moved

from cv_active_handeye.robots.kinematics import straight_line
from cv_active_handeye.robots.straight_move import StraightMove

START = np.eye(4)
END = moved(START, (60, 0, 0), (0, 0, 20))


def place(mm: tuple[float, float, float], rotvec_deg: tuple[float, float, float]) -> NDArray[np.float64]:
    return moved(START, mm, rotvec_deg)


def test_off_path_is_silent_all_along_the_line() -> None:
    move = StraightMove(START, END)
    assert [move.off_path(pose) for pose in straight_line(START, END, 0.002, 0.5)] == [None] * 41


@pytest.mark.parametrize(
    ("pose", "told"),
    [
        (place((30, 2.1, 0), (0, 0, 10)), "2.10 mm from the line"),
        (place((62.2, 0, 0), (0, 0, 20)), "2.20 mm from the line"),
        (place((-2.3, 0, 0), (0, 0, 0)), "2.30 mm from the line"),
        (place((30, 0, 0), (0, 0, 21.5)), "3.00 deg of needless turn"),
        (place((30, 0, 0), (0, 0, -1.5)), "3.00 deg of needless turn"),
    ],
)
def test_off_path_names_how_far_a_pose_beyond_2_mm_or_2_deg_is(pose: NDArray[np.float64], told: str) -> None:
    assert told in str(StraightMove(START, END).off_path(pose))


def test_off_path_of_a_pure_rotation_does_not_depend_on_a_direction() -> None:
    move = StraightMove(START, moved(START, (0, 0, 0), (0, 15, 0)))
    assert move.off_path(moved(START, (0, 1.9, 0), (0, 7, 0))) is None
    assert "2.10 mm" in str(move.off_path(moved(START, (0, 2.1, 0), (0, 7, 0))))


def test_remaining_accepts_0_05_mm_and_0_01_deg_and_no_more() -> None:
    move = StraightMove(START, END)
    assert move.remaining(moved(END, (0, 0.049, 0), (0.0099, 0, 0))) is None
    assert "0.051 mm" in str(move.remaining(moved(END, (0, 0.051, 0))))
    assert "0.0110 deg" in str(move.remaining(moved(END, (0, 0, 0), (0.011, 0, 0))))


def test_remaining_near_half_a_turn_takes_no_sign_for_a_distance() -> None:
    ends = [Rotation.from_rotvec([0, sign * np.pi, 0]).as_matrix() for sign in (-1, 1)]
    poses = [np.block([[R, np.zeros((3, 1))], [np.zeros((1, 3)), np.ones((1, 1))]]) for R in ends]
    assert StraightMove(START, poses[0]).remaining(poses[1]) is None


def test_deadline_grows_with_length_angle_and_slowness() -> None:
    move = StraightMove(START, END)
    assert move.deadline_s(0.05, 0.2) == pytest.approx(3 + 6 * (0.25 * np.radians(20) / 0.05 + 0.5))
    assert StraightMove(START, moved(START, (0, 0, 100))).deadline_s(0.1, 1.0) == pytest.approx(3 + 6 * (1 + 0.2))
