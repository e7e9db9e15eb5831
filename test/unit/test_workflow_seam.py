# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The root of a groove is where its faces meet, within its intervals; views without one are told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from support.groove_recording import groove_dataset
from support.stripe_recording import calibration_of_truth

from cv_active_handeye.dataset import Dataset
from cv_active_handeye.files import FloatArray
from cv_active_handeye.workflow import InsufficientDataError
from cv_active_handeye.workflow.demo_seam import distances_from_line
from cv_active_handeye.workflow.laser_files import write_seam_cloud, write_seam_table
from cv_active_handeye.workflow.seam import GrooveShape, find_seam

SHIFTS = (-0.02, -0.01, 0.0, 0.01, 0.02)


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> tuple[Dataset, FloatArray]:
    return groove_dataset(tmp_path_factory.mktemp("seam") / "set", [*SHIFTS, None])


def test_root_of_an_exact_calibration_is_found_to_a_tenth_of_a_millimetre(
    recording: tuple[Dataset, FloatArray],
) -> None:
    dataset, roots = recording
    seam = find_seam(dataset, calibration_of_truth(covariance=np.zeros((20, 20))))
    np.testing.assert_array_equal(seam.views, range(5))
    assert seam.without_groove == (5,)
    np.testing.assert_allclose(seam.points, roots, atol=1.5e-4)
    np.testing.assert_allclose(seam.opening_angles, 60, atol=2.5)
    assert seam.length == pytest.approx(np.linalg.norm(np.diff(roots, axis=0), axis=1).sum(), rel=0.01)


def test_intervals_of_the_root_hold_the_truth(tmp_path: Path) -> None:
    """Twenty calibrations, each off by what it says of itself."""
    dataset, roots = groove_dataset(tmp_path / "set", SHIFTS)
    ratios = []
    for seed in range(20):
        seam = find_seam(dataset, calibration_of_truth(500 + seed))
        ratios.append((seam.points - roots) / np.sqrt(np.diagonal(seam.covariances, axis1=1, axis2=2)))
    assert np.mean(np.abs(ratios) < 1.96) >= 0.9
    assert np.sqrt(np.mean(np.square(ratios))) > 0.3  # not wider than need be


def test_only_grooves_of_the_angle_wanted_count(recording: tuple[Dataset, FloatArray], tmp_path: Path) -> None:
    with pytest.raises(
        InsufficientDataError, match=r"needs a groove of 100 ± 10 degrees across the stripe, found none in 6 laser"
    ):
        find_seam(recording[0], calibration_of_truth(), GrooveShape(100, 10))
    wide, roots = groove_dataset(tmp_path / "wide", (0.0,), opening_deg=100)
    seam = find_seam(wide, calibration_of_truth(), GrooveShape(100, 10))
    assert seam.opening_angles[0] == pytest.approx(100, abs=3)
    np.testing.assert_allclose(seam.points, roots, atol=3e-4)


def test_files_hold_the_path(recording: tuple[Dataset, FloatArray], tmp_path: Path) -> None:
    seam = find_seam(recording[0], calibration_of_truth())
    write_seam_cloud(tmp_path / "deep" / "seam.ply", seam)
    write_seam_table(tmp_path / "other" / "seam.csv", seam)
    cloud = trimesh.load(tmp_path / "deep" / "seam.ply")
    assert isinstance(cloud, trimesh.PointCloud)
    np.testing.assert_array_equal(cloud.vertices, seam.points)
    table = np.genfromtxt(tmp_path / "other" / "seam.csv", delimiter=",", names=True)
    np.testing.assert_allclose(table["z"], 1000 * seam.points[:, 2], atol=1e-6)
    half = (table["z_upper"] - table["z_lower"]) / 2
    np.testing.assert_allclose(half, 1959.964 * np.sqrt(seam.covariances[:, 2, 2]), rtol=1e-4)


def test_distances_from_a_line_are_perpendicular() -> None:
    points = np.array([[0.0, 3.0, 4.0], [7.0, 0.0, 0.0]])
    np.testing.assert_allclose(distances_from_line(points, np.array([[0.0, 0, 0], [2.0, 0, 0]])), [5, 0])
