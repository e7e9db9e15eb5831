# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Names of frames, and the pose of the camera between them.

The camera's frame is OpenCV's: x to the right of the image, y down, z along the optical axis. ROS calls that an optical
frame (REP 103); the frame of a camera's body has x forward and is another one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field
from scipy.spatial.transform import Rotation

from ..calibration import Calibration
from ..files import FloatArray

_NAME = r"^[A-Za-z][A-Za-z0-9_/.-]*$"  # tf2 refuses a leading slash, and no tool likes blanks
FLANGE, BASE, CAMERA = "tool0", "base", "camera_optical_frame"


class Frames(BaseModel):
    """Which frames the exported pose relates.

    mounting: "eye-in-hand" = the camera is on the arm, the pose is camera to gripper; "eye-on-base" = the camera stands
    and the calibration was made with inverted robot poses, the pose is camera to base. parent: the robot's frame on
    that side, as the poses of the recording had it: the flange (default tool0), or the controller's base (default base;
    the base_link of ROS' UR description is turned by 180 degrees against it). child: the camera's optical frame.
    other: the robot's frame on the other side, of which only easy_handeye2 wants the name.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    mounting: Literal["eye-in-hand", "eye-on-base"] = "eye-in-hand"
    parent: str | None = Field(default=None, pattern=_NAME)
    child: str = Field(default=CAMERA, pattern=_NAME)
    other: str | None = Field(default=None, pattern=_NAME)

    @property
    def in_hand(self) -> bool:
        """Whether the camera is on the arm."""
        return self.mounting == "eye-in-hand"

    @property
    def parent_name(self) -> str:
        """`parent`, or its default."""
        return self.parent or (FLANGE if self.in_hand else BASE)

    @property
    def other_name(self) -> str:
        """`other`, or its default."""
        return self.other or (BASE if self.in_hand else FLANGE)


@dataclass(frozen=True)
class FramePose:
    """Where the camera's frame is in the parent's: p_parent = R p_camera + t.

    xyz: t, m. quaternion: of R, (x, y, z, w), w >= 0. rpy: roll, pitch, yaw about the parent's fixed axes x, y, z in
    this order, R = Rz(yaw) Ry(pitch) Rx(roll), rad; where pitch is +-90 degrees, yaw is taken as 0.
    """

    xyz: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]
    rpy: tuple[float, float, float]

    @classmethod
    def of(cls, calibration: Calibration) -> FramePose:
        """The pose of a calibration."""
        R, t = calibration.R_cam2gripper, calibration.t_cam2gripper
        x, y, z, w = Rotation.from_matrix(R).as_quat().tolist()
        sign = -1.0 if w < 0 else 1.0
        return cls(
            (float(t[0]), float(t[1]), float(t[2])),
            (sign * x, sign * y, sign * z, sign * w),
            _roll_pitch_yaw(R),
        )


def _roll_pitch_yaw(R: FloatArray) -> tuple[float, float, float]:
    across = math.hypot(R[0, 0], R[1, 0])
    pitch = math.atan2(-R[2, 0], across)
    if across < 1e-9:  # roll and yaw turn about the same axis
        return math.atan2(-R[1, 2], R[1, 1]), pitch, 0.0
    return math.atan2(R[2, 1], R[2, 2]), pitch, math.atan2(R[1, 0], R[0, 0])


def homogeneous(calibration: Calibration) -> FloatArray:
    """Camera to parent, (4, 4)."""
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = calibration.R_cam2gripper, calibration.t_cam2gripper
    return T
