# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Accuracy and speed, measured against truth, bounds and OpenCV; see README.md."""
