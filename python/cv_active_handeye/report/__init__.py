# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Pictures, tables and the HTML page of a calibration."""

from .errors import CalibrationErrors, calibration_errors, inside_intervals, true_parameters
from .page import write_report
from .pictures import picture_motion, picture_points, picture_stripe, picture_tracks, picture_view_errors

__all__ = [
    "CalibrationErrors",
    "calibration_errors",
    "inside_intervals",
    "picture_motion",
    "picture_points",
    "picture_stripe",
    "picture_tracks",
    "picture_view_errors",
    "true_parameters",
    "write_report",
]
