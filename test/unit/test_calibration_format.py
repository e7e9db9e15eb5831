# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A refined result with one wrong field is refused, and the text names the field; its checks one by one."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from support.calibrations import refined

from cv_active_handeye.calibration import REFINED_KEYS, Calibration
from cv_active_handeye.calibration_format import LENS_NAMES, check_covariance, check_distortion, numbers
from cv_active_handeye.files import FileFormatError

REMOVED = object()


def changed_file(folder: Path, key: str, value: Any) -> Path:
    """A valid file in which `key` (dots go into maps) has another value, or none."""
    content = yaml.safe_load(refined().to_yaml())
    *parents, last = key.split(".")
    place = content
    for parent in parents:
        place = place[parent]
    if value is REMOVED:
        del place[last]
    else:
        place[last] = value
    (folder / "c.yaml").write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
    return folder / "c.yaml"


def test_unchanged_content_is_accepted(tmp_path: Path) -> None:
    assert Calibration.load(changed_file(tmp_path, "views", 15)).views == 15


@pytest.mark.parametrize("key", [*REFINED_KEYS, "rms.points_px"])
def test_key_that_belongs_to_a_refined_result_must_be_there(tmp_path: Path, key: str) -> None:
    with pytest.raises(FileFormatError, match=f"key '{key}' is missing"):
        Calibration.load(changed_file(tmp_path, key, REMOVED))


@pytest.mark.parametrize(
    "key", ["verdict.usable", "tool.accuracy", "noise_levels.robot_rotation", "lens.tests", "chi_square.p_value"]
)
def test_key_that_belongs_to_a_part_must_be_there(tmp_path: Path, key: str) -> None:
    with pytest.raises(FileFormatError, match=f"key '{key}' is missing"):
        Calibration.load(changed_file(tmp_path, key, REMOVED))


@pytest.mark.parametrize(
    "key", ["verdict", "tool", "noise_levels", "noise_levels.stripes", "lens", "chi_square", "rms"]
)
def test_unknown_key_of_a_part_is_refused(tmp_path: Path, key: str) -> None:
    with pytest.raises(FileFormatError, match=f"key '{key}.colour' is unknown"):
        Calibration.load(changed_file(tmp_path, f"{key}.colour", "red"))


def test_chi_square_may_be_missing(tmp_path: Path) -> None:
    assert Calibration.load(changed_file(tmp_path, "chi_square", REMOVED)).chi_square is None


def matrix(rows: Any, cols: Any, data: Any) -> dict[str, Any]:
    return {"rows": rows, "cols": cols, "dt": "d", "data": data}


@pytest.mark.parametrize(
    ("key", "value", "text"),
    [
        ("verdict.usable", "perhaps", "key 'verdict.usable'"),
        ("verdict.message", "two\nlines", "key 'verdict.message': needs printable text"),
        ("verdict.culprits", ["a", "b\tc"], "key 'verdict.culprits': needs printable text"),
        ("verdict.rejected_views", [0.5], "key 'verdict.rejected_views.0'"),
        ("verdict.rejected_observations", -1, "key 'verdict.rejected_observations'"),
        ("tool.covariance", matrix(2, 2, [0.0] * 4), "key 'tool.covariance': needs shape 3 x 3, given 2 x 2"),
        ("tool.working_distance", "far", "key 'tool.working_distance'"),
        ("noise_levels.image_points.level", -0.1, "key 'noise_levels.image_points.level'"),
        ("noise_levels.image_points.level", float("nan"), "key 'noise_levels.image_points.level'"),
        ("noise_levels.stated_points_px", 0.0, "key 'noise_levels.stated_points_px'"),
        ("lens.model", "fisheye", "key 'lens.model'"),
        ("lens.tests", matrix(4, 4, [0.0] * 16), "key 'lens.tests': needs shape 5 x 4, given 4 x 4"),
        ("lens.tests", 7, "key 'lens.tests': needs shape 5 x 4, given a single value"),
        ("degrees_of_freedom", matrix(4, 5, [1.0] * 20), "key 'degrees_of_freedom': needs shape n, given 4 x 5"),
        ("intervals_95", matrix(20, 3, [1.0] * 60), "key 'intervals_95': needs shape n x 2, given 20 x 3"),
        ("degrees_of_freedom", matrix(19, 1, [1.0] * 19), "degrees_of_freedom need the same length"),
        ("covariance", matrix(11, 11, np.eye(11).ravel().tolist()), "20 names, 11 rows"),
        ("covariance", matrix(20, 19, [0.0] * 380), "key 'covariance': needs a square matrix"),
        ("covariance", matrix(20, 20, (-np.eye(20)).ravel().tolist()), "key 'covariance': .* negative variances"),
        ("covariance", matrix(20, 20, [float("nan")] * 400), "key 'covariance': .* NaN"),
        ("t_cam2gripper", matrix(3, 1, [0.1, float("inf"), 0]), "key 't_cam2gripper': needs finite numbers"),
        ("R_cam2gripper", matrix(3, 3, np.diag([1, 1, -1.0]).ravel().tolist()), "key 'R_cam2gripper': .* mirrored"),
        ("distortion_coefficients", matrix(3, 1, [0.0] * 3), "key 'distortion_coefficients': needs 4, 5, 8, 12 or 14"),
        ("light_plane", matrix(4, 1, [0, 0.6, 0.8, -0.3]), "key 'light_plane': needs .* d > 0"),
        ("dataset_sha256", "a\u2028b", "key 'dataset_sha256': needs printable text"),
        ("method", "closed_form", "'closed_form' does not belong to schema_version 2"),
        ("image_height", 0, "key 'image_height'"),
    ],
)
def test_wrong_value_is_refused_with_the_name_of_its_key(tmp_path: Path, key: str, value: Any, text: str) -> None:
    with pytest.raises(FileFormatError, match=text):
        Calibration.load(changed_file(tmp_path, key, value))


@pytest.mark.parametrize("key", ["camera_matrix", "distortion_coefficients", "light_plane", "covariance", "lens.tests"])
@pytest.mark.parametrize(
    "value",
    [
        "text",
        ["a", "b"],
        [{"a": 1}],
        [[1.0, 2.0], [3.0]],
        {"rows": 3, "cols": 3, "data": [0.0] * 9},
        matrix(3, 3, 5),
        matrix("three", 3, [0.0] * 9),
        matrix(-3, -3, [0.0] * 9),
        matrix(3.0, 3.0, [0.0] * 9),
        matrix(3, 3, [0.0] * 8 + ["x"]),
        matrix(3, 3, [0.0] * 8 + [None]),
    ],
    ids=str,
)
def test_what_is_no_matrix_is_refused_with_the_name_of_its_key(tmp_path: Path, key: str, value: Any) -> None:
    with pytest.raises(FileFormatError, match=f"key '{key}': needs"):
        Calibration.load(changed_file(tmp_path, key, value))


def test_lens_names_are_in_the_order_of_the_library() -> None:
    cah = pytest.importorskip("cv_active_handeye")
    constants = (cah.LENS_FIXED, cah.LENS_K1, cah.LENS_K1_K2, cah.LENS_TANGENTIAL, cah.LENS_K3)
    assert [LENS_NAMES[int(constant)] for constant in constants] == list(LENS_NAMES)


def test_checks_return_read_only_arrays_of_their_own() -> None:
    given = np.eye(3)
    for checked in (check_covariance(given), numbers(3, 3)(given), check_distortion(np.zeros((5, 1)))):
        assert not checked.flags.writeable
        assert not np.shares_memory(checked, given)
    assert given.flags.writeable


def test_numbers_takes_columns_for_vectors_and_keeps_infinities() -> None:
    column = np.array([[1.0], [np.inf], [np.nan]])
    assert np.array_equal(numbers(None)(column), [1, np.inf, np.nan], equal_nan=True)
    assert numbers(None)([3.0]).shape == (1,)


def test_result_without_refined_keys_is_one_of_version_1() -> None:
    content = {key: value for key, value in refined().model_dump().items() if key not in (*REFINED_KEYS, "chi_square")}
    del content["schema_version"], content["method"]
    content["rms"] = {"translations_px": 0.1, "rotation_px": 0.1}
    given = Calibration.model_validate(content)
    assert (given.schema_version, given.method) == (1, "closed_form")
