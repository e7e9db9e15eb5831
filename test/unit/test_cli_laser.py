# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The commands `scan`, `seam` and `measure`: files, tables and one exit status per kind of answer."""

from __future__ import annotations

import csv
from pathlib import Path

import cv2
import numpy as np
import pytest
import trimesh
from support.command_line import run
from support.exact_recording import exact_recording
from support.groove_recording import groove_dataset
from support.recordings import REPOSITORY, exact_dataset
from support.stripe_recording import calibration_of_truth, laser_dataset, true_points

from cv_active_handeye.calibration import Calibration
from cv_active_handeye.cli.console import Exit
from cv_active_handeye.dataset import Dataset
from cv_active_handeye.workflow.scan import scan


@pytest.fixture(autouse=True)
def _own_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    calibration_of_truth().save("calibration.yaml")


def points_file(*rows: str, header: str = "name,view,u,v") -> Path:
    path = Path("points.csv")
    path.write_text("\n".join([header, *rows]) + "\n")
    return path


def row_of(name: str, view: int, k: int, reference: bool = False) -> str:
    """The row for true stripe point `k` of a view, whose stripe crosses surface 0."""
    pixel = exact_recording().stripePoints[3 * view][k]
    known = 1000 * true_points(view, pixel[None])[0]
    return ",".join([name, str(view), *(f"{x:.4f}" for x in [*pixel, *(known if reference else [])])])


def test_scan_writes_the_cloud_of_the_workflow_and_says_how_good_it_is() -> None:
    laser_dataset(Path("set"), (0, None, 1))
    result = run("scan", "set", "-o", "deep/cloud.ply", "--picture", "deep/cloud.png")
    assert result.exit_code == Exit.USABLE
    expected = scan("set", Calibration.load("calibration.yaml"))
    cloud = trimesh.load("deep/cloud.ply")
    assert isinstance(cloud, trimesh.PointCloud)
    np.testing.assert_array_equal(cloud.vertices, expected.points)
    table = cloud.metadata["_ply_raw"]["vertex"]["data"]
    np.testing.assert_array_equal(table["sigma"], expected.sigmas.astype(np.float32))
    np.testing.assert_array_equal(table["view"], expected.views)
    assert f"{len(expected.points)} points in 2 views, in the robot's base frame." in result.output
    assert f"Sigma in the worst direction: median {1000 * np.median(expected.sigmas):.2f} mm" in result.output
    low, high = 1000 * expected.points.min(axis=0), 1000 * expected.points.max(axis=0)
    assert f"Box: x {low[0]:.1f} to {high[0]:.1f} mm, y {low[1]:.1f} to {high[1]:.1f} mm, z " in result.output
    assert "view 1: skipped, no stripe was found" in result.output
    assert "Without points: view 1." in result.output
    picture = cv2.imread("deep/cloud.png")
    assert picture is not None
    assert picture.std() > 10


def test_scan_leaves_out_points_beyond_the_limit() -> None:
    laser_dataset(Path("set"), (0,))
    sigmas = 1000 * scan("set", Calibration.load("calibration.yaml")).sigmas
    result = run("scan", "set", "--max-sigma-mm", str(np.median(sigmas)))
    assert result.exit_code == Exit.USABLE
    assert f"Left out for their sigma: {(sigmas > np.median(sigmas)).sum()} points." in result.output
    cloud = trimesh.load("cloud.ply")
    assert isinstance(cloud, trimesh.PointCloud)
    assert len(cloud.vertices) == (sigmas <= np.median(sigmas)).sum()


@pytest.mark.parametrize(
    ("surfaces", "options", "text"),
    [
        ((None, None), (), "found none in 2; is the laser on"),
        ((0,), ("--max-sigma-mm", "0.001"), "no point has a sigma of 0.001 mm or less"),
    ],
)
def test_scan_without_points_exits_3_and_writes_nothing(
    surfaces: tuple[int | None, ...], options: tuple[str, ...], text: str
) -> None:
    laser_dataset(Path("set"), surfaces)
    result = run("scan", "set", *options)
    assert result.exit_code == Exit.INSUFFICIENT_DATA
    assert text in result.output
    assert not Path("cloud.ply").exists()


def test_scan_without_laser_images_exits_3() -> None:
    exact_dataset(Path("set"))
    result = run("scan", "set")
    assert result.exit_code == Exit.INSUFFICIENT_DATA
    assert "needs views with an image taken with the laser on, has 0" in result.output


@pytest.mark.parametrize("command", [("scan", "set"), ("measure", "set", "--points", "points.csv")])
def test_calibration_that_cannot_measure_exits_4_and_says_what_to_do(command: tuple[str, ...]) -> None:
    laser_dataset(Path("set"), (0,))
    points_file(row_of("S1", 0, 20))
    calibration_of_truth(light_plane=None).save("dark.yaml")
    result = run(*command, "--calibration", "dark.yaml")
    assert result.exit_code == Exit.BAD_FILE
    assert "needs a light plane, has none; record laser images" in result.output
    assert "calibrate again" in result.output
    result = run(*command, "--calibration", REPOSITORY / "test/data/calibration_v1.yaml")
    assert result.exit_code == Exit.BAD_FILE
    assert "given version 1" in result.output


def test_measure_prints_points_intervals_and_differences() -> None:
    laser_dataset(Path("set"), (0, 0))
    rows = [row_of("S1", 0, 10, True), row_of("S2 [left]", 1, 25, True), row_of("S3", 0, 30) + ",,,"]
    points_file(*rows, header="name,view,u,v,x,y,z")
    result = run("measure", "set", "--points", "points.csv", "-o", "deep/measured.csv")
    assert result.exit_code == Exit.USABLE
    lines = result.output.splitlines()
    above = next(i for i, line in enumerate(lines) if line.startswith("points in the base frame [mm]"))
    below = next(i for i, line in enumerate(lines) if line.startswith("measured minus reference [mm]"))
    shown = [line for line in lines[above:below] if " S" in line]
    assert len(shown) == 3
    assert "S2 [left]" in shown[1]
    values = [float(x) for x in shown[0].split()[1:]]
    for half in values[1:6:2]:
        assert 0.05 < half < 1.0
    assert values[6] == 1
    differences = [line.split() for line in lines[below:] if line.strip().startswith("S")]
    assert [row[0] for row in differences] == ["S1", "S2"]
    sizes = [float(row[-1]) for row in differences]
    assert max(sizes) < 0.2
    assert f"maximum {max(sizes):.3f} mm" in result.output
    assert f"3-D difference: RMS {np.sqrt(np.mean(np.square(sizes))):.3f} mm" in result.output
    assert "6 of 6 differences are within the intervals" in result.output
    table = list(csv.DictReader(Path("deep/measured.csv").read_text().splitlines()))
    assert [row["name"] for row in table] == ["S1", "S2 [left]", "S3"]
    assert float(table[0]["x"]) == pytest.approx(values[0], abs=6e-4)
    assert float(table[0]["x_upper"]) - float(table[0]["x"]) == pytest.approx(values[1], abs=6e-4)
    assert float(table[0]["distance"]) == pytest.approx(sizes[0], abs=6e-4)
    assert table[2]["dx"] == table[2]["distance"] == ""


def test_measure_without_references_compares_nothing() -> None:
    laser_dataset(Path("set"), (0,))
    points_file(row_of("S1", 0, 10))
    result = run("measure", "set", "--points", "points.csv")
    assert result.exit_code == Exit.USABLE
    assert "reference" not in result.output
    assert "differences" not in result.output


@pytest.mark.parametrize(
    ("row", "text"),
    [
        ("S1,9,320,240", "line 2: needs a view of the data set (0 to 1), given 9"),
        ("S1,1,320,240", "line 2: needs a straight piece of the stripe within 10 px of (320, 240) in view 1"),
        ("S1,0,320,20", "line 2: needs a straight piece of the stripe within 10 px of (320, 20) in view 0"),
        ("S1,0,left,20", "line 2: column 'u' needs a finite number, given 'left'"),
        ("S1,0,320", "line 2: needs 4 columns as in the header, given 3"),
    ],
)
def test_wrong_row_exits_4_and_is_named(row: str, text: str) -> None:
    laser_dataset(Path("set"), (0, None))
    points_file(row)
    result = run("measure", "set", "--points", "points.csv", "-o", "measured.csv")
    assert result.exit_code == Exit.BAD_FILE
    assert text in " ".join(result.output.split())
    assert not Path("measured.csv").exists()


def test_missing_points_file_exits_4_and_missing_option_exits_2() -> None:
    laser_dataset(Path("set"), (0,))
    result = run("measure", "set", "--points", "absent.csv")
    assert result.exit_code == Exit.BAD_FILE
    assert "absent.csv: cannot be read as a table of points" in result.output
    assert run("measure", "set").exit_code == Exit.USAGE
    assert run("scan").exit_code == Exit.USAGE
    assert run("scan", "set", "--max-sigma-mm", "-1").exit_code == Exit.USAGE


def test_damaged_data_set_exits_4() -> None:
    laser_dataset(Path("set"), (0,))
    assert len(Dataset.open("set")) == 1
    Path("set/dataset.yaml").write_text("schema_version: 7\n")
    assert run("scan", "set").exit_code == Exit.BAD_FILE


def test_help_shows_lines_to_try() -> None:
    for command in ("scan", "measure"):
        text = " ".join(run(command, "--help").output.split())
        assert f"Example: cv-active-handeye {command} out/scan --calibration" in text
        assert "Exit status:" in text


def test_seam_writes_the_path_of_the_root_and_says_where_it_runs() -> None:
    _, roots = groove_dataset(Path("set"), (-0.01, 0.0, None, 0.01))
    result = run("seam", "set", "-o", "a/seam.csv", "--ply", "b/seam.ply", "--picture", "c/seam.png")
    assert result.exit_code == Exit.USABLE
    text = " ".join(result.output.split())
    assert "Root of the groove in 3 profiles, " in text
    assert "Without a groove: view 2." in text
    assert "Written to a/seam.csv, b/seam.ply, c/seam.png" in text
    with Path("a/seam.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["view"] for row in rows] == ["0", "1", "3"]
    np.testing.assert_allclose([float(row["y"]) for row in rows], 1000 * roots[:, 1], atol=0.2)
    picture = cv2.imread("c/seam.png")
    assert picture is not None
    assert picture.std() > 10


def test_seam_without_a_groove_cannot_answer() -> None:
    laser_dataset(Path("set"), (0, 1))
    result = run("seam", "set")
    assert result.exit_code == Exit.INSUFFICIENT_DATA
    assert "needs a groove of 60 ± 20 degrees across the stripe, found none in 2 laser images" in result.output
    assert not Path("seam.csv").exists()
