# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Point clouds as PLY files, read back by trimesh, which shares no code with the writer."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

from cv_active_handeye.ply import write_ply

POINTS = np.random.default_rng(1).normal(size=(50, 3))
VALUES: dict[str, NDArray[Any]] = {
    "sigma": np.append(np.linspace(1e-5, 1e-3, 49), np.inf).astype(np.float32),
    "intensity": np.linspace(0, 65535, 50).astype(np.float32),
    "view": np.arange(50, dtype=np.int32),
}


def test_trimesh_reads_every_value_bit_for_bit(tmp_path: Path) -> None:
    write_ply(tmp_path / "cloud.ply", POINTS, (), **VALUES)
    cloud = trimesh.load(tmp_path / "cloud.ply")
    assert isinstance(cloud, trimesh.PointCloud)
    np.testing.assert_array_equal(cloud.vertices, POINTS)
    table = cloud.metadata["_ply_raw"]["vertex"]["data"]
    assert table.dtype.names == ("x", "y", "z", "sigma", "intensity", "view")
    for name, values in VALUES.items():
        assert table[name].dtype == values.dtype, name
        np.testing.assert_array_equal(table[name], values)


def test_header_says_what_the_file_holds(tmp_path: Path) -> None:
    write_ply(tmp_path / "cloud.ply", POINTS, ("base frame, metres", "sigma: mm"), **VALUES)
    head = (tmp_path / "cloud.ply").read_bytes().split(b"end_header\n")[0].decode().splitlines()
    assert head == [
        "ply",
        "format binary_little_endian 1.0",
        "comment base frame, metres",
        "comment sigma: mm",
        "element vertex 50",
        *(f"property double {axis}" for axis in "xyz"),
        "property float sigma",
        "property float intensity",
        "property int view",
    ]


def test_cloud_without_points_is_a_valid_file(tmp_path: Path) -> None:
    write_ply(tmp_path / "cloud.ply", np.zeros((0, 3)), sigma=np.zeros(0, np.float32))
    assert b"element vertex 0\n" in (tmp_path / "cloud.ply").read_bytes()


@pytest.mark.parametrize(
    ("name", "values"), [("sigma", np.zeros(3)), ("view", np.zeros(50, np.int64)), ("sigma", np.zeros((50, 1)))]
)
def test_values_that_cannot_be_written_are_refused_by_name(tmp_path: Path, name: str, values: NDArray[Any]) -> None:
    with pytest.raises(ValueError, match=rf"{name}: needs 50 numbers \(float64, float32 or int32\), given "):
        write_ply(tmp_path / "cloud.ply", POINTS, (), **{name: values})
    assert not (tmp_path / "cloud.ply").exists()


def test_comment_of_two_lines_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="comments: needs one line each"):
        write_ply(tmp_path / "cloud.ply", POINTS, ("a\nelement face 3",))
