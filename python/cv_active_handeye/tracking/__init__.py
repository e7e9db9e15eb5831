# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Images of one recording -> `imagePoints` of the calibration functions (detect, match, merge, refine)."""

from .config import TrackingConfig
from .tracker import TrackingError, Tracks, track_points

__all__ = ["TrackingConfig", "TrackingError", "Tracks", "track_points"]
