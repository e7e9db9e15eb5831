# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Forms that ROS 1 and ROS 2 read. Quaternions are (x, y, z, w), lengths metres, angles rad.

Sources: the arguments of tf2_ros' static_transform_publisher (ROS 1: nine values in a row; ROS 2, Humble and later:
options), camera_calibration_parsers' YAML, easy_handeye2's messages HandeyeCalibrationParameters and
HandeyeCalibration, URDF.
"""

from __future__ import annotations

from xml.sax.saxutils import quoteattr

import yaml

from ..calibration import Calibration
from .frames import FramePose, Frames

_DISTORTION_MODELS = {4: "plumb_bob", 5: "plumb_bob", 8: "rational_polynomial"}


def ros1_command(calibration: Calibration, frames: Frames, name: str) -> str:
    """The command that publishes the camera's frame in ROS 1."""
    pose = FramePose.of(calibration)
    values = " ".join(repr(value) for value in (*pose.xyz, *pose.quaternion))
    return f"rosrun tf2_ros static_transform_publisher {values} {frames.parent_name} {frames.child}\n"


def ros2_command(calibration: Calibration, frames: Frames, name: str) -> str:
    """The command that publishes the camera's frame in ROS 2, Humble and later."""
    pose = FramePose.of(calibration)
    keys = ("x", "y", "z", "qx", "qy", "qz", "qw")
    values = zip(keys, (*pose.xyz, *pose.quaternion), strict=True)
    options = " ".join(f"--{key} {value!r}" for key, value in values)
    names = f"--frame-id {frames.parent_name} --child-frame-id {frames.child}"
    return f"ros2 run tf2_ros static_transform_publisher {options} {names}\n"


def easy_handeye2(calibration: Calibration, frames: Frames, name: str) -> str:
    """A .calib file, to be put into ~/.ros2/easy_handeye2/calibrations under its name.

    There was no marker to track, so tracking_marker_frame is empty; publishing does not use it.
    """
    pose = FramePose.of(calibration)
    effector, base = frames.parent_name, frames.other_name
    if not frames.in_hand:
        effector, base = base, effector
    content = {
        "parameters": {
            "name": name,
            "calibration_type": "eye_in_hand" if frames.in_hand else "eye_on_base",
            "robot_base_frame": base,
            "robot_effector_frame": effector,
            "tracking_base_frame": frames.child,
            "tracking_marker_frame": "",
            "freehand_robot_movement": False,
            "move_group_namespace": "/",
            "move_group": "manipulator",
        },
        "transform": {
            "translation": dict(zip("xyz", pose.xyz, strict=True)),
            "rotation": dict(zip("xyzw", pose.quaternion, strict=True)),
        },
    }
    return yaml.safe_dump(content, sort_keys=False)


def camera_info(calibration: Calibration, frames: Frames, name: str) -> str:
    """The camera's own parameters as camera_calibration_parsers reads them; ValueError where ROS has no place for one.

    The projection matrix is that of the raw image, (K | 0): a single camera is not rectified against another.
    """
    K, D = calibration.camera_matrix, calibration.distortion_coefficients
    model = _DISTORTION_MODELS.get(len(D))
    if model is None:
        raise ValueError(f"camera-info: ROS knows 4, 5 or 8 distortion coefficients, the calibration has {len(D)}")
    if K[0, 1] != 0:
        raise ValueError(f"camera-info: ROS ignores skew, the calibration has {K[0, 1]:g} px; calibrate without --skew")
    five = [*D.tolist(), 0.0] if len(D) == 4 else D.tolist()
    projection = [*K[0].tolist(), 0.0, *K[1].tolist(), 0.0, *K[2].tolist(), 0.0]
    content = {
        "image_width": calibration.image_width,
        "image_height": calibration.image_height,
        "camera_name": name,
        "camera_matrix": _matrix(3, 3, K.ravel().tolist()),
        "distortion_model": model,
        "distortion_coefficients": _matrix(1, len(five), five),
        "rectification_matrix": _matrix(3, 3, [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]),
        "projection_matrix": _matrix(3, 4, projection),
    }
    return yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=200)


def _matrix(rows: int, cols: int, data: list[float]) -> dict[str, object]:
    return {"rows": rows, "cols": cols, "data": data}


def urdf(calibration: Calibration, frames: Frames, name: str) -> str:
    """A link and a fixed joint to paste between the <robot> tags of a URDF or xacro file."""
    pose = FramePose.of(calibration)
    xyz, rpy = (" ".join(repr(value) for value in values) for values in (pose.xyz, pose.rpy))
    return (
        f"<link name={quoteattr(frames.child)}/>\n"
        f'<joint name={quoteattr(f"{frames.child}_joint")} type="fixed">\n'
        f"  <parent link={quoteattr(frames.parent_name)}/>\n"
        f"  <child link={quoteattr(frames.child)}/>\n"
        f'  <origin xyz="{xyz}" rpy="{rpy}"/>\n'
        "</joint>\n"
    )
