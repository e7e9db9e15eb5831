# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The last part of the demo: the weld joint of the simulated bench, scanned with the calibration just found."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..calibration import Calibration
from ..files import FloatArray
from ..report.cloud_picture import picture_cloud
from ..simulation import CellConfig, SimulatedCell
from .laser_files import write_cloud, write_seam_cloud, write_seam_table
from .reporter import Reporter
from .scan import scan
from .seam import Seam, find_seam

STEP = 2
"""Every second stop of the motion "scan": 10 mm apart."""

LIMIT_MM = 0.6
"""Of the RMS distance from the true root."""


@dataclass(frozen=True)
class MeasuredJoint:
    """The seam's path, the ends (2, 3) of the true root, the distances (N,) of the path's points from its line, all in
    metres of the base frame, and the picture."""

    seam: Seam
    root: FloatArray
    distances: FloatArray
    picture: Path
    limit_mm: float = LIMIT_MM

    @property
    def rms_mm(self) -> float:
        """Of the distances."""
        return float(1000 * np.sqrt(np.mean(self.distances**2)))


def measure_joint(folder: Path, config: CellConfig, calibration: Calibration, reporter: Reporter) -> MeasuredJoint:
    """Scans the joint and writes `scan/`, `scan.ply`, `seam.csv`, `seam.ply` and `pictures/weld_seam.png`."""
    cell = SimulatedCell(config.model_copy(update={"motion": "scan"}))
    recording = cell.record(folder / "scan", reporter.step("scanning the weld joint"), cell.plan()[::STEP])
    cloud = scan(recording, calibration, reporter=reporter)
    seam = find_seam(recording, calibration, reporter=reporter)
    write_cloud(folder / "scan.ply", cloud)
    write_seam_cloud(folder / "seam.ply", seam)
    write_seam_table(folder / "seam.csv", seam)
    picture = folder / "pictures" / "weld_seam.png"
    picture_cloud(picture, cloud.points, cloud.sigmas, path=seam.points)
    assert cell.weld_seam is not None
    return MeasuredJoint(seam, cell.weld_seam, distances_from_line(seam.points, cell.weld_seam), picture)


def distances_from_line(points: FloatArray, ends: FloatArray) -> FloatArray:
    """Of points (N, 3) from the line through `ends` (2, 3)."""
    direction = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    return np.asarray(np.linalg.norm(np.cross(points - ends[0], direction), axis=1))
