# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Finding calibration boards with OpenCV, for the comparison with OpenCV's own methods."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from ..dataset import Dataset, Image
from ..files import FloatArray
from .reporter import InsufficientDataError, Progress

KINDS = ("chessboard", "circles", "charuco", "points")
USAGE = "chessboard:8x6:28.5, circles:10x10:24.8, charuco:9x6:40:35:DICT_4X4_250 (sizes in mm) or points"


@dataclass(frozen=True)
class BoardSpec:
    """A board as written on the command line.

    `columns` x `rows` are inner corners (chessboard), dots (circles) or squares (charuco); `spacing` and `marker` are
    metres. Kind "points" stands for the image points and board points stored in the data set itself.
    """

    kind: str
    columns: int = 0
    rows: int = 0
    spacing: float = 0.0
    marker: float = 0.0
    dictionary: str = ""

    @classmethod
    def parse(cls, text: str) -> BoardSpec:
        """Reads `chessboard:8x6:28.5` and the like; ValueError says what was expected."""
        kind, *fields = text.split(":")
        if text == "points":
            return cls("points")
        try:
            if kind not in KINDS or len(fields) != (4 if kind == "charuco" else 2):
                raise ValueError("the number of fields is wrong" if kind in KINDS else f"there is no kind {kind!r}")
            columns, rows = (int(n) for n in fields[0].split("x"))
            lengths = [float(length) / 1000 for length in fields[1:3]]
            if min(columns, rows) < 2 or min(lengths) <= 0:
                raise ValueError("counts need to be at least 2 and lengths positive")
        except ValueError as error:
            raise ValueError(f"board {text!r}: {error}; expected one of {USAGE}") from error
        if kind == "charuco":
            return cls(kind, columns, rows, lengths[0], lengths[1], _dictionary_name(fields[3]))
        return cls(kind, columns, rows, lengths[0])

    def object_points(self) -> FloatArray:
        """(N, 3) positions on the board in metres, row by row."""
        columns, rows = (self.columns - 1, self.rows - 1) if self.kind == "charuco" else (self.columns, self.rows)
        start = 1 if self.kind == "charuco" else 0
        grid = np.mgrid[start : columns + start, start : rows + start].T.reshape(-1, 2) * self.spacing
        return np.column_stack([grid, np.zeros(len(grid))])


def _dictionary_name(name: str) -> str:
    if not name.startswith("DICT_") or not hasattr(cv2.aruco, name):
        raise ValueError(f"board dictionary: OpenCV has no {name!r}; an example is DICT_4X4_250")
    return name


def find_board(dataset: Dataset, board: BoardSpec, progress: Progress) -> tuple[FloatArray, FloatArray]:
    """(V, N, 2) pixels with NaN where the board was not found, and (N, 3) board points in metres."""
    if board.kind == "points":
        progress(1, 1)
        return _stored(dataset)
    objects = board.object_points()
    points = np.full((len(dataset), len(objects), 2), np.nan)
    for view in dataset.views:
        image = dataset.image(view.index) if view.image is not None else dataset.laser_image(view.index)
        if image is not None:
            _detect(board, _grey8(image), points[view.index])
        progress(view.index + 1, len(dataset))
    return points, objects


def _stored(dataset: Dataset) -> tuple[FloatArray, FloatArray]:
    points, objects = dataset.image_points(), dataset.board_points()
    if points is None or objects is None:
        raise InsufficientDataError(f"{dataset.folder}: board 'points' needs image_points and board_points in it")
    known = np.flatnonzero(np.isfinite(objects).all(axis=1))
    known = known[known < points.shape[1]]
    return points[:, known], objects[known]


def _grey8(image: Image) -> NDArray[np.uint8]:
    grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY) if image.ndim == 3 else image
    return np.asarray(grey if grey.dtype == np.uint8 else grey * (255.0 / max(grey.max(), 1)), np.uint8)


def _detect(board: BoardSpec, image: NDArray[np.uint8], out: FloatArray) -> None:
    """Fills `out` (N, 2) with what is seen of the board, and leaves NaN for the rest."""
    size = (board.columns, board.rows)
    if board.kind == "charuco":
        dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, board.dictionary))
        charuco = cv2.aruco.CharucoBoard(size, board.spacing, board.marker, dictionary)
        corners, ids, _, _ = cv2.aruco.CharucoDetector(charuco).detectBoard(image)
        if ids is not None:
            out[ids.reshape(-1)] = corners.reshape(-1, 2)
        return
    if board.kind == "chessboard":
        found, corners = cv2.findChessboardCornersSB(image, size, flags=cv2.CALIB_CB_ACCURACY)
    else:
        found, corners = cv2.findCirclesGrid(image, size)
    if found:
        out[:] = corners.reshape(-1, 2)
