# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Controllers that speak a real robot's protocol around a simulated arm: to practise with, and to be tested against."""

from .arm import EmulatedArm, EmulatorStop
from .control import ControlPort
from .faults import FAULTS, FaultPlan, Faults
from .link import EmulatorLink, EmulatorLinkError
from .log import EventLog, moves_after_stop, read_events
from .server import ListenError, ProtocolViolation, Server
from .state import ArmState

__all__ = [
    "FAULTS",
    "ArmState",
    "ControlPort",
    "EmulatedArm",
    "EmulatorLink",
    "EmulatorLinkError",
    "EmulatorStop",
    "EventLog",
    "FaultPlan",
    "Faults",
    "ListenError",
    "ProtocolViolation",
    "Server",
    "moves_after_stop",
    "read_events",
]
