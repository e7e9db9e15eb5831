# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Options that contradict each other are refused, and what is kept is named for the result file."""

from __future__ import annotations

import numpy as np
import pytest
from support.recordings import known_distortion

from cv_active_handeye.config import CalibrationOptions


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"lens_model": "k1"}, "lens_model: needs unknown distortion for 'k1'"),
        ({"distortion_coefficients": np.zeros(8)}, "distortion_coefficients: needs k1, k2, p1, p2"),
        ({"robot_translation_mm": 0.0}, "need both 0"),
        ({"robot_rotation_deg": -1.0}, "robot_rotation_deg"),
    ],
)
def test_options_refuse_what_does_not_go_together(changes: dict[str, object], text: str) -> None:
    with pytest.raises(ValueError, match=text):
        known_distortion(**changes)


def test_options_refuse_a_known_camera_with_square_pixels() -> None:
    with pytest.raises(ValueError, match="square_pixels: needs an unknown camera matrix"):
        known_distortion(square_pixels=True, camera_matrix=np.eye(3))


@pytest.mark.parametrize(
    ("changes", "names"),
    [
        ({}, ("zero_skew",)),
        ({"zero_skew": False}, ()),
        ({"lens_model": "none"}, ("zero_skew", "no_distortion")),
        ({"lens_model": "k1"}, ("zero_skew",)),
        ({"square_pixels": True}, ("zero_skew", "square_pixels")),
        ({"camera_matrix": np.eye(3)}, ("known_camera_matrix", "no_distortion")),
        ({"camera_matrix": np.eye(3), "lens_model": "k1"}, ("known_camera_matrix",)),
        ({"robot_translation_mm": 0.0, "robot_rotation_deg": 0.0}, ("zero_skew", "exact_robot")),
        ({"robot_rotation_deg": 0.1}, ("zero_skew", "known_robot_rotation_noise")),
    ],
)
def test_constraints_name_what_is_not_estimated(changes: dict[str, object], names: tuple[str, ...]) -> None:
    assert CalibrationOptions.model_validate(changes).constraints() == names
