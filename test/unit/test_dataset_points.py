# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Image points and board points that a data set brings along."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cv_active_handeye.dataset import CameraInfo, Dataset
from cv_active_handeye.files import FileFormatError


def empty_views(folder: Path, count: int = 3) -> Dataset:
    dataset = Dataset.create(folder, camera=CameraInfo(width=32, height=24))
    for i in range(count):
        dataset.add_view(np.eye(3), [i, 0, 0])
    return dataset


def test_points_return_bit_for_bit_with_nan_where_unseen(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    points, board = rng.uniform(0, 30, (3, 5, 2)), rng.uniform(size=(5, 3))
    points[1, 2] = np.nan
    points[0, 4] = np.nan
    empty_views(tmp_path / "set").set_image_points(points, board)
    read = Dataset.open(tmp_path / "set")
    image_points, board_points = read.image_points(), read.board_points()
    assert image_points is not None
    assert board_points is not None
    assert np.array_equal(image_points, points, equal_nan=True)
    assert np.array_equal(board_points, board)
    assert read.problems() == []


def test_data_set_without_points_returns_none(tmp_path: Path) -> None:
    dataset = empty_views(tmp_path / "set")
    assert dataset.image_points() is None
    assert dataset.board_points() is None


def test_set_image_points_refuses_another_number_of_views(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"needs shape 3xNx2 .* given \(2, 5, 2\)"):
        empty_views(tmp_path / "set").set_image_points(np.zeros((2, 5, 2)))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("view,point,u,v\n", "needs the header view,point,u_px,v_px"),
        ("view,point,u_px,v_px\n0,0,1\n", "every row needs 4 numbers"),
        ("view,point,u_px,v_px\n0,0,1,x\n", "every row needs 4 numbers"),
        ("view,point,u_px,v_px\n3,0,1,2\n", "names view 3, the data set has 3 views"),
        ("view,point,u_px,v_px\n0,0.5,1,2\n", "column 2 needs whole numbers"),
        ("view,point,u_px,v_px\n0,-1,1,2\n", "column 2 needs whole numbers"),
        ("view,point,u_px,v_px\n0,0,1,2\n0,0,1,2\n", "given twice"),
    ],
)
def test_damaged_points_are_refused_and_named_as_problem(tmp_path: Path, text: str, message: str) -> None:
    empty_views(tmp_path / "set").set_image_points(np.zeros((3, 2, 2)))
    (tmp_path / "set/image_points.csv").write_text(text)
    dataset = Dataset.open(tmp_path / "set")
    with pytest.raises(FileFormatError, match=message):
        dataset.image_points()
    assert len(dataset.problems()) == 1
