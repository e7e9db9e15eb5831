# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A calibration in the forms that other programs read."""

from .formats import FORMATS, NotUsableError, check_usable, export
from .frames import FramePose, Frames

__all__ = ["FORMATS", "FramePose", "Frames", "NotUsableError", "check_usable", "export"]
