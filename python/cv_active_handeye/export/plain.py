# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The result without its statistics: for cv::FileStorage, and as plain JSON."""

from __future__ import annotations

import json
import math
from typing import Annotated, Any

import numpy as np
from pydantic import create_model

from ..calibration import Calibration
from ..calibration_format import Part, matrix
from ..files import FloatArray
from ..opencv_yaml import emit
from .frames import FramePose, Frames, homogeneous


def opencv_yaml(calibration: Calibration, frames: Frames, name: str) -> str:
    """Keys as OpenCV's own tools have them, and R_cam2gripper, t_cam2gripper (eye-on-base: R_cam2base, t_cam2base)."""
    place = "gripper" if frames.in_hand else "base"
    values: dict[str, Any] = {
        "image_width": calibration.image_width,
        "image_height": calibration.image_height,
        "camera_matrix": calibration.camera_matrix,
        "distortion_coefficients": calibration.distortion_coefficients,
        f"R_cam2{place}": calibration.R_cam2gripper,
        f"t_cam2{place}": calibration.t_cam2gripper,
    }
    if calibration.light_plane is not None:
        values["light_plane"] = calibration.light_plane
    array = Annotated[FloatArray, matrix(lambda value: np.asarray(value, np.float64))]
    fields: dict[str, Any] = {key: (int if isinstance(value, int) else array, value) for key, value in values.items()}
    return emit(create_model("OpencvExport", __base__=Part, **fields)())


def plain_json(calibration: Calibration, frames: Frames, name: str) -> str:
    """Everything a program needs to measure; a standard deviation that is infinite (not observed) is null."""
    K, D, pose = calibration.camera_matrix, calibration.distortion_coefficients, FramePose.of(calibration)
    plane = calibration.light_plane
    sigmas = {key: calibration.standard_deviation(key) for key in calibration.parameter_names}
    content = {
        "name": name,
        "units": {"length": "m", "angle": "rad", "image": "px"},
        "mounting": frames.mounting,
        "parent_frame": frames.parent_name,
        "child_frame": frames.child,
        "camera": {
            "width": calibration.image_width,
            "height": calibration.image_height,
            "camera_matrix": K.tolist(),
            "distortion_coefficients": D.tolist(),
        },
        "camera_to_parent": {
            "matrix": homogeneous(calibration).tolist(),
            "translation": pose.xyz,
            "quaternion_xyzw": pose.quaternion,
            "rpy_fixed_axes": pose.rpy,
        },
        "light_plane": None if plane is None else {"normal": plane[:3].tolist(), "distance": float(plane[3])},
        "standard_deviations": {key: value if math.isfinite(value) else None for key, value in sigmas.items()},
        "usable": calibration.verdict.usable if calibration.verdict is not None else None,
    }
    return json.dumps(content, indent=2, allow_nan=False) + "\n"
