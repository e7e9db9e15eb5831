# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Whether a DENSO controller means by RX, RY, RZ what is assumed here, asked before a pose of it is believed."""

from __future__ import annotations

import numpy as np

from . import kinematics
from .base import RobotUnavailableError
from .denso_link import DensoLink
from .denso_pose import ANY_FIGURE, P_SIZE, T_SIZE, matrix_from_p, matrix_from_t, numbers
from .workspace import step_size

# No two of the usual conventions agree on any of these (mm, deg).
_POSES = (
    (300.0, 0.0, 300.0, 170.0, 10.0, 80.0),
    (250.0, -60.0, 200.0, 150.0, -20.0, 35.0),
    (200.0, 90.0, 250.0, -100.0, 60.0, -140.0),
)
_DIRECTION, _POSITION_M = 1e-4, 1e-6
_SAME_POSE_M, _SAME_POSE_DEG = 0.1e-3, 0.02
_MODEL_M, _MODEL_DEG = 0.02, 3.0
"""Nominal geometry is this good at the worst; a wrong convention is off by tens of degrees in most poses."""


def check_convention(link: DensoLink) -> None:
    """Compares the controller's own conversion (P2T) of three poses, and of where it stands, with that of this file.

    RobotUnavailableError where the directions differ by more than 1e-4.
    """
    for given in _POSES:
        wanted = matrix_from_p(given)
        answer = numbers(link.execute("P2T", [*given, ANY_FIGURE]), T_SIZE, "P2T")
        said = np.column_stack([answer[3:6], answer[6:9]])
        off = np.abs(said - wanted[:3, 1:3]).max()
        if off > _DIRECTION or np.abs(answer[:3] / 1000 - wanted[:3, 3]).max() > _POSITION_M:
            raise RobotUnavailableError(
                f"P2T: the controller turns {given} into directions that differ by {off:.3g} from Rz Ry Rx "
                f"({_DIRECTION:g} is allowed). Its angles mean something else; poses of it would be wrong"
            )
    current = matrix_from_p(numbers(link.execute("CurPos"), P_SIZE, "CurPos"))
    length, angle = step_size(current, matrix_from_t(numbers(link.execute("CurTrn"), T_SIZE, "CurTrn")))
    if length > _SAME_POSE_M or angle > _SAME_POSE_DEG:
        raise RobotUnavailableError(
            f"CurPos and CurTrn differ by {1000 * length:.3f} mm and {angle:.3f} deg: "
            "the arm moves, or the controller's angles mean something else"
        )


def check_convention_by_model(link: DensoLink, model: str) -> None:
    """Compares the pose a controller without P2T says with that of the model's nominal geometry at its joints.

    This finds another convention of the angles, other joint zeros and an active tool, but not small errors.
    RobotUnavailableError beyond 20 mm or 3 deg.
    """
    current = matrix_from_p(numbers(link.execute("CurPos"), P_SIZE, "CurPos"))
    joints = np.radians(numbers(link.execute("CurJnt"), 6, "CurJnt")[:6])
    length, angle = step_size(current, kinematics.arm(model).forward(joints))
    if length > _MODEL_M or angle > _MODEL_DEG:
        raise RobotUnavailableError(
            f"CurPos is {1000 * length:.0f} mm and {angle:.1f} deg away from what {model} takes at its joints "
            f"({1000 * _MODEL_M:g} mm and {_MODEL_DEG:g} deg are allowed): another model, an active tool, or angles "
            "that mean something else"
        )


def check_flange(link: DensoLink) -> None:
    """RobotUnavailableError where a tool or work frame is active, for poses are then not those of flange and base."""
    for command, name in (("CurTool", "tool"), ("CurWork", "work frame")):
        number = link.execute(command)
        if number != 0:
            raise RobotUnavailableError(f"{name} {number} is active: select {name} 0 at the pendant ({command})")
