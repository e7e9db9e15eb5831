# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What a plan is made from, before anything is calibrated: rough mounting and optics, limits, and what is asked."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator
from scipy.spatial.transform import Rotation

import cv_active_handeye as cah

from ..calibration_format import LENS_NAMES, LensName
from ..files import FloatArray
from ..robots.base import Speed
from ..robots.workspace import Point, Workspace

LightPlane = tuple[float, float, float, float]


class PlanSettings(BaseModel):
    """Settings of `plan`; unknown keys are refused. Nothing here has to be better than a ruler and a data sheet.

    image_width, image_height: px. focal_px or field_of_view_deg (of the image's width): one of the two; the principal
    point is taken in the middle. t_cam2gripper_mm and R_cam2gripper_deg (rotation vector): how the camera is mounted.
    stand_off_mm: from the camera to what it looks at from the start pose; scene_depth_mm: how far this reaches before
    and behind. light_plane_mm: nx, ny, nz, d of the laser, n.X = d in the camera frame, d in mm; None = no laser.
    camera_known: the camera matrix is calibrated already and will be kept. lens_model: distortion coefficients that
    the calibration will estimate.

    stops: how many, or target_sigma_mm: as few as predict this standard deviation of t_cam2gripper (root of the sum of
    the three variances), at most `most_stops`. translation_mm: the camera leaves the middle of a group by as much
    along each of its axes; tilt_deg: about the image's axes; roll_deg: about the optical axis. seen_share: share of the
    scene that every image has to show.

    tracks: scene points that an image from the start would show. point_sigma_px, stripe_sigma_px, robot_mm,
    robot_deg: standard deviations per coordinate of image points, stripe lines and robot poses; robot_mm and robot_deg
    both 0 = an exact robot. speed, turn_deg_per_second and settle_seconds: for the motor time. seed: of the assumed
    scene.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    workspace: Workspace
    image_width: int = Field(ge=16)
    image_height: int = Field(ge=16)
    focal_px: float | None = Field(default=None, gt=0)
    field_of_view_deg: float | None = Field(default=None, gt=1, lt=170)
    t_cam2gripper_mm: Point
    R_cam2gripper_deg: Point = (0.0, 0.0, 0.0)
    stand_off_mm: float = Field(gt=0)
    scene_depth_mm: float = Field(default=60.0, ge=0)
    light_plane_mm: LightPlane | None = None
    camera_known: bool = False
    lens_model: LensName = "none"

    stops: int | None = Field(default=None, ge=4)
    target_sigma_mm: float | None = Field(default=None, gt=0)
    most_stops: int = Field(default=40, ge=8)
    translation_mm: float = Field(default=80.0, gt=0)
    tilt_deg: float = Field(default=25.0, gt=0, le=60)
    roll_deg: float = Field(default=180.0, ge=0, le=180)
    seen_share: float = Field(default=0.3, gt=0, le=1)

    tracks: int = Field(default=150, ge=10)
    point_sigma_px: Annotated[float, Field(gt=0)] = 0.1
    stripe_sigma_px: float = Field(default=0.1, gt=0)
    robot_mm: float = Field(default=0.02, ge=0)
    robot_deg: float = Field(default=0.005, ge=0)
    speed: Speed = Speed()
    turn_deg_per_second: float = Field(default=15.0, gt=0)
    settle_seconds: float = Field(default=1.0, ge=0)
    seed: int = Field(default=0, ge=0)

    @model_validator(mode="after")
    def _consistent(self) -> PlanSettings:
        if (self.focal_px is None) == (self.field_of_view_deg is None):
            given = "neither" if self.focal_px is None else "both"
            raise ValueError(f"focal_px, field_of_view_deg: needs one of the two, given {given}")
        if (self.stops is None) == (self.target_sigma_mm is None):
            given = "neither" if self.stops is None else "both"
            raise ValueError(f"stops, target_sigma_mm: needs one of the two, given {given}")
        if (self.robot_mm == 0) != (self.robot_deg == 0):
            raise ValueError("robot_mm, robot_deg: need both 0 (an exact robot) or neither")
        if self.light_plane_mm is not None and not self.light_plane_mm[3] > 0:
            raise ValueError(f"light_plane_mm: needs d > 0, given {self.light_plane_mm[3]:g}")
        return self

    @property
    def camera_matrix(self) -> FloatArray:
        """The assumed one (3, 3), px."""
        focal = self.focal_px
        if focal is None:
            assert self.field_of_view_deg is not None
            focal = self.image_width / 2 / np.tan(np.radians(self.field_of_view_deg) / 2)
        middle = (self.image_width - 1) / 2, (self.image_height - 1) / 2
        return np.array([[focal, 0, middle[0]], [0, focal, middle[1]], [0, 0, 1]])

    @property
    def T_cam2gripper(self) -> FloatArray:
        """The assumed mounting (4, 4), m."""
        out = np.eye(4)
        out[:3, :3] = Rotation.from_rotvec(np.radians(self.R_cam2gripper_deg)).as_matrix()
        out[:3, 3] = np.array(self.t_cam2gripper_mm) / 1000
        return out

    @property
    def light_plane(self) -> FloatArray | None:
        """nx, ny, nz of length 1, d, m."""
        if self.light_plane_mm is None:
            return None
        plane = np.array(self.light_plane_mm) / np.linalg.norm(self.light_plane_mm[:3])
        return np.asarray(plane * [1, 1, 1, 0.001])

    def refine_params(self) -> cah.RefineParams:
        """Noise levels and flags for the predictions."""
        params = cah.RefineParams()
        params.lensModel = LENS_NAMES.index(self.lens_model)
        params.flags = int(cah.REFINE_FIX_K) if self.camera_known else 0
        params.pointSigma, params.stripeSigma = self.point_sigma_px, self.stripe_sigma_px
        params.robotTranslationSigma = self.robot_mm / 1000
        params.robotRotationSigma = float(np.radians(self.robot_deg))
        return params
