# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The demo end to end: simulated images, tracks, stripes, calibration, pictures. One run, many questions."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from cv_active_handeye.calibration import Calibration
from cv_active_handeye.dataset import Dataset
from cv_active_handeye.simulation import CellConfig, Truth
from cv_active_handeye.workflow.demo import MARKER, DemoResult, demo, prepare_folder


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> DemoResult:
    return demo(tmp_path_factory.mktemp("demo") / "out", CellConfig(seed=4))


def test_every_error_is_within_its_limit(result: DemoResult) -> None:
    assert result.beyond_limits() == []


def test_an_error_beyond_its_limit_or_missing_is_named(result: DemoResult) -> None:
    tight = replace(result.limits, **dict.fromkeys(vars(result.limits), 0.0))
    wrong = DemoResult(result.folder, result.calibration, result.truth, result.errors, result.pictures, tight)
    assert wrong.beyond_limits() == list(vars(tight))
    missing = replace(result.errors, plane_offset_mm=None)
    found = DemoResult(result.folder, result.calibration, result.truth, missing, result.pictures)
    assert found.beyond_limits() == ["plane_offset_mm"]


def test_the_estimate_is_not_the_truth(result: DemoResult) -> None:
    assert result.errors.translation_mm > 1e-3
    assert result.errors.rotation_deg > 1e-4
    assert result.errors.plane_offset_mm is not None
    assert result.errors.plane_offset_mm > 1e-4


def test_files_of_the_demo_can_be_read_and_belong_together(result: DemoResult) -> None:
    dataset = Dataset.open(result.folder / "dataset")
    saved = Calibration.load(result.folder / "calibration.yaml")
    truth = Truth.load(result.folder / "truth.yaml")
    assert dataset.problems() == []
    assert len(dataset) == 14
    assert saved.dataset_sha256 == dataset.sha256()
    assert saved.to_yaml() == result.calibration.to_yaml()
    assert np.array_equal(truth.camera_matrix, result.truth.camera_matrix)


def test_no_true_parameter_is_written_into_the_data_set(result: DemoResult) -> None:
    truth = result.truth
    values = np.concatenate(
        [np.ravel(x) for x in (truth.camera_matrix, truth.R_cam2gripper, truth.t_cam2gripper, truth.light_plane)]
    )
    text = (result.folder / "dataset/dataset.yaml").read_text()
    told = [repr(float(x)) for x in values if abs(x) not in (0.0, 1.0) and repr(float(x)) in text]
    assert told == []
    assert not list((result.folder / "dataset").rglob("*truth*"))


def test_pictures_are_images_with_something_on_them(result: DemoResult) -> None:
    assert {path.name for path in result.pictures} == {"tracks.png", "motion.png", "stripe.png"}
    for path in result.pictures:
        picture = cv2.imread(str(path))
        assert picture is not None
        assert min(picture.shape[:2]) > 600
        assert picture.std() > 10


def test_recording_has_the_stops_the_demo_promises(result: DemoResult) -> None:
    rms = result.calibration.rms
    assert result.calibration.points >= 1000
    assert result.calibration.stripe_segments >= 30
    assert rms.translations_px < 0.3
    assert rms.rotation_px < 0.6
    assert rms.light_plane_px is not None
    assert rms.light_plane_px < 0.3


def test_prepare_folder_replaces_what_a_demo_wrote_and_nothing_else(tmp_path: Path) -> None:
    folder = tmp_path / "demo"
    prepare_folder(folder)
    (folder / "dataset").mkdir()
    (folder / "dataset/dataset.yaml").write_text("old")
    (folder / "truth.yaml").write_text("old")
    (folder / "notes.txt").write_text("mine")
    prepare_folder(folder)
    assert sorted(path.name for path in folder.iterdir()) == [MARKER, "notes.txt"]


def test_prepare_folder_refuses_a_folder_of_someone_else_and_a_file(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(FileExistsError, match="was not written by the demo"):
        prepare_folder(tmp_path)
    with pytest.raises(FileExistsError, match="was not written by the demo"):
        prepare_folder(tmp_path / "notes.txt")
    assert (tmp_path / "notes.txt").read_text() == "mine"
