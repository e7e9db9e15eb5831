# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Data sets for tests of the workflow, and the place of the recorded real data."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from support.exact_recording import exact_recording

from cv_active_handeye.config import CalibrationOptions
from cv_active_handeye.dataset import CameraInfo, Dataset
from cv_active_handeye.workflow.reporter import Progress

REPOSITORY = Path(__file__).parents[2]
NOISE_PX, ROBOT_MM, ROBOT_DEG = 0.05, 0.02, 0.005


class Notes:
    """A reporter that remembers."""

    def __init__(self) -> None:
        self.steps: list[str] = []
        self.notes: list[str] = []

    def step(self, name: str) -> Progress:
        """Remembers the name and ignores the progress."""
        self.steps.append(name)
        return lambda done, total: None

    def note(self, text: str) -> None:
        """Remembers the note."""
        self.notes.append(text)


def exact_dataset(folder: Path, views: Sequence[int] | None = None) -> Dataset:
    """The exact recording (or some of its views) as a data set with image points and without images."""
    recording = exact_recording()
    chosen = list(range(len(recording.R_gripper2base)) if views is None else views)
    dataset = Dataset.create(folder, camera=CameraInfo(width=640, height=480))
    for i in chosen:
        dataset.add_view(recording.R_gripper2base[i], recording.t_gripper2base[i])
    dataset.set_image_points(recording.imagePoints[chosen])
    return dataset


def noisy_dataset(
    folder: Path,
    robot: bool = True,
    t_gripper2base: NDArray[np.float64] | None = None,
    seed: int = 3,
    views: Sequence[int] | None = None,
    bump_mm: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Dataset:
    """The recording (or some of its views) with noise of image and, with `robot`, of the reported poses."""
    truth, rng = exact_recording(bump_mm), np.random.default_rng(seed)
    chosen = list(range(len(truth.R_gripper2base)) if views is None else views)
    reported = truth.t_gripper2base if t_gripper2base is None else t_gripper2base
    dataset = Dataset.create(folder, camera=CameraInfo(width=640, height=480))
    for R, t in zip(truth.R_gripper2base[chosen], reported[chosen], strict=True):
        turn = Rotation.from_rotvec(robot * np.radians(ROBOT_DEG) * rng.normal(size=3)).as_matrix()
        dataset.add_view(turn @ R, t + robot * ROBOT_MM / 1000 * rng.normal(size=3))
    points = truth.imagePoints[chosen]
    dataset.set_image_points(points + NOISE_PX * rng.normal(size=points.shape))
    return dataset


def known_distortion(**changes: object) -> CalibrationOptions:
    """Options with the distortion of the recording given."""
    return CalibrationOptions.model_validate({"distortion_coefficients": exact_recording().distCoeffs, **changes})


def real_data(name: str) -> Path:
    """Folder of one recorded set; skips the test where the data are not beside the repository."""
    root = Path(os.environ.get("ACTIVE_HANDEYE_DATA", REPOSITORY / "../shared/data"))
    if not (root / name).is_dir():
        pytest.skip(f"recorded data {name} not found in {root}; set ACTIVE_HANDEYE_DATA to the folder that holds it")
    return root / name
