# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""calibration.yaml: every number bit for bit, for us, cv::FileStorage and PyYAML; old files are read for ever."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation

from cv_active_handeye.calibration import (
    CAMERA_PARAMETERS,
    LIGHT_PLANE_PARAMETERS,
    TRANSLATION_PARAMETERS,
    Calibration,
    Rms,
    read_camera,
)
from cv_active_handeye.files import FileFormatError

DATA = Path(__file__).parents[1] / "data"
MATRICES = ("camera_matrix", "distortion_coefficients", "R_cam2gripper", "t_cam2gripper", "light_plane", "covariance")


def calibration(**changes: Any) -> Calibration:
    rng = np.random.default_rng(5)
    names = CAMERA_PARAMETERS + TRANSLATION_PARAMETERS + LIGHT_PLANE_PARAMETERS
    root = rng.normal(size=(15, 15)) * 10.0 ** rng.integers(-12, 3, (15, 15))
    values: dict[str, Any] = {
        "software_version": "0.1.0",
        "dataset_sha256": "12e4567",
        "constraints": ("zero_skew", "no_distortion"),
        "image_width": 640,
        "image_height": 480,
        "camera_matrix": [[1413.1, 1e-7, 320.2], [0, 1e3 + 1 / 3, 240.3], [0, 0, 1]],
        "distortion_coefficients": [-0.1, 1e-5, 0, 5e-324, 1e16],
        "R_cam2gripper": Rotation.random(random_state=rng).as_matrix(),
        "t_cam2gripper": [1e-5, -0.1, 1 / 3],
        "light_plane": [0.0, 0.6, 0.8, 0.3],
        "parameter_names": names,
        "covariance": root @ root.T,
        "rms": Rms(translations_px=0.1, rotation_px=1e-9, light_plane_px=0.05),
        "views": 14,
        "points": 1000,
        "observations": 5000,
        "stripe_segments": 60,
    }
    return Calibration(**(values | changes))


def test_load_returns_every_number_bit_for_bit(tmp_path: Path) -> None:
    written = calibration()
    written.save(tmp_path / "c.yaml")
    read = Calibration.load(tmp_path / "c.yaml")
    for name in MATRICES:
        assert np.array_equal(getattr(read, name), getattr(written, name)), name
    assert read.model_dump(exclude=set(MATRICES)) == written.model_dump(exclude=set(MATRICES))
    assert read.to_yaml() == written.to_yaml()


def test_file_storage_reads_every_matrix_and_number(tmp_path: Path) -> None:
    written = calibration()
    written.save(tmp_path / "c.yaml")
    storage = cv2.FileStorage(str(tmp_path / "c.yaml"), cv2.FILE_STORAGE_READ)
    for name in MATRICES:
        matrix = storage.getNode(name).mat()
        assert matrix.dtype == np.float64, name
        assert np.array_equal(matrix.reshape(getattr(written, name).shape), getattr(written, name)), name
    assert storage.getNode("image_width").real() == 640
    assert storage.getNode("rms").getNode("rotation_px").real() == 1e-9
    assert storage.getNode("dataset_sha256").string() == "12e4567"
    names = storage.getNode("parameter_names")
    assert tuple(names.at(i).string() for i in range(names.size())) == written.parameter_names


def test_safe_load_reads_every_matrix_as_numbers(tmp_path: Path) -> None:
    written = calibration()
    written.save(tmp_path / "c.yaml")
    content = yaml.safe_load((tmp_path / "c.yaml").read_text())
    for name in MATRICES:
        assert all(isinstance(x, float) for x in content[name]["data"]), name
        assert content[name]["data"] == getattr(written, name).reshape(-1).tolist(), name
    assert content["dataset_sha256"] == "12e4567"
    assert content["schema_version"] == 1


def test_missing_light_plane_leaves_the_key_out(tmp_path: Path) -> None:
    names = CAMERA_PARAMETERS + TRANSLATION_PARAMETERS
    written = calibration(light_plane=None, parameter_names=names, covariance=np.eye(11))
    written.save(tmp_path / "c.yaml")
    assert "light_plane" not in yaml.safe_load((tmp_path / "c.yaml").read_text())
    assert Calibration.load(tmp_path / "c.yaml").light_plane is None


def test_infinite_variance_survives_all_three_readers(tmp_path: Path) -> None:
    covariance = np.eye(15)
    covariance[8, 8] = np.inf
    calibration(covariance=covariance).save(tmp_path / "c.yaml")
    assert Calibration.load(tmp_path / "c.yaml").standard_deviation("tx") == np.inf
    storage = cv2.FileStorage(str(tmp_path / "c.yaml"), cv2.FILE_STORAGE_READ)
    assert storage.getNode("covariance").mat()[8, 8] == np.inf
    assert yaml.safe_load((tmp_path / "c.yaml").read_text())["covariance"]["data"][8 * 16] == np.inf


def test_old_result_file_version_1_is_read_for_ever() -> None:
    read = Calibration.load(DATA / "calibration_v1.yaml")
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


@pytest.mark.parametrize(
    ("old", "new", "text"),
    [
        ("schema_version: 1", "schema_version: 9", "key 'schema_version': this software reads version 1 .* says 9"),
        ("schema_version: 1\n", "", "key 'schema_version' is missing"),
        ("image_width: 640", "image_width: 640\nexposure: 3", "key 'exposure' is unknown"),
        ("image_width: 640\n", "", "key 'image_width' is missing"),
        ("   rows: 4", "   rows: 5", "key 'light_plane': needs 5 x 1 = 5 numbers in data, given 4"),
        ("dt: d", "dt: f", "needs a matrix map"),
        ("1413.25", "-1413.25", "key 'camera_matrix': needs .* positive fx"),
        ("0.6, 0.8, 0.25", "0.6, 0.7, 0.25", r"key 'light_plane': needs .* given \|n\| = 0.92"),
        ('units: "m"', 'units: "mm"', "key 'units'"),
        ("rotation_px: 0.125", "rotation_px: 0.125\n   foe_px: 1", "key 'rms.foe_px' is unknown"),
    ],
)
def test_load_refuses_with_the_name_of_the_key(tmp_path: Path, old: str, new: str, text: str) -> None:
    content = (DATA / "calibration_v1.yaml").read_text()
    if old not in content:
        pytest.fail(f"the committed file no longer holds {old!r}")
    (tmp_path / "c.yaml").write_text(content.replace(old, new, 1))
    with pytest.raises(FileFormatError, match=text):
        Calibration.load(tmp_path / "c.yaml")


def test_calibration_refuses_covariance_of_another_size() -> None:
    with pytest.raises(ValueError, match="15 names, 11 rows"):
        calibration(covariance=np.eye(11))


def test_standard_deviation_names_the_parameters_it_knows() -> None:
    with pytest.raises(KeyError, match="k1: is not among the parameters fx, fy"):
        calibration().standard_deviation("k1")


def test_read_camera_takes_ours_and_opencv_files(tmp_path: Path) -> None:
    calibration().save(tmp_path / "ours.yaml")
    K = np.array([[500.0, 0, 320], [0, 510, 240], [0, 0, 1]])
    storage = cv2.FileStorage(str(tmp_path / "theirs.xml"), cv2.FILE_STORAGE_WRITE)
    storage.write("camera_matrix", K)
    storage.release()
    ours, distortion = read_camera(tmp_path / "ours.yaml")
    assert np.array_equal(ours, calibration().camera_matrix)
    assert np.array_equal(distortion, calibration().distortion_coefficients)
    theirs, none = read_camera(tmp_path / "theirs.xml")
    assert np.array_equal(theirs, K)
    assert np.array_equal(none, np.zeros(5))


def test_read_camera_names_what_is_missing(tmp_path: Path) -> None:
    with pytest.raises(FileFormatError, match="no such file"):
        read_camera(tmp_path / "absent.yaml")
    (tmp_path / "empty.yaml").write_text("%YAML 1.2\n---\nother: 1\n")
    with pytest.raises(FileFormatError, match="key 'camera_matrix' is missing"):
        read_camera(tmp_path / "empty.yaml")
