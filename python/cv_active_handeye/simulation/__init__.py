# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A simulated robot cell to practise with: rendered images, a robot with errors, a laser, and the truth apart."""

from ..robots.kinematics import UnreachableError
from .cell import SimulatedCell, SimulatedView
from .config import CellConfig
from .exact import StripeTruth
from .nominal import nominal_planning
from .truth import TrueView, Truth

__all__ = [
    "CellConfig",
    "SimulatedCell",
    "SimulatedView",
    "StripeTruth",
    "TrueView",
    "Truth",
    "UnreachableError",
    "nominal_planning",
]
