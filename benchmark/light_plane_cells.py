# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""One simulated cell for light_plane.py: its light plane, and which stripe segments got the surface they lie on."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cv_active_handeye.config import CalibrationOptions
from cv_active_handeye.report import calibration_errors
from cv_active_handeye.simulation import CellConfig, SimulatedCell, SimulatedView
from cv_active_handeye.workflow.calibrate import calibrate_with_evidence
from cv_active_handeye.workflow.evidence import ImagePoints, StripeSegment
from cv_active_handeye.workflow.refinement import Start, refine

from .report import Cell
from .scene import Array

GROUPS = 10
"""Views of the two groups of five, which come first; only their stripes count for the light plane."""
NEAR_PX, MOST = 2.0, 0.8
"""A pixel is on the true stripe within so many px; a segment on the surface of so many of its pixels."""
SAME_DEG, SAME_MM = 0.1, 0.1
"""Two faces are one plane within these."""


@dataclass(frozen=True)
class CellRun:
    """Errors of the light plane from the stripes of the two groups; of all segments those whose surface two views show
    (able), of these those with a label (labelled), and labels shared with segments of another plane (wrong)."""

    seed: int
    normal_deg: float
    offset_mm: float
    able: int
    labelled: int
    wrong: int

    def row(self) -> list[Cell]:
        """Columns of the table."""
        return [str(self.seed), self.normal_deg, self.offset_mm, self.able, self.labelled, self.wrong]


def run(seed: int) -> CellRun:
    """Records the default cell of this seed and calibrates it."""
    cell = SimulatedCell(CellConfig(seed=seed))
    with tempfile.TemporaryDirectory() as folder:
        dataset = cell.record(Path(folder) / "dataset")
        calibration, evidence = calibrate_with_evidence(dataset)
        points = ImagePoints(evidence.image_points, evidence.point_sigmas)
        start = Start(calibration.camera_matrix, calibration.R_cam2gripper, calibration.t_cam2gripper)
        grouped = [segment for segment in evidence.segments if segment.view < GROUPS]
        plane = refine(dataset, points, CalibrationOptions(), start, grouped).light_plane
    assert plane is not None
    errors = calibration_errors(calibration.model_copy(update={"light_plane": plane.ravel()}), cell.truth)
    assert errors.plane_normal_deg is not None
    assert errors.plane_offset_mm is not None
    counts = count_labels(evidence.segments, true_planes(cell, evidence.segments))
    return CellRun(seed, errors.plane_normal_deg, errors.plane_offset_mm, *counts)


def count_labels(segments: Sequence[StripeSegment], planes: NDArray[np.int64]) -> tuple[int, int, int]:
    """able, labelled, wrong of `CellRun`; `planes` (S,): true plane of every segment, -1 = on none."""
    views, labels = (np.array([getattr(s, name) for s in segments]) for name in ("view", "surface"))
    able = np.array([plane >= 0 and len(set(views[planes == plane])) >= 2 for plane in planes])
    wrong = 0
    for label in set(labels[labels >= 0].tolist()):
        own = planes[labels == label]
        wrong += len(own) - int(np.unique(own[own >= 0], return_counts=True)[1].max(initial=0))
    return int(able.sum()), int((able & (labels >= 0)).sum()), wrong


def true_planes(cell: SimulatedCell, segments: Sequence[StripeSegment]) -> NDArray[np.int64]:
    """(S,) number of the plane of the bench on which each segment lies; -1 where it is on none or on several."""
    number = coplanar_faces(cell)
    stripes = {}
    for view in {segment.view for segment in segments}:
        pose = np.eye(4)
        true = cell.truth.views[view]
        pose[:3, :3], pose[:3, 3] = true.R_gripper2base, true.t_gripper2base
        stripes[view] = cell.stripe(SimulatedView(pose, np.zeros((0, 0), np.uint8), None, pose, view))
    found = []
    for segment in segments:
        stripe = stripes[segment.view]
        on = []
        for column, row in segment.points:
            near = (stripe.points[:, 0] == round(column)) & (np.abs(stripe.points[:, 1] - row) < NEAR_PX)
            on += [number[int(stripe.surface_ids[k])] for k in np.flatnonzero(near)[:1] if stripe.surface_ids[k] >= 0]
        planes, counts = np.unique(np.array(on, dtype=np.int64), return_counts=True)
        clear = len(planes) > 0 and counts.max() >= MOST * len(segment.points)
        found.append(int(planes[counts.argmax()]) if clear else -1)
    return np.array(found, dtype=np.int64)


def coplanar_faces(cell: SimulatedCell) -> dict[int, int]:
    """Surface of the scene -> number of the plane it lies on."""
    planes: list[Array] = []
    number = {}
    for surface in np.unique(cell.scene.surface_id[cell.scene.surface_id >= 0]).tolist():
        triangle = int(np.flatnonzero(cell.scene.surface_id == surface)[0])
        plane = np.append(cell.scene.normal[triangle], cell.scene.offset[triangle])
        for k, other in enumerate(planes):
            apart = np.degrees(np.linalg.norm(plane[:3] - other[:3]))
            if apart < SAME_DEG and 1000 * abs(plane[3] - other[3]) < SAME_MM:
                number[surface] = k
                break
        else:
            number[surface] = len(planes)
            planes.append(plane)
    return number
