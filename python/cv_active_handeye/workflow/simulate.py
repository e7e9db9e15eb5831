# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Records a motion in the simulated cell."""

from __future__ import annotations

from pathlib import Path

from ..dataset import Dataset
from ..simulation import CellConfig, SimulatedCell, Truth
from .reporter import Reporter, Silent


def simulate(
    folder: str | Path, truth_file: str | Path, config: CellConfig | None = None, reporter: Reporter | None = None
) -> tuple[Dataset, Truth]:
    """Writes a data set to `folder` and the truth to `truth_file`, which must lie outside of `folder`."""
    folder, truth_file = Path(folder), Path(truth_file)
    if folder.resolve() in truth_file.resolve().parents:
        raise ValueError(f"truth_file: needs a place outside of the data set's folder {folder}, given {truth_file}")
    reporter = reporter or Silent()
    progress = reporter.step("building the simulated cell")
    cell = SimulatedCell(config or CellConfig())
    progress(1, 1)
    dataset = cell.record(folder, reporter.step("recording the images"))
    truth_file.parent.mkdir(parents=True, exist_ok=True)
    cell.truth.save(truth_file)
    return dataset, cell.truth
