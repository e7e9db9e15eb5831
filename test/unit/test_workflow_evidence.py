# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Points come from the data set or from tracking, keep their views, and what is missing is said; reports are written
with OpenCV's methods beside ours where a board was seen."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest
from support.calibrations import refined
from support.recordings import Notes, exact_dataset

from cv_active_handeye.config import CalibrationOptions
from cv_active_handeye.dataset import CameraInfo, Dataset
from cv_active_handeye.tracking import TrackingError
from cv_active_handeye.workflow import BoardSpec, Evidence, ImagePoints, InsufficientDataError
from cv_active_handeye.workflow.evidence import find_points, find_stripes, open_recording
from cv_active_handeye.workflow.reporting import report_calibration

EVIDENCE, REPORTING = "cv_active_handeye.workflow.evidence", "cv_active_handeye.workflow.reporting"


class FakeTracks:
    """Two tracks in the images it is given; the last image shares no points."""

    def __init__(self, count: int) -> None:
        self.points = np.arange(4.0 * count).reshape(count, 2, 2)
        self.sigmas = np.linspace(0.01, 0.02, 2 * count).reshape(count, 2)
        self.points[-1], self.sigmas[-1] = np.nan, np.nan
        self.empty_views = [count - 1]

    def __len__(self) -> int:
        return 2


def dataset_without_image_of_view_1(folder: Path) -> Dataset:
    dataset = Dataset.create(folder, camera=CameraInfo(width=64, height=48))
    for i in range(4):
        image = None if i == 1 else np.full((48, 64), 10 * i, np.uint8)
        dataset.add_view(np.eye(3), [0.01 * i, 0, 0], image=image)
    return dataset


def test_tracks_keep_the_numbers_of_their_views(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(f"{EVIDENCE}.track_points", lambda images, *_: FakeTracks(len(images)))
    reporter = Notes()
    found = find_points(dataset_without_image_of_view_1(tmp_path / "set"), CalibrationOptions(), reporter)
    tracks = FakeTracks(3)
    assert np.isnan(found.points[1]).all()
    assert np.array_equal(found.points[[0, 2, 3]], tracks.points, equal_nan=True)
    assert found.sigmas is not None
    assert np.array_equal(found.sigmas[[0, 2, 3]], tracks.sigmas, equal_nan=True)
    assert np.isnan(found.sigmas[1]).all()
    assert reporter.steps == ["tracking points in 3 images"]
    assert reporter.notes == ["view 3 shares no points with the others"]


def test_stored_points_come_first_unless_tracking_is_asked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    dataset = dataset_without_image_of_view_1(tmp_path / "set")
    stored = np.random.default_rng(1).uniform(0, 40, (4, 3, 2))
    dataset.set_image_points(stored)
    monkeypatch.setattr(f"{EVIDENCE}.track_points", lambda images, *_: FakeTracks(len(images)))
    given = find_points(dataset, CalibrationOptions(), Notes())
    assert np.array_equal(given.points, stored)
    assert given.sigmas is None
    tracked = find_points(dataset, CalibrationOptions(track_images=True), Notes())
    assert tracked.points.shape == (4, 2, 2)


def test_tracking_that_fails_names_the_data_set(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: Any) -> None:
        raise TrackingError("images: no point was found in 3 views")

    monkeypatch.setattr(f"{EVIDENCE}.track_points", refuse)
    with pytest.raises(InsufficientDataError, match=r"set: images: no point was found"):
        find_points(dataset_without_image_of_view_1(tmp_path / "set"), CalibrationOptions(), Notes())


def test_stated_sigma_is_the_median_and_relative_sigmas_are_in_its_unit() -> None:
    points = ImagePoints(np.zeros((2, 2, 2)), np.array([[0.01, 0.02], [np.nan, 0.04]]))
    assert points.stated_sigma == 0.02
    assert np.array_equal(points.relative_sigmas, [[0.5, 1], [np.nan, 2]], equal_nan=True)  # type: ignore[arg-type]
    plain = ImagePoints(np.zeros((2, 2, 2)))
    assert (plain.stated_sigma, plain.relative_sigmas) == (None, None)


def test_open_recording_tells_what_is_missing(tmp_path: Path) -> None:
    Dataset.create(tmp_path / "set", camera=CameraInfo(width=64, height=48), planned_views=3)
    reporter = Notes()
    dataset = open_recording(str(tmp_path / "set"), reporter)
    assert len(dataset) == 0
    assert reporter.notes == ["data set: 3 of 3 planned views are missing (views 0 to 2)"]
    assert open_recording(dataset, Notes()) is dataset


def test_data_set_without_laser_images_has_no_stripes_and_no_step(tmp_path: Path) -> None:
    reporter = Notes()
    assert find_stripes(exact_dataset(tmp_path / "set"), np.eye(3), None, reporter) == []
    assert reporter.steps == []


class Reported:
    """Stands for `write_report` and `compare`, and remembers what they were given."""

    def __init__(self, problem: Exception | None = None) -> None:
        self.problem = problem
        self.boards: list[BoardSpec] = []
        self.written: list[tuple[Any, ...]] = []

    def compare(self, dataset: Dataset, board: BoardSpec, **_: Any) -> str:
        self.boards.append(board)
        if self.problem is not None:
            raise self.problem
        return "a comparison"

    def write_report(self, *arguments: Any) -> None:
        self.written.append(arguments)


def reported(
    folder: Path, monkeypatch: pytest.MonkeyPatch, dataset: Dataset, board: BoardSpec | None, called: Reported
) -> Notes:
    monkeypatch.setattr(f"{REPORTING}.compare", called.compare)
    monkeypatch.setattr(f"{REPORTING}.write_report", called.write_report)
    reporter = Notes()
    summary: Any = SimpleNamespace()
    evidence = Evidence(np.zeros((0, 0, 2)), (), None, summary)
    report_calibration(folder / "new" / "report.html", dataset, refined(), evidence, reporter, board)
    assert (folder / "new").is_dir()
    ((path, *_, given_summary, comparison),) = called.written
    assert path == folder / "new" / "report.html"
    assert given_summary is summary
    assert comparison == ("a comparison" if called.boards and called.problem is None else None)
    return reporter


def with_board(folder: Path) -> Dataset:
    dataset = exact_dataset(folder)
    points = dataset.image_points()
    assert points is not None
    dataset.set_image_points(points, np.random.default_rng(2).uniform(size=(60, 3)))
    return dataset


def test_report_without_a_board_has_no_comparison(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    called = Reported()
    reporter = reported(tmp_path, monkeypatch, exact_dataset(tmp_path / "set"), None, called)
    assert called.boards == []
    assert reporter.steps == ["writing the report"]


def test_report_compares_on_the_board_of_the_data_set(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    called = Reported()
    reported(tmp_path, monkeypatch, with_board(tmp_path / "set"), None, called)
    assert called.boards == [BoardSpec("points")]


def test_report_compares_on_the_board_that_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    called, board = Reported(), BoardSpec.parse("chessboard:8x6:20")
    reported(tmp_path, monkeypatch, with_board(tmp_path / "set"), board, called)
    assert called.boards == [board]


@pytest.mark.parametrize("problem", [InsufficientDataError("needs 3 views"), cv2.error("needs 3 views")])
def test_comparison_that_fails_is_noted_and_the_report_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, problem: Exception
) -> None:
    reporter = reported(tmp_path, monkeypatch, with_board(tmp_path / "set"), None, Reported(problem))
    assert reporter.notes == ["no comparison with OpenCV in the report: needs 3 views"]
