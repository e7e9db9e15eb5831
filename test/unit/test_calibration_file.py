# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""calibration.yaml: every number bit for bit, for us, cv::FileStorage and PyYAML; old files are read for ever."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from support.calibrations import closed_form, refined

from cv_active_handeye.calibration import PARAMETERS, Calibration, read_camera
from cv_active_handeye.files import FileFormatError

DATA = Path(__file__).parents[1] / "data"
COMMON = ("camera_matrix", "distortion_coefficients", "R_cam2gripper", "t_cam2gripper", "light_plane", "covariance")
MATRICES = {1: COMMON, 2: (*COMMON, "degrees_of_freedom", "intervals_95")}

versions = pytest.mark.parametrize("calibration", [closed_form, refined])


def written(folder: Path, calibration: Calibration) -> Path:
    calibration.save(folder / "c.yaml")
    return folder / "c.yaml"


@versions
def test_load_returns_every_number_bit_for_bit(tmp_path: Path, calibration: Callable[[], Calibration]) -> None:
    given = calibration()
    read = Calibration.load(written(tmp_path, given))
    for name in MATRICES[given.schema_version]:
        assert np.array_equal(getattr(read, name), getattr(given, name)), name
    apart = {*MATRICES[given.schema_version], "tool", "lens"}
    assert read.model_dump(exclude=apart) == given.model_dump(exclude=apart)
    assert read.to_yaml() == given.to_yaml()


def test_load_returns_the_matrices_inside_of_parts(tmp_path: Path) -> None:
    read = Calibration.load(written(tmp_path, refined()))
    assert read.lens is not None
    assert np.array_equal(read.lens.tests, refined().lens.tests)  # type: ignore[union-attr]
    assert read.tool is not None
    assert np.array_equal(read.tool.covariance, 1e-9 * np.eye(3))
    assert (read.lens.model, read.lens.chosen) == ("k1-k2", True)
    assert (read.tool.working_distance, read.tool.accuracy) == (0.55, 1e-5)


@versions
def test_file_storage_reads_every_matrix_and_number(tmp_path: Path, calibration: Callable[[], Calibration]) -> None:
    given = calibration()
    storage = cv2.FileStorage(str(written(tmp_path, given)), cv2.FILE_STORAGE_READ)
    for name in MATRICES[given.schema_version]:
        matrix = storage.getNode(name).mat()
        assert matrix.dtype == np.float64, name
        assert np.array_equal(matrix.reshape(getattr(given, name).shape), getattr(given, name)), name
    assert storage.getNode("schema_version").real() == given.schema_version
    assert storage.getNode("image_width").real() == 640
    assert storage.getNode("dataset_sha256").string() == "12e4567"
    names = storage.getNode("parameter_names")
    assert tuple(names.at(i).string() for i in range(names.size())) == given.parameter_names


def test_file_storage_reads_the_parts_of_a_refined_result(tmp_path: Path) -> None:
    given = refined()
    storage = cv2.FileStorage(str(written(tmp_path, given)), cv2.FILE_STORAGE_READ)
    verdict = storage.getNode("verdict")
    assert given.verdict is not None
    assert verdict.getNode("usable").real() == 1
    assert verdict.getNode("message").string() == given.verdict.message
    assert [verdict.getNode("culprits").at(i).string() for i in range(2)] == list(given.verdict.culprits)
    assert verdict.getNode("rejected_views").at(0).real() == 3
    assert verdict.getNode("rejected_segments").size() == 0
    assert storage.getNode("rms").getNode("stripes_px").real() == 1e-9
    assert storage.getNode("noise_levels").getNode("robot_translation").getNode("level").real() == 2e-5
    assert storage.getNode("noise_levels").getNode("robot_rotation").getNode("estimated").real() == 0
    assert storage.getNode("lens").getNode("model").string() == "k1-k2"
    assert np.array_equal(storage.getNode("lens").getNode("tests").mat(), given.lens.tests)  # type: ignore[union-attr]
    assert storage.getNode("tool").getNode("accuracy").real() == 1e-5


@versions
def test_safe_load_reads_every_matrix_as_numbers(tmp_path: Path, calibration: Callable[[], Calibration]) -> None:
    given = calibration()
    content = yaml.safe_load(written(tmp_path, given).read_text(encoding="utf-8"))
    for name in MATRICES[given.schema_version]:
        assert all(isinstance(x, float) for x in content[name]["data"]), name
        assert content[name]["data"] == getattr(given, name).reshape(-1).tolist(), name
    assert content["dataset_sha256"] == "12e4567"
    assert content["schema_version"] == given.schema_version
    assert list(content) == [name for name in Calibration.model_fields if getattr(given, name) is not None]


def test_file_names_everything_that_makes_it_a_refined_result(tmp_path: Path) -> None:
    content = yaml.safe_load(written(tmp_path, refined()).read_text(encoding="utf-8"))
    assert (content["schema_version"], content["method"], content["units"]) == (2, "refined", "m")
    assert content["verdict"]["rejected_views"] == [3]
    assert content["noise_levels"]["stripes"] == {"level": 0.05, "lower": 0.04, "upper": 1e5, "estimated": 1}
    assert content["chi_square"]["p_value"] == 0.585


@versions
def test_missing_light_plane_leaves_the_key_out(tmp_path: Path, calibration: Callable[..., Calibration]) -> None:
    path = written(tmp_path, calibration(light_plane=None))
    assert "light_plane" not in yaml.safe_load(path.read_text(encoding="utf-8"))
    assert Calibration.load(path).light_plane is None


def test_infinite_values_survive_all_three_readers(tmp_path: Path) -> None:
    given = refined()
    covariance, intervals = given.covariance.copy(), given.intervals_95.copy()  # type: ignore[union-attr]
    covariance[13, 13] = np.inf
    intervals[13] = -np.inf, np.inf
    path = written(tmp_path, refined(covariance=covariance, intervals_95=intervals))
    read = Calibration.load(path)
    assert read.standard_deviation("tx") == np.inf
    assert read.interval("tx") == (-np.inf, np.inf)
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    assert storage.getNode("covariance").mat()[13, 13] == np.inf
    assert storage.getNode("intervals_95").mat()[13].tolist() == [-np.inf, np.inf]
    assert yaml.safe_load(path.read_text(encoding="utf-8"))["covariance"]["data"][13 * 21] == np.inf


def test_old_result_file_version_1_is_read_for_ever() -> None:
    read = Calibration.load(DATA / "calibration_v1.yaml")
    assert (read.schema_version, read.method) == (1, "closed_form")
    assert read.camera_matrix.tolist() == [[1413.25, 0.0, 321.5], [0.0, 1411.125, 238.75], [0.0, 0.0, 1.0]]
    assert read.t_cam2gripper.tolist() == [0.01, -0.02, 0.1015625]
    assert read.R_cam2gripper.tolist() == [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    assert read.light_plane is not None
    assert read.light_plane.tolist() == [0.0, 0.6, 0.8, 0.25]
    assert read.standard_deviation("fx") == 0.5
    assert read.standard_deviation("d") == 2.0**-12
    assert (read.views, read.points, read.observations, read.stripe_segments) == (14, 1200, 5400, 61)
    assert read.constraints == ("zero_skew", "no_distortion")
    assert read.rms.light_plane_px == 0.0625
    assert (read.verdict, read.noise_levels, read.interval("fx")) == (None, None, None)


def test_old_result_file_is_written_again_as_it_was() -> None:
    path = DATA / "calibration_v1.yaml"
    assert yaml.safe_load(Calibration.load(path).to_yaml()) == yaml.safe_load(path.read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    ("old", "new", "text"),
    [
        ("schema_version: 1", "schema_version: 9", "key 'schema_version': this software reads version 1 and 2 .* 9"),
        ("schema_version: 1\n", "", "key 'schema_version' is missing"),
        ("schema_version: 1", "schema_version: 2", "'closed_form' does not belong to schema_version 2"),
        ("views: 14", "views: 14\nlens: {model: k1}", "key 'lens"),
        ("image_width: 640", "image_width: 640\nexposure: 3", "key 'exposure' is unknown"),
        ("image_width: 640\n", "", "key 'image_width' is missing"),
        ("   rows: 4", "   rows: 5", "key 'light_plane': needs 5 x 1 = 5 numbers in data, given 4"),
        ("dt: d", "dt: f", "needs a matrix map"),
        ("1413.25", "-1413.25", "key 'camera_matrix': needs .* positive fx"),
        ("0.6, 0.8, 0.25", "0.6, 0.7, 0.25", r"key 'light_plane': needs .* given \|n\| = 0.92"),
        ('units: "m"', 'units: "mm"', "key 'units'"),
        ("rotation_px: 0.125", "rotation_px: 0.125\n   foe_px: 1", "key 'rms.foe_px' is unknown"),
        ("   rotation_px: 0.125\n", "", "key 'rms.rotation_px' is missing"),
    ],
)
def test_load_refuses_with_the_name_of_the_key(tmp_path: Path, old: str, new: str, text: str) -> None:
    content = (DATA / "calibration_v1.yaml").read_text(encoding="utf-8")
    if old not in content:
        pytest.fail(f"the committed file no longer holds {old!r}")
    (tmp_path / "c.yaml").write_text(content.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(FileFormatError, match=text):
        Calibration.load(tmp_path / "c.yaml")


def test_standard_deviation_and_interval_name_the_parameters_they_know() -> None:
    assert closed_form().interval("fx") is None
    assert refined().interval("d") == tuple(refined().intervals_95[-1])  # type: ignore[index]
    for ask in (refined().standard_deviation, refined().interval):
        with pytest.raises(KeyError, match=f"k9: is not among the parameters {PARAMETERS[0]}, "):
            ask("k9")


def test_read_camera_takes_ours_and_opencv_files(tmp_path: Path) -> None:
    ours, distortion = read_camera(written(tmp_path, refined()))
    assert np.array_equal(ours, refined().camera_matrix)
    assert np.array_equal(distortion, refined().distortion_coefficients)
    K = np.array([[500.0, 0, 320], [0, 510, 240], [0, 0, 1]])
    storage = cv2.FileStorage(str(tmp_path / "theirs.xml"), cv2.FILE_STORAGE_WRITE)
    storage.write("camera_matrix", K)
    storage.release()
    theirs, none = read_camera(tmp_path / "theirs.xml")
    assert np.array_equal(theirs, K)
    assert np.array_equal(none, np.zeros(5))


def test_read_camera_names_what_is_missing(tmp_path: Path) -> None:
    with pytest.raises(FileFormatError, match="no such file"):
        read_camera(tmp_path / "absent.yaml")
    (tmp_path / "empty.yaml").write_text("%YAML 1.2\n---\nother: 1\n")
    with pytest.raises(FileFormatError, match="key 'camera_matrix' is missing"):
        read_camera(tmp_path / "empty.yaml")
