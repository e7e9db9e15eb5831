# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The recording for the rerun viewer, read with the viewer's own reader."""

from __future__ import annotations

import importlib.util
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from support.refined_recording import refined_recording

from cv_active_handeye.report.rerun_log import require_rerun, write_rerun


@pytest.mark.skipif(importlib.util.find_spec("rerun") is None, reason="`make test-viz` installs the viewer")
@pytest.mark.parametrize("laser", [True, False], ids=["laser", "no laser"])
def test_the_recording_holds_what_was_seen_from_every_view(laser: bool, tmp_path: Path) -> None:
    case = refined_recording(tmp_path / "set", views=8, points=40, laser=laser)
    file = tmp_path / "deep" / "calibration.rrd"
    write_rerun(file, case.dataset, case.calibration, replace(case.evidence, summary=case.summary))
    reader = [str(Path(sys.executable).with_name("rerun")), "rrd", "print", str(file)]
    listing = subprocess.run(reader, capture_output=True, text=True, check=True, timeout=60).stdout
    entities = set(re.findall(r"/(?:base|reprojection_error_px)[\w/]*", listing))
    image = "/base/gripper/camera/image"
    expected = {"/base", "/base/scene", "/base/path", "/base/gripper", "/base/gripper/camera", image}
    expected |= {f"{image}/used", f"{image}/left_out", "/reprojection_error_px"}
    assert expected <= entities
    assert ("/base/gripper/camera/light_plane" in entities) == laser


def test_without_the_viewer_it_is_told_before_the_calibration(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    found = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "rerun" else found(name))
    with pytest.raises(RuntimeError, match=r"pip install 'cv_active_handeye\[viz\]'"):
        require_rerun()
