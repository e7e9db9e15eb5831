# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""`plan.yaml`: the stops of a capture in their order, the workspace they keep, and a hash that ties the two.

A plan that was edited by hand no longer has the hash of its content and is refused: nothing moves on numbers that
nobody has checked. The keys are described in doc/files.md.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Literal

import numpy as np
import yaml
from pydantic import Field

from .dataset_format import Strict
from .files import (
    FileFormatError,
    FloatArray,
    Rotation,
    Vector3,
    check_schema_version,
    read_yaml,
    validate,
    write_atomic,
)
from .robots.workspace import Workspace

SCHEMA_VERSION = 1


class PlannedPose(Strict):
    """A flange pose, gripper to base, m."""

    R_gripper2base: Rotation
    t_gripper2base: Vector3

    @property
    def T_gripper2base(self) -> FloatArray:
        """The same as a matrix (4, 4)."""
        out = np.eye(4)
        out[:3, :3], out[:3, 3] = self.R_gripper2base, self.t_gripper2base
        return out


class PlannedStop(PlannedPose):
    """One stop. group: stops of equal orientation; laser: whether an image with the laser on is taken, too."""

    group: int = Field(ge=0)
    laser: bool = True


class Prediction(Strict):
    """Predicted standard deviations after the first `stops` stops; None = not determined by so few."""

    stops: int = Field(ge=1)
    t_cam2gripper_mm: float | None
    R_cam2gripper_deg: float | None
    fx_percent: float | None
    light_plane_mm: float | None = None


class Plan(Strict):
    """Where the arm will go.

    robot: `Robot.name`; model: key of `kinematics.ARMS` or None; start: the pose it was planned from.
    """

    schema_version: Literal[1] = 1
    units: Literal["m"] = "m"
    robot: str
    model: str | None
    start: PlannedPose
    workspace: Workspace
    stops: tuple[PlannedStop, ...] = Field(min_length=1)
    predictions: tuple[Prediction, ...] = ()

    def sha256(self) -> str:
        """Hash of everything the plan says."""
        return hashlib.sha256(json.dumps(self.model_dump(mode="json"), sort_keys=True).encode()).hexdigest()

    def save(self, path: Path) -> None:
        """Writes the plan with its hash, atomically."""
        content = {**self.model_dump(mode="json"), "sha256": self.sha256()}
        write_atomic(path, yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=200).encode())

    @classmethod
    def load(cls, path: Path) -> Plan:
        """Reads a plan; FileFormatError where it cannot be read or was changed since it was made."""
        content = read_yaml(path, "plan")
        check_schema_version(path, content, "plan", SCHEMA_VERSION)
        said = content.pop("sha256", None)
        plan = validate(cls, content, path)
        if said != plan.sha256():
            raise FileFormatError(f"{path}: key 'sha256': the plan was changed since it was made; plan again")
        return plan
