# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What tries, inspects and describes wheels: it accepts the extension of this build, and nothing worse."""

from __future__ import annotations

import socket
import subprocess
import sys
import zipfile
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any, cast

import cv2
import pytest
import try_wheel
import wheel_dependencies
from build_wheels import without_network

import cv_active_handeye as cah
from benchmark import wheel as measures
from benchmark.report import Measure, Report
from cv_active_handeye import _core


def changed(**functions: Any) -> ModuleType:
    """The wheel, with other functions in the place of some of its own."""
    return cast(ModuleType, SimpleNamespace(**{**vars(cah), **functions}))


@pytest.mark.parametrize("order", ["none", "first", "last"])
def test_the_extension_of_this_build_is_right(order: str) -> None:
    command = [sys.executable, try_wheel.__file__, "--cv2", order]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert f"{cah.__version__} is right" in done.stdout


def test_a_wrong_calibration_is_seen() -> None:
    def refine(*arguments: Any) -> tuple[Any, ...]:
        rms, K, *others = cah.refineHandEye(*arguments)
        return rms, K * [[1.002, 1, 1], [1, 1, 1], [1, 1, 1]], *others

    with pytest.raises(SystemExit, match="focal length"):
        try_wheel.calibrate(changed(refineHandEye=refine))


def test_a_wrong_stripe_is_seen() -> None:
    def detect(image: Any) -> tuple[Any, ...]:
        points, *others = cah.detectStripe(image)
        return points + 0.1, *others

    with pytest.raises(SystemExit, match="stripe"):
        try_wheel.detect_stripe(changed(detectStripe=detect))


def test_a_result_from_nothing_is_seen() -> None:
    with pytest.raises(SystemExit, match="estimateFOE"):
        try_wheel.refuse(changed(estimateFOE=lambda *points: points))


def test_exceptions_shared_with_cv2_are_seen() -> None:
    class Shared(cah.error, cv2.error):
        pass

    def estimate(*points: Any) -> None:
        raise Shared

    with pytest.raises(SystemExit, match="exception of the wheel"):
        try_wheel.beside(changed(estimateFOE=estimate), cv2)


def test_contents_of_a_wheel_are_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(measures, "FOLDER", tmp_path)
    path = tmp_path / "cv_active_handeye-0.1.0-cp311-cp311-manylinux_2_34_x86_64.whl"
    with zipfile.ZipFile(path, "w") as archive:
        archive.write(_core.__file__, "cv_active_handeye/_core.cpython-311-x86_64-linux-gnu.so")
        archive.writestr("cv_active_handeye.libs/libopencv_core-1234.so.406", "")
    contents = measures.Contents(path)
    assert contents.exported() == ["PyInit__core"]
    assert contents.bundled() == ["cv_active_handeye.libs/libopencv_core-1234.so.406"]
    assert {"libc.so.6", "libm.so.6"} < set(contents.needed())
    assert contents.tag == "manylinux_2_34_x86_64"
    assert contents.megabytes == path.stat().st_size / 1e6


def test_the_report_replaces_the_one_before(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = tmp_path / "release.md"
    monkeypatch.setattr(measures, "PAGE", page)
    page.write_text("# Releases\n\n{}\nold\n{}\n\n## End\n".format(*measures.MARKERS), encoding="utf-8")
    measures.write(Report("Wheel", "Today", (), [Measure("size", 1.0, 1.5)]))
    text = page.read_text("utf-8")
    assert "old" not in text
    assert "| size" in text
    assert text.startswith("# Releases\n")
    assert text.endswith("## End\n")


def test_a_page_without_the_markers_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = tmp_path / "release.md"
    page.write_text("# Releases\n", encoding="utf-8")
    monkeypatch.setattr(measures, "PAGE", page)
    with pytest.raises(ValueError, match=r"release\.md: needs the lines"):
        measures.write(Report("Wheel", "Today"))


def test_a_build_without_network_reaches_nothing() -> None:
    cut = without_network()
    if not cut:
        pytest.skip("this system lets no process be cut off from the network")
    with socket.create_server(("127.0.0.1", 0)) as server:
        connect = f"import socket; socket.create_connection(('127.0.0.1', {server.getsockname()[1]}), 5)"
        assert subprocess.run([sys.executable, "-c", connect], capture_output=True, check=False).returncode == 0
        assert subprocess.run([*cut, sys.executable, "-c", connect], capture_output=True, check=False).returncode == 1


def test_another_compiler_or_option_makes_other_dependencies(monkeypatch: pytest.MonkeyPatch) -> None:
    before = wheel_dependencies.contents()
    monkeypatch.setenv("CXX", sys.executable)  # it answers --version too
    assert wheel_dependencies.contents() != before
    monkeypatch.undo()
    assert wheel_dependencies.contents() == before
    monkeypatch.setitem(wheel_dependencies.OPTIONS, "CMAKE_BUILD_TYPE", "Debug")
    assert wheel_dependencies.contents() != before
