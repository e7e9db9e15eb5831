# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Parity is a question for an OpenCV that was built with the module: `make opencv4`, `make opencv5`."""

import cv2

collect_ignore_glob = [] if hasattr(cv2, "active_handeye") else ["test_*.py"]
