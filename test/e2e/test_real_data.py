# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Recorded data of real robots go through importer, data set and calibration. Skipped where the data are absent.

Values that are compared were measured on these recordings (benchmark/real_data.py) and hold with a margin; there is no
truth for them.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from support.recordings import REPOSITORY, real_data

import cv_active_handeye as cah
from cv_active_handeye.dataset import Dataset
from cv_active_handeye.workflow import BoardSpec, Comparison, calibrate, compare
from cv_active_handeye.workflow.evidence import stripe_params

needs_calibrate_hand_eye = pytest.mark.skipif(
    not hasattr(cv2, "calibrateHandEye"), reason=f"OpenCV {cv2.__version__} for Python has no calibrateHandEye"
)


def imported(importer: str, source: str, folder: Path) -> Dataset:
    data = real_data(source)
    script = REPOSITORY / "samples/python" / f"import_{importer}.py"
    subprocess.run([sys.executable, script, data, folder / "set"], check=True, stdout=subprocess.DEVNULL)
    return Dataset.open(folder / "set")


def scores(comparison: Comparison) -> tuple[dict[str, float], dict[str, float]]:
    """RMS px by which the board misses its place: of ours, and of OpenCV's methods."""
    misses = {row.name: row.reprojection_px for row in comparison.rows if row.reprojection_px is not None}
    theirs = {name: value for name, value in misses.items() if name.startswith("OpenCV")}
    return {name: value for name, value in misses.items() if name not in theirs}, theirs


@pytest.mark.parametrize(
    ("importer", "source", "views", "points", "images"),
    [
        ("tabb_denso", "tabb_denso_dataset1", 88, 48, "image"),
        ("indcal", "indcal_10x10", 15, 100, "image"),
        ("etna", "etna_abb_laser/main", 10, 42, "laser_image"),
        ("etna", "etna_abb_laser/calib3", 16, 42, None),
        ("ardoo", "ardoo_ur_charuco", 7, 40, None),
    ],
)
def test_importers_write_complete_data_sets(
    tmp_path: Path, importer: str, source: str, views: int, points: int, images: str | None
) -> None:
    dataset = imported(importer, source, tmp_path)
    assert dataset.problems() == []
    assert len(dataset) == views
    found, board = dataset.image_points(), dataset.board_points()
    assert found is not None
    assert board is not None
    assert found.shape == (views, points, 2)
    assert board.shape == (points, 3)
    for name in ("image", "laser_image"):
        assert all((getattr(view, name) is not None) == (name == images) for view in dataset.views)


@needs_calibrate_hand_eye
def test_denso_recording_beats_every_method_of_opencv_with_and_without_the_board(tmp_path: Path) -> None:
    ours, theirs = scores(compare(imported("tabb_denso", "tabb_denso_dataset1", tmp_path), BoardSpec.parse("points")))
    assert ours["ours, with a start"] < 2.3
    assert ours["ours, on the board, with a start"] < 2.0
    assert max(ours.values()) < min(theirs.values())
    assert len(theirs) == 5


@needs_calibrate_hand_eye
def test_indcal_recording_beats_every_method_of_opencv_with_and_without_the_board(tmp_path: Path) -> None:
    ours, theirs = scores(compare(imported("indcal", "indcal_10x10", tmp_path), BoardSpec.parse("points")))
    assert ours["ours"] < 1.6
    assert ours["ours, on the board"] < 1.3
    assert max(ours.values()) < min(theirs.values())


def test_indcal_camera_from_translations_alone_is_near_the_board_s(tmp_path: Path) -> None:
    result = calibrate(imported("indcal", "indcal_10x10", tmp_path))
    assert result.camera_matrix[0, 0] == pytest.approx(542, rel=0.05)
    assert result.camera_matrix[1, 1] == pytest.approx(543, rel=0.05)


@pytest.mark.parametrize(("importer", "source"), [("etna", "etna_abb_laser/main"), ("ardoo", "ardoo_ur_charuco")])
def test_recordings_without_translations_are_refused_with_the_nearest_views(
    tmp_path: Path, importer: str, source: str
) -> None:
    with pytest.raises(cah.error, match=r"no two views have equal orientation.*come nearest"):
        calibrate(imported(importer, source, tmp_path))


def test_stripe_of_the_etna_laser_is_found_in_most_rows(tmp_path: Path) -> None:
    dataset = imported("etna", "etna_abb_laser/main", tmp_path)
    params = stripe_params(dataset)
    shares = []
    for i in range(len(dataset)):
        image = dataset.laser_image(i)
        assert image is not None
        points, _ = cah.detectStripe(image, params=params)
        shares.append(len(points) / dataset.camera.height)
        rows = points[:, 1].astype(int)
        brightest = image.argmax(axis=1)[rows]
        assert np.median(np.abs(points[:, 0] - brightest)) < 15
    assert np.median(shares) > 0.75  # 20 px wide and saturated: some frames give half of their rows
    assert min(shares) > 0.4
