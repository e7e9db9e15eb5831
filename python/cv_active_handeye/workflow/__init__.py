# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What the command line does, as functions.

`workflow.simulate` and `workflow.demo` are modules of their own because they need the extra `sim`.
"""

from .boards import BoardSpec
from .calibrate import calibrate, calibrate_with_evidence
from .compare import Comparison, compare
from .evidence import Evidence, ImagePoints, StripeSegment
from .reporter import InsufficientDataError, Reporter, Silent

__all__ = [
    "BoardSpec",
    "Comparison",
    "Evidence",
    "ImagePoints",
    "InsufficientDataError",
    "Reporter",
    "Silent",
    "StripeSegment",
    "calibrate",
    "calibrate_with_evidence",
    "compare",
]
