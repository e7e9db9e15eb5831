# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The C++ samples that read recordings: the digits of the Python functions, the truth, and what they refuse."""

from __future__ import annotations

import subprocess
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from support.direct_calls import BUILD
from support.exact_recording import exact_recording, to_camera
from support.recordings import exact_dataset, noisy_dataset

from cv_active_handeye.config import CalibrationOptions
from cv_active_handeye.dataset import CameraInfo, Dataset
from cv_active_handeye.workflow.boards import BoardSpec
from cv_active_handeye.workflow.calibrate import calibrate
from cv_active_handeye.workflow.compare import METHODS, compare

Array = NDArray[np.float64]
pytestmark = pytest.mark.timeout(120)


def sample(name: str, *arguments: str | Path) -> subprocess.CompletedProcess[str]:
    program = BUILD / "bin" / name
    if not program.exists():
        pytest.skip(f"{program}: `make test-cpp` builds it where OpenCV's modules and yaml-cpp are")
    return subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, timeout=60)


def board_dataset(folder: Path, noise_px: float) -> Dataset:
    """A plane of 9 x 7 points seen from the stops of the exact recording."""
    truth, rng = exact_recording(), np.random.default_rng(5)
    x, y = np.meshgrid(np.arange(9) * 0.02, np.arange(7) * 0.02)
    board = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    board2base = Rotation.from_euler("xyz", [8, -12, 20], degrees=True).as_matrix()
    scene = (board - board.mean(axis=0)) @ board2base.T + [0.4, 0.1, 0.0]
    dataset = Dataset.create(folder, camera=CameraInfo(width=640, height=480))
    pixels = []
    for R, t in zip(truth.R_gripper2base, truth.t_gripper2base, strict=True):
        dataset.add_view(R, t)
        inside = to_camera(scene, R, t, truth.R_cam2gripper, truth.t_cam2gripper)
        image, _ = cv2.projectPoints(inside, np.zeros(3), np.zeros(3), truth.cameraMatrix, truth.distCoeffs)
        pixels.append(image.reshape(-1, 2) + noise_px * rng.normal(size=(len(scene), 2)))
    dataset.set_image_points(np.array(pixels), board)
    return dataset


def methods_of(printed: str) -> dict[str, Array]:
    """tx, ty, tz [mm], rx, ry, rz [rad], spread [mm] by the name of the method."""
    rows = [line.split(",") for line in printed.splitlines()[1:] if line.count(",") == 7]
    return {row[0]: np.array(row[1:], dtype=np.float64) for row in rows}


def test_calibrate_recorded_prints_the_digits_of_calibrate(tmp_path: Path) -> None:
    dataset = noisy_dataset(tmp_path / "set")
    done = sample("calibrate_recorded", dataset.folder)
    result = calibrate(dataset, CalibrationOptions(use_laser=False))
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    first, last = lines.index("parameter,estimate,lower,upper  [px; rad; m]"), lines.index("R_cam2gripper")
    table = {cells[0]: np.array(cells[1:], np.float64) for cells in (x.split(",") for x in lines[first + 1 : last])}
    assert list(table) == list(result.parameter_names)[: len(table)]
    assert len(table) == 16
    K = result.camera_matrix
    estimates = {"fx": K[0, 0], "cy": K[1, 2], "k1": result.distortion_coefficients[0], "tz": result.t_cam2gripper[2]}
    for name, value in estimates.items():
        assert table[name][0] == pytest.approx(value, rel=1e-8)
    for name in ("fx", "fy", "cx", "cy", "rx", "ry", "rz", "tx", "ty", "tz"):
        assert tuple(table[name][1:]) == pytest.approx(result.interval(name), rel=1e-6)
    matrix = np.array([line.split(",") for line in lines[last + 1 : last + 4]], np.float64)
    np.testing.assert_allclose(matrix, result.R_cam2gripper, atol=2e-9)


def test_compare_methods_finds_the_truth_from_an_exact_recording(tmp_path: Path) -> None:
    truth = exact_recording()
    done = sample("compare_methods", board_dataset(tmp_path / "set", 0.0).folder)
    assert done.returncode == 0, done.stderr
    rows = methods_of(done.stdout)
    assert list(rows) == [*METHODS, "ours"]
    for values in rows.values():
        np.testing.assert_allclose(values[:3], 1000 * truth.t_cam2gripper, atol=0.05)
        turn = Rotation.from_rotvec(values[3:6]).as_matrix() @ truth.R_cam2gripper.T
        assert Rotation.from_matrix(turn).magnitude() < 1e-4
        assert values[6] < 0.05


def test_compare_methods_prints_the_digits_of_compare(tmp_path: Path) -> None:
    """Of those that this OpenCV for Python has."""
    dataset = board_dataset(tmp_path / "set", 0.1)
    rows = methods_of(sample("compare_methods", dataset.folder).stdout)
    expected = {row.name.removeprefix("OpenCV "): row for row in compare(dataset, BoardSpec.parse("points")).rows}
    compared = 0
    for name, values in rows.items():
        row = expected[name]
        if row.problem:
            continue
        assert row.R_cam2gripper is not None
        assert row.t_cam2gripper is not None
        np.testing.assert_allclose(values[:3], 1000 * row.t_cam2gripper, atol=1e-3)
        np.testing.assert_allclose(Rotation.from_rotvec(values[3:6]).as_matrix(), row.R_cam2gripper, atol=1e-5)
        assert values[6] == pytest.approx(row.spread_mm, abs=1e-3)
        compared += 1
    assert compared >= 1


@pytest.mark.parametrize(
    ("program", "content", "told"),
    [
        ("calibrate_recorded", "view,point,u,v\n0,0,1,1\n", "needs the header view,point,u_px,v_px"),
        ("compare_methods", None, "names no board_points"),
    ],
)
def test_recording_without_what_a_sample_needs_is_refused(
    program: str, content: str | None, told: str, tmp_path: Path
) -> None:
    dataset = exact_dataset(tmp_path / "set")
    if content is not None:
        (dataset.folder / "image_points.csv").write_text(content)
    done = sample(program, dataset.folder)
    assert (done.returncode, told in done.stderr) == (4, True), done.stderr


def test_the_sample_of_the_module_finds_the_camera_of_its_own_scene() -> None:
    done = sample("target_free_hand_eye")
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("usable: ")
    assert float(done.stdout.split("t_cam2gripper is off by ")[1].split()[0]) < 0.3


def test_the_sample_of_the_module_reads_a_recording(tmp_path: Path) -> None:
    truth, file = exact_recording(), tmp_path / "recording.yml"
    storage = cv2.FileStorage(str(file), cv2.FILE_STORAGE_WRITE)
    for name in ("R_gripper2base", "t_gripper2base", "imagePoints"):
        storage.startWriteStruct(name, cv2.FileNode_SEQ)
        for matrix in getattr(truth, name):
            storage.write("", matrix)
        storage.endWriteStruct()
    storage.release()
    done = sample("target_free_hand_eye", file)
    assert done.returncode == 0, done.stderr
    found = np.array(done.stdout.split("t_cam2gripper [")[1].split("]")[0].split(","), np.float64)
    np.testing.assert_allclose(found, truth.t_cam2gripper, atol=1e-6)


def test_the_sample_of_the_module_says_what_is_wrong(tmp_path: Path) -> None:
    done = sample("target_free_hand_eye", tmp_path / "none.yml")
    assert (done.returncode, "cannot read" in done.stderr) == (2, True)
