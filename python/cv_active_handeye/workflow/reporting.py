# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Writes the HTML report of a calibration, with OpenCV's methods beside it where a board was seen."""

from __future__ import annotations

from pathlib import Path

import cv2

from ..calibration import Calibration
from ..dataset import Dataset
from ..report import write_report
from .boards import BoardSpec
from .compare import Comparison, compare
from .evidence import Evidence
from .reporter import InsufficientDataError, Reporter


def report_calibration(
    path: Path,
    dataset: Dataset,
    calibration: Calibration,
    evidence: Evidence,
    reporter: Reporter,
    board: BoardSpec | None = None,
) -> None:
    """Writes `path`; `board`: a board in the images, None = the board points stored in the data set, if any."""
    if board is None and dataset.board_points() is not None:
        board = BoardSpec("points")
    comparison = _compare(dataset, calibration, board, reporter) if board is not None else None
    progress = reporter.step("writing the report")
    assert evidence.summary is not None
    path.parent.mkdir(parents=True, exist_ok=True)
    write_report(path, dataset, calibration, evidence, evidence.summary, comparison)
    progress(1, 1)


def _compare(dataset: Dataset, calibration: Calibration, board: BoardSpec, reporter: Reporter) -> Comparison | None:
    try:
        return compare(dataset, board, reporter=reporter, calibration=calibration)
    except (InsufficientDataError, cv2.error) as error:
        reporter.note(f"no comparison with OpenCV in the report: {str(error).strip()}")
        return None
