# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The Python samples that move robots or read their recordings, run as a user runs them."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cv_active_handeye.dataset import Dataset

SAMPLES = Path(__file__).parents[2] / "samples/python"
pytestmark = pytest.mark.timeout(120)


def sample(folder: Path, name: str, *arguments: str | Path, typed: str = "") -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(SAMPLES / name), *map(str, arguments)]
    return subprocess.run(command, input=typed, capture_output=True, text=True, timeout=100, cwd=folder)


def test_plan_capture_calibrate_without_the_typed_word_moves_nothing(tmp_path: Path) -> None:
    done = sample(tmp_path, "06_plan_capture_calibrate.py", "set", "--stops", "10", "--live", typed="yes\n")
    assert "Nothing was moved" in done.stderr
    assert sum(line.startswith("stop ") for line in done.stdout.splitlines()) == 10
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("quaternions", [False, True])
def test_poses_of_another_robot_become_a_data_set(quaternions: bool, tmp_path: Path) -> None:
    rng = np.random.default_rng(11)
    turns, positions = Rotation.random(4, random_state=2), rng.uniform(-500, 500, (4, 3))
    pictures = rng.integers(0, 255, (8, 24, 32), dtype=np.uint8)
    numbers = turns.as_quat() if quaternions else turns.as_rotvec()
    header = "x,y,z," + ("qx,qy,qz,qw" if quaternions else "rx,ry,rz")
    np.savetxt(tmp_path / "poses.csv", np.hstack([positions, numbers]), "%.12f", ",", header=header, comments="")
    (tmp_path / "images").mkdir()
    for i, picture in enumerate(pictures):
        cv2.imwrite(str(tmp_path / f"images/{i:02}.png"), picture)
    done = sample(tmp_path, "07_poses_of_another_robot.py", "poses.csv", "images", "set", "--laser")
    assert done.returncode == 0, done.stderr
    dataset = Dataset.open(tmp_path / "set")
    np.testing.assert_allclose(dataset.R_gripper2base, turns.as_matrix(), atol=1e-9)
    np.testing.assert_allclose(dataset.t_gripper2base, positions / 1000, atol=1e-12)
    np.testing.assert_array_equal([dataset.image(i) for i in range(4)], pictures[::2])
    np.testing.assert_array_equal([dataset.laser_image(i) for i in range(4)], pictures[1::2])


def test_poses_of_another_robot_need_an_image_each(tmp_path: Path) -> None:
    (tmp_path / "poses.csv").write_text("x,y,z,rx,ry,rz\n1,2,3,0,0,0\n")
    (tmp_path / "images").mkdir()
    done = sample(tmp_path, "07_poses_of_another_robot.py", "poses.csv", "images", "set")
    assert (done.returncode, "needs 1 images for 1 poses, holds 0" in done.stderr) == (1, True)
