# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Pictures and tables of a calibration."""

from .errors import CalibrationErrors, calibration_errors
from .pictures import picture_motion, picture_stripe, picture_tracks

__all__ = ["CalibrationErrors", "calibration_errors", "picture_motion", "picture_stripe", "picture_tracks"]
