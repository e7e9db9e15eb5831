# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The whole job on a simulated cell: record, calibrate from the images alone, measure a weld joint, compare with the
truth, draw."""

from __future__ import annotations

import shutil
from dataclasses import dataclass, fields
from pathlib import Path

from ..calibration import Calibration
from ..dataset import Dataset
from ..report import CalibrationErrors, calibration_errors, inside_intervals, write_report
from ..simulation import CellConfig, Truth
from .calibrate import calibrate_with_evidence
from .demo_seam import MeasuredJoint, measure_joint
from .pictures import draw_pictures
from .reporter import Reporter, Silent
from .simulate import simulate

MARKER = ".active_handeye_demo"
LIMITS = CalibrationErrors(
    fx_percent=0.02,
    fy_percent=0.02,
    cx_px=0.1,
    cy_px=0.1,
    rotation_deg=0.012,
    translation_mm=0.15,
    plane_normal_deg=0.01,
    plane_offset_mm=0.15,
)
"""Three to six times the medians of ten seeds and beyond the largest of them: a demo beyond it is not usable."""

WELD_ROOT = "weld_root_mm"
"""Its name among the limits."""


@dataclass(frozen=True)
class DemoResult:
    """What the demo found, the truth it is measured by, the pictures it drew and the report it wrote; `joint`: the weld
    joint measured with the calibration."""

    folder: Path
    calibration: Calibration
    truth: Truth
    errors: CalibrationErrors
    pictures: tuple[Path, ...]
    report: Path
    joint: MeasuredJoint
    limits: CalibrationErrors = LIMITS

    def inside(self) -> dict[str, bool]:
        """Which 95 % intervals hold the truth; one of twenty is meant to miss it."""
        return inside_intervals(self.calibration, self.truth)

    def beyond_limits(self) -> list[str]:
        """Names of the errors that exceed `limits`, or could not be determined; empty = usable."""
        found = []
        for field in fields(CalibrationErrors):
            error, limit = getattr(self.errors, field.name), getattr(self.limits, field.name)
            if error is None or not error <= limit:
                found.append(field.name)
        if not self.joint.rms_mm <= self.joint.limit_mm:
            found.append(WELD_ROOT)
        return found


def demo(folder: str | Path, config: CellConfig | None = None, reporter: Reporter | None = None) -> DemoResult:
    """Writes `dataset/`, `truth.yaml`, `calibration.yaml`, `report.html` and `pictures/` into `folder`, and of the weld
    joint `scan/`, `scan.ply`, `seam.ply` and `seam.csv`.

    Replaces the folder of an earlier demo; FileExistsError for a folder that holds anything else.
    """
    folder, config, reporter = Path(folder), config or CellConfig(), reporter or Silent()
    prepare_folder(folder)
    _, truth = simulate(folder / "dataset", folder / "truth.yaml", config, reporter)
    dataset = Dataset.open(folder / "dataset")
    calibration, evidence = calibrate_with_evidence(dataset, reporter=reporter)
    calibration.save(folder / "calibration.yaml")
    progress = reporter.step("drawing, writing the report")
    pictures = draw_pictures(folder / "pictures", dataset, calibration, evidence)
    assert evidence.summary is not None
    write_report(folder / "report.html", dataset, calibration, evidence, evidence.summary)
    progress(1, 1)
    joint = measure_joint(folder, config, calibration, reporter)
    errors = calibration_errors(calibration, truth)
    pictures = (*pictures, joint.picture)
    return DemoResult(folder, calibration, truth, errors, pictures, folder / "report.html", joint)


def prepare_folder(folder: Path) -> None:
    """Makes `folder` an empty demo folder, and touches nothing that no demo wrote."""
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        if not (folder / MARKER).is_file():
            raise FileExistsError(f"{folder}: exists and was not written by the demo; choose another folder")
        for name in ("dataset", "pictures", "scan"):
            shutil.rmtree(folder / name, ignore_errors=True)
        for name in ("truth.yaml", "calibration.yaml", "report.html", "scan.ply", "seam.ply", "seam.csv"):
            (folder / name).unlink(missing_ok=True)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / MARKER).write_text("Written by the demo, which may replace what is in this folder.\n", encoding="utf-8")
