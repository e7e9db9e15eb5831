# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Laser images of a V-groove between two plates, drawn with the exact recording's camera and light plane."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from support.exact_recording import exact_recording
from support.stripe_recording import Stop, record

from cv_active_handeye.dataset import Dataset

Array = NDArray[np.float64]
DEPTH = 0.012
"""Of the groove, m."""


def light_axes() -> tuple[Array, Array, Array]:
    """A point of the light plane near the middle of the image, its direction across the image and that away from the
    camera, camera frame."""
    truth = exact_recording()
    n, d = truth.lightPlane[:3], truth.lightPlane[3]
    across = np.array([1.0, 0, 0]) - n * n[0]
    across /= np.linalg.norm(across)
    away = np.cross(across, n)
    away *= np.sign(away[2])
    middle = np.array([0.0, 0.0, d / n[2]])
    return middle, across, away


def groove(shift: float, opening_deg: float = 60.0) -> tuple[Array, Array]:
    """Corners (5, 3) of the profile in the camera frame: plate, face, root, face, plate; and the root (3,)."""
    middle, across, away = light_axes()
    half = DEPTH * np.tan(np.radians(opening_deg / 2))
    places = [(-0.07, 0.0), (-half, 0.0), (0.0, DEPTH), (half, 0.0), (0.07, 0.0)]
    corners = np.array([middle + (shift + s) * across + h * away for s, h in places])
    return corners, corners[2]


def groove_dataset(folder: Path, shifts: Sequence[float | None], opening_deg: float = 60.0) -> tuple[Dataset, Array]:
    """One view for every shift (m) of the groove across the image, None = a flat plate; and the true roots, base frame,
    of the views that show a groove."""
    truth = exact_recording()
    stops, roots = [], []
    for view, shift in enumerate(shifts):
        R, t = truth.R_gripper2base[0], truth.t_gripper2base[0] + np.array([0.004 * view, 0, 0])
        corners, root = groove(0.0 if shift is None else shift, opening_deg)
        if shift is None:
            corners = corners[[0, 4]]
        else:
            roots.append(R @ (truth.R_cam2gripper @ root + truth.t_cam2gripper) + t)
        line = np.concatenate([np.linspace(a, b, 400) for a, b in pairwise(corners)])
        image = cv2.projectPoints(line, np.zeros(3), np.zeros(3), truth.cameraMatrix, truth.distCoeffs)[0]
        stops.append(Stop(R, t, image.reshape(-1, 2).astype(np.float64)))
    return record(folder, stops), np.array(roots)
