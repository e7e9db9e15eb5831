# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The command `cv-active-handeye`: arguments only, the work is in `workflow`."""

from .commands import app

__all__ = ["app"]
