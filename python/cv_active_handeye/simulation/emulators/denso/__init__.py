# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A DENSO controller that speaks b-CAP around an emulated arm.

The order of calls, result codes and time behaviour follow DENSO's documents and public clients; what a controller does
where these are silent is assumed: codes and texts of motion errors, that a halted motion ends with E_ABORT, that a lost
connection stops its motion and gives the arm back.
"""

from .emulator import DENSO_FAULTS, DensoEmulator
from .profiles import PROFILES, Profile

__all__ = ["DENSO_FAULTS", "PROFILES", "DensoEmulator", "Profile"]
