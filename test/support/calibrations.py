# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Results of both versions of the file, with numbers that are hard to write down."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from cv_active_handeye.calibration import PARAMETERS, Calibration
from cv_active_handeye.calibration_format import ChiSquare, Lens, NoiseLevel, NoiseLevels, Rms, Tool, Verdict
from cv_active_handeye.simulation import Truth

CLOSED_FORM_PARAMETERS = ("fx", "fy", "cx", "cy", "skew", "rx", "ry", "rz", "tx", "ty", "tz", "nx", "ny", "nz", "d")


def refined(**changes: Any) -> Calibration:
    """A result of version 2 in which every key has a value."""
    rng = np.random.default_rng(5)
    root = rng.normal(size=(20, 20)) * 10.0 ** rng.integers(-12, 3, (20, 20))
    lower = rng.normal(size=20)
    values = _common(rng) | {
        "parameter_names": PARAMETERS,
        "covariance": root @ root.T,
        "degrees_of_freedom": 10.0 ** rng.uniform(0, 6, 20),
        "intervals_95": np.column_stack([lower, lower + rng.uniform(size=20)]),
        "rms": Rms(points_px=1 / 3, stripes_px=1e-9),
        "verdict": _verdict(),
        "tool": Tool(working_distance=0.55, accuracy=1e-5, covariance=1e-9 * np.eye(3)),
        "noise_levels": NoiseLevels(
            image_points=NoiseLevel(level=0.1, lower=0.09, upper=0.11, estimated=True),
            stripes=NoiseLevel(level=0.05, lower=0.04, upper=1e5, estimated=True),
            robot_translation=NoiseLevel(level=2e-5, lower=1e-5, upper=3e-5, estimated=True),
            robot_rotation=NoiseLevel(level=1e-4, lower=1e-4, upper=1e-4, estimated=False),
            stated_points_px=0.07,
        ),
        "lens": Lens(model="k1-k2", chosen=True, tests=rng.normal(size=(5, 4))),
        "chi_square": ChiSquare(value=1591.2, degrees_of_freedom=1604, p_value=0.585),
    }
    return Calibration(**(values | changes))


def true_calibration(truth: Truth, **changes: Any) -> Calibration:
    """The calibration of a simulated cell, without an error."""
    values = {
        "image_width": 640,
        "image_height": 480,
        "camera_matrix": truth.camera_matrix,
        "distortion_coefficients": truth.distortion_coefficients,
        "R_cam2gripper": truth.R_cam2gripper,
        "t_cam2gripper": truth.t_cam2gripper,
        "light_plane": truth.light_plane,
    }
    return refined(**(values | changes))


def closed_form(**changes: Any) -> Calibration:
    """A result of version 1."""
    rng = np.random.default_rng(5)
    root = rng.normal(size=(15, 15)) * 10.0 ** rng.integers(-12, 3, (15, 15))
    values = _common(rng) | {
        "parameter_names": CLOSED_FORM_PARAMETERS,
        "covariance": root @ root.T,
        "rms": Rms(translations_px=0.1, rotation_px=1e-9, light_plane_px=0.05),
    }
    return Calibration(**(values | changes))


def _common(rng: np.random.Generator) -> dict[str, Any]:
    return {
        "software_version": "0.1.0",
        "dataset_sha256": "12e4567",
        "constraints": ("zero_skew", "no_distortion"),
        "image_width": 640,
        "image_height": 480,
        "camera_matrix": [[1413.1, 1e-7, 320.2], [0, 1e3 + 1 / 3, 240.3], [0, 0, 1]],
        "distortion_coefficients": [-0.1, 1e-5, 0, 5e-324, 1e16],
        "R_cam2gripper": Rotation.random(random_state=rng).as_matrix(),
        "t_cam2gripper": [1e-5, -0.1, 1 / 3],
        "light_plane": [0.0, 0.6, 0.8, 0.3],
        "views": 14,
        "points": 1000,
        "observations": 5000,
        "stripe_segments": 60,
    }


def _verdict() -> Verdict:
    return Verdict(
        usable=True,
        message='usable: "a point" at 0.4 is known to ± 0.00029 (95 %): \\ {all} [of] it, #1 & more',
        stop_reason="relative change of the cost below 1e-12",
        rejected_views=(3,),
        rejected_observations=17,
        rejected_segments=(),
        culprits=("view 3: its reported pose is off by 2.0 mm", "- no, yes: true"),
        weak_directions=(),
    )
