# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The files that scan and seam write: point clouds (PLY) and the path of a seam (CSV); described in doc/files.md."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..measured_points import write_measured
from ..ply import write_ply
from ..report.verdict import NORMAL_95
from .scan import Scan
from .seam import Seam

CLOUD_COMMENTS = (
    "written by cv-active-handeye scan; robot base frame, metres",
    "sigma: standard deviation in the worst direction, metres; intensity: grey level; view: number in the data set",
)
SEAM_COMMENTS = (
    "written by cv-active-handeye seam; root of the groove, robot base frame, metres",
    "sigma: standard deviation in the worst direction, metres; opening: angle of the groove, degrees; view: number in "
    "the data set",
)


def write_cloud(path: str | Path, cloud: Scan) -> None:
    """PLY with x, y, z, sigma (m), intensity and view."""
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    sigmas = cloud.sigmas.astype(np.float32)
    write_ply(path, cloud.points, CLOUD_COMMENTS, sigma=sigmas, intensity=cloud.intensity, view=cloud.views)


def write_seam_cloud(path: str | Path, seam: Seam) -> None:
    """PLY with x, y, z, sigma (m), opening (degrees) and view, in the order of the path."""
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    sigmas, opening = seam.sigmas.astype(np.float32), seam.opening_angles.astype(np.float32)
    write_ply(path, seam.points, SEAM_COMMENTS, sigma=sigmas, opening=opening, view=seam.views)


def write_seam_table(path: str | Path, seam: Seam) -> None:
    """CSV in mm: view, x, y, z, the ends of their 95 % intervals, opening angle in degrees."""
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    ends = [f"{axis}_{end}" for axis in "xyz" for end in ("lower", "upper")]
    rows = []
    for view, point, covariance, opening in zip(
        seam.views, seam.points, seam.covariances, seam.opening_angles, strict=True
    ):
        half = NORMAL_95 * np.sqrt(np.diag(covariance))
        values = [*point, *np.column_stack([point - half, point + half]).reshape(-1)]
        rows.append([str(view), *(f"{1000 * value:.6f}" for value in values), f"{opening:.2f}"])
    write_measured(path, ["view", "x", "y", "z", *ends, "opening_deg"], rows)
