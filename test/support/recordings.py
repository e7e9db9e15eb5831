# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Data sets for tests of the workflow, and the place of the recorded real data."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import pytest
from support.exact_recording import exact_recording

from cv_active_handeye.dataset import CameraInfo, Dataset

REPOSITORY = Path(__file__).parents[2]


def exact_dataset(folder: Path, views: Sequence[int] | None = None) -> Dataset:
    """The exact recording (or some of its views) as a data set with image points and without images."""
    recording = exact_recording()
    chosen = list(range(len(recording.R_gripper2base)) if views is None else views)
    dataset = Dataset.create(folder, camera=CameraInfo(width=640, height=480))
    for i in chosen:
        dataset.add_view(recording.R_gripper2base[i], recording.t_gripper2base[i])
    dataset.set_image_points(recording.imagePoints[chosen])
    return dataset


def real_data(name: str) -> Path:
    """Folder of one recorded set; skips the test where the data are not beside the repository."""
    root = Path(os.environ.get("ACTIVE_HANDEYE_DATA", REPOSITORY / "../shared/data"))
    if not (root / name).is_dir():
        pytest.skip(f"recorded data {name} not found in {root}; set ACTIVE_HANDEYE_DATA to the folder that holds it")
    return root / name
