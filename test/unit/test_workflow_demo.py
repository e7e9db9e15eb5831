# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The demo replaces only what a demo wrote, and judges errors by its limits."""

from __future__ import annotations

from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest
from support.calibrations import refined

from cv_active_handeye.report import CalibrationErrors
from cv_active_handeye.simulation import Truth
from cv_active_handeye.workflow.demo import LIMITS, MARKER, WELD_ROOT, DemoResult, prepare_folder
from cv_active_handeye.workflow.demo_seam import LIMIT_MM, MeasuredJoint
from cv_active_handeye.workflow.seam import Seam


def result(errors: CalibrationErrors) -> DemoResult:
    found = refined()
    assert found.light_plane is not None
    truth = Truth(
        seed=0,
        camera_matrix=found.camera_matrix,
        distortion_coefficients=found.distortion_coefficients,
        R_cam2gripper=found.R_cam2gripper,
        t_cam2gripper=found.t_cam2gripper,
        light_plane=found.light_plane,
    )
    return DemoResult(Path("out"), found, truth, errors, (), Path("out/report.html"), joint())


def joint(distance_mm: float = 0.3) -> MeasuredJoint:
    """A seam of two points, both this far from the true root."""
    seam = Seam(np.zeros((2, 3)), np.zeros((2, 3, 3)), np.full(2, 60.0), np.arange(2, dtype=np.int32))
    return MeasuredJoint(seam, np.eye(3)[:2], np.full(2, distance_mm / 1000), Path("out/pictures/weld_seam.png"))


def test_errors_at_their_limits_are_usable() -> None:
    assert result(LIMITS).beyond_limits() == []


@pytest.mark.parametrize("name", list(asdict(LIMITS)))
@pytest.mark.parametrize("factor", [1.01, np.nan, None])
def test_error_beyond_its_limit_or_unknown_is_named(name: str, factor: float | None) -> None:
    error = None if factor is None else factor * asdict(LIMITS)[name]
    errors = CalibrationErrors(**asdict(LIMITS) | {name: error})
    assert result(errors).beyond_limits() == [name]


@pytest.mark.parametrize(("distance_mm", "beyond"), [(LIMIT_MM, False), (1.01 * LIMIT_MM, True), (np.nan, True)])
def test_weld_root_beyond_its_limit_is_named(distance_mm: float, beyond: bool) -> None:
    found = replace(result(LIMITS), joint=joint(distance_mm))
    assert found.beyond_limits() == ([WELD_ROOT] if beyond else [])


def test_inside_says_which_intervals_hold_the_truth() -> None:
    inside = result(LIMITS).inside()
    assert set(inside) <= set(refined().parameter_names)
    assert len(inside) == 20


def test_prepare_folder_replaces_an_earlier_demo_and_keeps_other_files(tmp_path: Path) -> None:
    prepare_folder(tmp_path / "out")
    assert (tmp_path / "out" / MARKER).is_file()
    for name in ("dataset", "scan"):
        (tmp_path / "out" / name).mkdir()
        (tmp_path / "out" / name / "dataset.yaml").write_text("old")
    written = ("truth.yaml", "calibration.yaml", "report.html", "scan.ply", "seam.ply", "seam.csv")
    for name in (*written, "notes.txt"):
        (tmp_path / "out" / name).write_text("old")
    prepare_folder(tmp_path / "out")
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [MARKER, "notes.txt"]


def test_prepare_folder_touches_nothing_that_no_demo_wrote(tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "calibration.yaml").write_text("mine")
    (tmp_path / "file").write_text("mine")
    for path in (tmp_path / "mine", tmp_path / "file"):
        with pytest.raises(FileExistsError, match="was not written by the demo"):
            prepare_folder(path)
    assert [path.name for path in (tmp_path / "mine").iterdir()] == ["calibration.yaml"]
    assert (tmp_path / "file").read_text() == "mine"
