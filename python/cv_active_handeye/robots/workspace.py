# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Where the arm may be: the boxes and caps that the planner keeps and that every move is checked against again."""

from __future__ import annotations

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator
from scipy.spatial.transform import Rotation

from .base import Array, MoveRefusedError
from .kinematics import SerialArm, UnreachableError, straight_line

Point = tuple[float, float, float]

_STEP_M, _STEP_DEG = 0.005, 1.0  # between the poses of a path that are checked
LARGEST_TURN_DEG = 150.0
"""Of one straight way."""
_WITHIN = 0.99  # of a cap: where a move ends differs a little from where it was to end


class Box(BaseModel):
    """Corners of a box along the axes of the base frame, mm."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    lower_mm: Point
    upper_mm: Point

    @model_validator(mode="after")
    def _not_empty(self) -> Box:
        if not all(low < high for low, high in zip(self.lower_mm, self.upper_mm, strict=True)):
            raise ValueError(f"lower_mm: needs to be below upper_mm {self.upper_mm}, given {self.lower_mm}")
        return self

    def holds(self, points: Array) -> Array:
        """Whether points (..., 3), m, lie inside."""
        mm = 1000 * points
        return np.asarray(((mm >= self.lower_mm) & (mm <= self.upper_mm)).all(axis=-1))

    def text(self) -> str:
        """For messages, to the mm."""
        lower, upper = np.array(self.lower_mm) / 1000, np.array(self.upper_mm) / 1000
        return f"from {mm_text(lower)} to {mm_text(upper)} mm"


class Workspace(BaseModel):
    """What flange, camera and laser must not leave, must not enter, and how far one move may go.

    box: flange and tool points stay inside. no_go: they stay outside of every one of these. tool_points_mm: points of
    camera, laser and bracket in the gripper frame, that obey too. max_step_mm, max_step_deg: longest single move.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    box: Box
    no_go: tuple[Box, ...] = ()
    tool_points_mm: tuple[Point, ...] = ()
    max_step_mm: float = Field(default=100.0, gt=0, le=500)
    max_step_deg: float = Field(default=30.0, gt=0, le=90)

    def check_pose(self, T_gripper2base: Array) -> None:
        """MoveRefusedError where a flange pose (4, 4) puts flange or tool out of the box or into a no-go box."""
        tool = np.array(((0.0, 0.0, 0.0), *self.tool_points_mm)) / 1000
        points = tool @ T_gripper2base[:3, :3].T + T_gripper2base[:3, 3]
        for i, point in enumerate(points):
            what = "the flange" if i == 0 else f"the tool's point {self.tool_points_mm[i - 1]} mm"
            if not self.box.holds(point):
                raise MoveRefusedError(
                    f"workspace: {what} would be at {mm_text(point)} mm, outside of the box {self.box.text()}"
                )
            for box in self.no_go:
                if box.holds(point):
                    raise MoveRefusedError(
                        f"workspace: {what} would be at {mm_text(point)} mm, inside the no-go box {box.text()}"
                    )

    def check_step(self, start: Array, end: Array) -> None:
        """MoveRefusedError where the move from one flange pose (4, 4) to another is longer than the caps."""
        length, angle = step_size(start, end)
        if 1000 * length > self.max_step_mm + 1e-6 or angle > self.max_step_deg + 1e-6:
            raise MoveRefusedError(
                f"workspace: a single move may go {self.max_step_mm:g} mm and {self.max_step_deg:g} deg, "
                f"this one goes {1000 * length:.1f} mm and {angle:.2f} deg"
            )

    def check_path(self, start: Array, end: Array) -> None:
        """`check_pose` all along the straight line between two flange poses (4, 4), every 5 mm and 1 deg.

        A turn near 180 deg is refused: in which sense it goes would depend on the last digit of the poses.
        """
        angle = step_size(start, end)[1]
        if angle > LARGEST_TURN_DEG:
            raise MoveRefusedError(
                f"workspace: a straight way may turn by {LARGEST_TURN_DEG:g} deg, so that its sense is certain; this "
                f"one turns by {angle:.1f} deg and needs a stop in between"
            )
        for pose in straight_line(start, end, _STEP_M, _STEP_DEG):
            self.check_pose(pose)

    def way_points(self, start: Array, end: Array) -> Array:
        """Returns flange poses (N, 4, 4) on the straight line after `start`, `end` last, in moves within the caps."""
        return straight_line(start, end, _WITHIN * self.max_step_mm / 1000, _WITHIN * self.max_step_deg)[1:]


def check_joints(arm: SerialArm, joints: Array, T_gripper2base: Array) -> Array:
    """Returns the joints (6,) after a straight line from `joints` (6,) to a flange pose (4, 4).

    MoveRefusedError names the joint limit, singularity or length in the way.
    """
    try:
        return np.asarray(arm.follow(joints, T_gripper2base)[-1])
    except UnreachableError as error:
        raise MoveRefusedError(str(error)) from error


def step_size(start: Array, end: Array) -> tuple[float, float]:
    """Returns the distance (m) and the angle (deg) between two poses (4, 4)."""
    turn = Rotation.from_matrix(start[:3, :3].T @ end[:3, :3]).magnitude()
    return float(np.linalg.norm(end[:3, 3] - start[:3, 3])), float(np.degrees(turn))


def half_way(start: Array, end: Array) -> Array:
    """Returns the pose (4, 4) in the middle of the straight way between two."""
    length, angle = step_size(start, end)
    return np.asarray(straight_line(start, end, max(length, 1e-9) / 2, max(angle, 1e-9) / 2)[1])


def mm_text(position: Array) -> str:
    """A position (3,), m, as text in mm."""
    return "(" + ", ".join(f"{1000 * x:.0f}" for x in position) + ")"
