# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Pictures, tables and the HTML page of a calibration."""

from .errors import CalibrationErrors, calibration_errors
from .page import write_report
from .pictures import picture_motion, picture_stripe, picture_tracks

__all__ = [
    "CalibrationErrors",
    "calibration_errors",
    "picture_motion",
    "picture_stripe",
    "picture_tracks",
    "write_report",
]
