# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The data set on disk: what is written is read back, and what is wrong is refused by name."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import numpy as np
import pytest
import yaml
from numpy.typing import NDArray
from pydantic import ValidationError
from scipy.spatial.transform import Rotation

import cv_active_handeye as cah
from cv_active_handeye.dataset import CameraInfo, Dataset, LaserInfo
from cv_active_handeye.dataset_format import PixelFormat
from cv_active_handeye.files import FileFormatError
from cv_active_handeye.workflow.evidence import stripe_params

Image = NDArray[np.uint8] | NDArray[np.uint16]
CAMERA = CameraInfo(width=32, height=24, name="test camera")


def rotation(seed: int) -> NDArray[np.float64]:
    return np.asarray(Rotation.random(random_state=np.random.default_rng(seed)).as_matrix())


def picture(seed: int, pixel_format: PixelFormat = "mono8") -> Image:
    rng = np.random.default_rng(seed)
    shape = (24, 32, 3) if pixel_format.startswith("bgr") else (24, 32)
    if pixel_format.endswith("16"):
        return rng.integers(0, 65536, shape, dtype=np.uint16)
    return rng.integers(0, 256, shape, dtype=np.uint8)


def recording(folder: Path, views: int = 3) -> Dataset:
    dataset = Dataset.create(folder, camera=CAMERA, laser=LaserInfo(), planned_views=3)
    for i in range(views):
        dataset.add_view(rotation(i), [1e-5 * i, 1 / 3, -0.1], image=picture(i), laser_image=picture(10 + i))
    return dataset


def edit(folder: Path, **changes: object) -> None:
    content = yaml.safe_load((folder / "dataset.yaml").read_text())
    content.update(changes)
    (folder / "dataset.yaml").write_text(yaml.safe_dump(content))


def test_open_returns_poses_and_images_bit_for_bit(tmp_path: Path) -> None:
    written = recording(tmp_path / "set")
    read = Dataset.open(tmp_path / "set")
    assert np.array_equal(read.R_gripper2base, np.array([rotation(i) for i in range(3)]))
    assert np.array_equal(read.t_gripper2base, [[1e-5 * i, 1 / 3, -0.1] for i in range(3)])
    for i in range(3):
        image, laser_image = read.image(i), read.laser_image(i)
        assert image is not None
        assert laser_image is not None
        assert np.array_equal(image, picture(i))
        assert np.array_equal(laser_image, picture(10 + i))
    assert read.camera == CAMERA
    assert read.laser == LaserInfo()
    assert read.problems() == []
    assert read.sha256() == written.sha256()


@pytest.mark.parametrize("pixel_format", ["mono8", "mono16", "bgr8", "bgr16"])
def test_images_of_every_pixel_format_return_unchanged(tmp_path: Path, pixel_format: PixelFormat) -> None:
    camera = CameraInfo(width=32, height=24, pixel_format=pixel_format)
    Dataset.create(tmp_path / "set", camera=camera).add_view(np.eye(3), [0, 0, 0], image=picture(1, pixel_format))
    image = Dataset.open(tmp_path / "set").image(0)
    assert image is not None
    assert image.dtype == picture(1, pixel_format).dtype
    assert np.array_equal(image, picture(1, pixel_format))


def test_view_without_images_returns_none_and_keeps_the_rest(tmp_path: Path) -> None:
    dataset = Dataset.create(tmp_path / "set", camera=CAMERA)
    dataset.add_view(np.eye(3), [[1], [2], [3]], surface_id=4, timestamp=1.5e9)
    view = Dataset.open(tmp_path / "set").views[0]
    assert (view.image, view.laser_image, view.surface_id, view.timestamp) == (None, None, 4, 1.5e9)
    assert view.t_gripper2base.tolist() == [1, 2, 3]


def test_create_refuses_a_folder_that_holds_a_data_set(tmp_path: Path) -> None:
    recording(tmp_path / "set")
    with pytest.raises(FileExistsError, match="already holds a data set"):
        Dataset.create(tmp_path / "set", camera=CAMERA)


def test_open_refuses_a_folder_without_data_set(tmp_path: Path) -> None:
    with pytest.raises(FileFormatError, match=r"holds no dataset\.yaml"):
        Dataset.open(tmp_path)
    with pytest.raises(FileFormatError, match="there is no such folder"):
        Dataset.open(tmp_path / "absent")


def test_half_written_data_set_opens_and_says_what_is_missing(tmp_path: Path) -> None:
    recording(tmp_path / "set", views=2)
    (tmp_path / "set/images/0001_laser.png").unlink()
    (tmp_path / "set/images/0000.png").write_bytes((tmp_path / "set/images/0000.png").read_bytes()[:60])
    (tmp_path / "set/images/0002.png").write_bytes(b"written, but the power failed before dataset.yaml was")
    problems = Dataset.open(tmp_path / "set").problems()
    assert len(problems) == 4
    assert problems[0] == "1 of 3 planned views are missing (views 2 to 2)"
    assert problems[1].startswith("images/0000.png: cannot be decoded")
    assert problems[2] == "images/0001_laser.png: the file is missing"
    assert problems[3].startswith("images/0002.png: no view names this file")


def test_many_files_that_no_view_names_are_told_in_one_sentence(tmp_path: Path) -> None:
    recording(tmp_path / "set", views=3)
    for index in range(5, 10):
        (tmp_path / f"set/images/{index:04}.png").write_bytes(b"left over")
    assert Dataset.open(tmp_path / "set").problems() == [
        "images/0005.png and 4 more: no view names these files (views that were not completed?)"
    ]


def test_poses_in_millimetres_are_told(tmp_path: Path) -> None:
    dataset = recording(tmp_path / "set", views=2)
    dataset.add_view(rotation(2), [400.0, -200.0, 350.0], image=picture(2))
    (problem,) = dataset.problems()
    assert problem.startswith("t_gripper2base: the views are up to 56")
    assert "needs metres" in problem


def test_add_view_continues_a_half_written_data_set(tmp_path: Path) -> None:
    recording(tmp_path / "set", views=2)
    (tmp_path / "set/images/0002.png").write_bytes(b"left over")
    Dataset.open(tmp_path / "set").add_view(rotation(2), [0, 0, 0], image=picture(2))
    read = Dataset.open(tmp_path / "set")
    assert len(read) == 3
    assert read.problems() == []


def test_crash_while_writing_a_view_leaves_the_earlier_views(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    dataset = recording(tmp_path / "set", views=2)
    replace = os.replace

    def disk_full(source: str, target: Path) -> None:
        if Path(target).name == "dataset.yaml":
            raise OSError(errno.ENOSPC, "no space left")
        replace(source, target)

    monkeypatch.setattr(os, "replace", disk_full)
    with pytest.raises(OSError, match="no space left"):
        dataset.add_view(rotation(2), [0, 0, 0], image=picture(2))
    assert len(dataset) == 2
    read = Dataset.open(tmp_path / "set")
    assert len(read) == 2
    assert any("images/0002.png: no view names this file" in problem for problem in read.problems())


def test_files_are_durable_before_they_replace_the_old_ones(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[str] = []
    fsync, replace = os.fsync, os.replace

    def told_fsync(descriptor: int) -> None:
        calls.append("fsync")
        fsync(descriptor)

    def told_replace(source: Path, target: Path) -> None:
        calls.append(f"rename {target.name}")
        replace(source, target)

    monkeypatch.setattr(os, "fsync", told_fsync)
    monkeypatch.setattr(os, "replace", told_replace)
    dataset = Dataset.create(tmp_path / "set", camera=CAMERA)
    calls.clear()
    dataset.add_view(np.eye(3), [0, 0, 0], image=picture(0))
    assert calls == ["fsync", "rename 0000.png", "fsync", "fsync", "rename dataset.yaml", "fsync"]


@pytest.mark.parametrize(
    ("R", "text"),
    [
        (1.001 * np.eye(3), r"key 'R_gripper2base': is not a rotation: max\|R\^T R - I\| = 0.002"),
        (np.diag([1.0, 1.0, -1.0]), "determinant is -1"),
        (np.eye(4), "needs shape 3x3, given 4x4"),
        (np.full((3, 3), np.nan), "finite"),
        ("up", "needs numbers of shape 3x3"),
    ],
)
def test_add_view_refuses_what_is_not_a_rotation(tmp_path: Path, R: object, text: str) -> None:
    dataset = Dataset.create(tmp_path / "set", camera=CAMERA)
    with pytest.raises(ValueError, match=text):
        dataset.add_view(R, [0, 0, 0])
    assert len(Dataset.open(tmp_path / "set")) == 0


def test_add_view_refuses_an_image_of_another_size_or_type(tmp_path: Path) -> None:
    dataset = Dataset.create(tmp_path / "set", camera=CAMERA)
    with pytest.raises(ValueError, match=r"needs uint8 of shape \(24, 32\), given uint8 of shape \(24, 31\)"):
        dataset.add_view(np.eye(3), [0, 0, 0], image=picture(0)[:, 1:])
    with pytest.raises(ValueError, match="given uint16"):
        dataset.add_view(np.eye(3), [0, 0, 0], image=picture(0, "mono16"))
    assert Dataset.open(tmp_path / "set").problems() == ["there are no views"]


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"gain": 3}, "key 'gain' is unknown"),
        ({"schema_version": 2}, "key 'schema_version': this software reads version 1 .* the file says 2"),
        ({"units": "mm"}, "key 'units'"),
        ({"camera": {"width": 32}}, "key 'camera.height' is missing"),
        ({"camera": {"width": 32, "height": 24, "gain": 1}}, "key 'camera.gain' is unknown"),
        ({"image_points": "../elsewhere.csv"}, "inside the data set's folder"),
        ({"views": [{"index": 1, "R_gripper2base": np.eye(3).tolist(), "t_gripper2base": [0, 0, 0]}]}, "needs index 0"),
    ],
)
def test_open_refuses_with_the_name_of_the_key(tmp_path: Path, changes: dict[str, object], text: str) -> None:
    recording(tmp_path / "set")
    edit(tmp_path / "set", **changes)
    with pytest.raises(FileFormatError, match=text):
        Dataset.open(tmp_path / "set")


def test_open_refuses_unknown_keys_and_bad_rotations_in_views(tmp_path: Path) -> None:
    recording(tmp_path / "set")
    content = yaml.safe_load((tmp_path / "set/dataset.yaml").read_text())
    content["views"][1]["laser"] = True
    content["views"][2]["R_gripper2base"][0][0] = 2.0
    (tmp_path / "set/dataset.yaml").write_text(yaml.safe_dump(content))
    with pytest.raises(FileFormatError) as caught:
        Dataset.open(tmp_path / "set")
    assert "key 'views.1.laser' is unknown" in str(caught.value)
    assert "key 'views.2.R_gripper2base': is not a rotation" in str(caught.value)


@pytest.mark.parametrize("text", ["views: [", "- a list", "", "schema_version: 1\nschema_version: 1\n"])
def test_open_refuses_what_is_not_a_map_of_unique_keys(tmp_path: Path, text: str) -> None:
    (tmp_path / "dataset.yaml").write_text(text)
    with pytest.raises(FileFormatError, match=r"dataset\.yaml"):
        Dataset.open(tmp_path)


def test_sha256_changes_with_a_pixel_a_pose_and_a_point(tmp_path: Path) -> None:
    hashes = {recording(tmp_path / "a").sha256(), recording(tmp_path / "b").sha256()}
    assert len(hashes) == 1
    changed = recording(tmp_path / "c", views=2)
    pixels = picture(2)
    pixels[0, 0] ^= 1
    changed.add_view(rotation(2), [2e-5, 1 / 3, -0.1], image=pixels, laser_image=picture(12))
    hashes.add(changed.sha256())
    moved = recording(tmp_path / "d", views=2)
    moved.add_view(rotation(2), [2e-5, 1 / 3, -0.1000001], image=picture(2), laser_image=picture(12))
    hashes.add(moved.sha256())
    moved.set_image_points(np.zeros((3, 4, 2)))
    hashes.add(moved.sha256())
    assert len(hashes) == 4


@pytest.mark.parametrize("sigma_px", [0.4, 21.0, float("nan")])
def test_laser_width_out_of_range_is_refused(sigma_px: float) -> None:
    with pytest.raises(ValidationError, match="sigma_px"):
        LaserInfo(sigma_px=sigma_px)


def test_laser_width_and_direction_reach_the_detector(tmp_path: Path) -> None:
    laser = LaserInfo(stripe="vertical", sigma_px=4.0)
    Dataset.create(tmp_path / "set", camera=CAMERA, laser=laser).add_view(rotation(0), [0, 0, 0.1], image=picture(0))
    params = stripe_params(Dataset.open(tmp_path / "set"))
    assert (params.orientation, params.sigma) == (cah.STRIPE_VERTICAL, 4.0)
