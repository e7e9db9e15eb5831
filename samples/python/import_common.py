# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What the importers of recorded data share: two CSV tables and the images become a data set.

`poses_T_base_gripper.csv`: image, then a row-major 4 x 4 matrix T with p_base = T p_gripper, metres.
`corners.csv`: image, X_m, Y_m, Z_m on the board, u_px, v_px in the image.
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path
from typing import cast

import cv2
import numpy as np
from numpy.typing import NDArray

from cv_active_handeye.dataset import CameraInfo, Dataset, Image, LaserInfo

Array = NDArray[np.float64]


def arguments(description: str | None) -> argparse.Namespace:
    """The two arguments every importer takes."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("source", type=Path, help="folder with the recorded data")
    parser.add_argument("dataset", type=Path, help="folder to write the data set to (must not hold one)")
    return parser.parse_args()


def read_poses(path: Path) -> dict[str, Array]:
    """Image name -> 4 x 4 pose, in the order of the file."""
    with path.open(newline="") as stream:
        rows = list(csv.reader(stream))[1:]
    return {row[0]: np.array(row[1:], dtype=np.float64).reshape(4, 4) for row in rows}


def read_corners(path: Path, names: list[str]) -> tuple[Array, Array]:
    """Image points (V, N, 2), NaN = not seen, and board points (N, 3): one column for every place on the board."""
    with path.open(newline="") as stream:
        rows = list(csv.reader(stream))[1:]
    places = sorted({tuple(float(x) for x in row[1:4]) for row in rows}, key=lambda p: (p[1], p[0]))
    column = {place: j for j, place in enumerate(places)}
    points = np.full((len(names), len(places), 2), np.nan)
    for row in rows:
        x, y, z = (float(value) for value in row[1:4])
        points[names.index(row[0]), column[x, y, z]] = float(row[4]), float(row[5])
    return points, np.array(places)


def nearest_rotation(R: Array) -> Array:
    """The rotation closest to `R`: recorded matrices are rounded and may miss orthonormality by a few 1e-6."""
    U, _, Vt = np.linalg.svd(R)
    return np.asarray(U @ np.diag([1.0, 1.0, np.linalg.det(U @ Vt)]) @ Vt, np.float64)


def import_folder(
    source: Path, target: Path, camera: CameraInfo, description: str, laser: LaserInfo | None = None
) -> Dataset:
    """Writes the data set; with `laser` the images count as taken with the laser on. Images may be absent."""
    poses = read_poses(source / "poses_T_base_gripper.csv")
    dataset = Dataset.create(target, camera=camera, laser=laser, description=description, planned_views=len(poses))
    complete = all((source / "images" / name).is_file() for name in poses)
    for name, T in poses.items():
        pixels = cv2.imread(str(source / "images" / name), cv2.IMREAD_UNCHANGED) if complete else None
        image = cast("Image | None", pixels)
        dataset.add_view(
            nearest_rotation(T[:3, :3]),
            T[:3, 3],
            image=image if laser is None else None,
            laser_image=image if laser is not None else None,
        )
    dataset.set_image_points(*read_corners(source / "corners.csv", list(poses)))
    found = "with images" if complete else "without images"
    print(f"{target}: {len(dataset)} views {found}, problems: {dataset.problems() or 'none'}")
    return dataset
