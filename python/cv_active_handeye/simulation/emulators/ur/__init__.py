# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A UR controller around an emulated arm: RTDE, program port and dashboard."""

from .controller import VERSIONS, UrController
from .emulator import UrEmulator

__all__ = ["VERSIONS", "UrController", "UrEmulator"]
