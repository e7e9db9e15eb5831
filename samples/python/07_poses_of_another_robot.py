# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A data set from a table of poses and a folder of images: for robots this software has no driver for.

The table is a CSV file with a row for every stop: x, y, z (mm) and rx, ry, rz (rotation vector, rad) or qw, qx, qy, qz,
flange in the base frame. The images are taken in their order by name: one for every row, or with --laser two (laser
off, laser on).

  python samples/python/07_poses_of_another_robot.py POSES IMAGES out/recorded [--laser]
  cv-active-handeye calibrate out/recorded -o out/recorded/calibration.yaml

Without arguments it makes such a table and such images in the simulated cell first (extra sim), as an example.
"""

import argparse
import csv
import shutil
from pathlib import Path

import cv2
from scipy.spatial.transform import Rotation

from cv_active_handeye.dataset import CameraInfo, Dataset, LaserInfo
from cv_active_handeye.robots.recorded import read_poses

FORMATS = {(2, "uint8"): "mono8", (2, "uint16"): "mono16", (3, "uint8"): "bgr8", (3, "uint16"): "bgr16"}


def example(folder: Path) -> tuple[Path, Path]:
    """Writes poses.csv and images of a simulated recording; returns both places."""
    from cv_active_handeye.simulation import CellConfig
    from cv_active_handeye.workflow.simulate import simulate

    simulated = simulate(folder / "simulated", folder / "truth.yaml", CellConfig(laser=False))[0]
    images = folder / "images"
    images.mkdir()
    with (folder / "poses.csv").open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["x", "y", "z", "rx", "ry", "rz"])
        for view in simulated.views:
            turn = Rotation.from_matrix(view.R_gripper2base).as_rotvec()
            table.writerow([*(1000 * view.t_gripper2base).tolist(), *turn.tolist()])
            assert view.image is not None
            shutil.copy(simulated.folder / view.image, images / f"{view.index:04}.png")
    return folder / "poses.csv", images


parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("poses", nargs="?", type=Path, help="CSV file of poses")
parser.add_argument("images", nargs="?", type=Path, help="folder of images")
parser.add_argument("folder", nargs="?", type=Path, default=Path("out/recorded"), help="a new folder for the data set")
parser.add_argument("--laser", action="store_true", help="two images a pose: laser off, laser on")
options = parser.parse_args()

poses_file, images = options.poses, options.images
if images is None:
    poses_file, images = example(Path("out/recorded_example"))
poses = read_poses(poses_file)
files = sorted(path for path in images.iterdir() if path.is_file())
needed = len(poses) * (2 if options.laser else 1)
if len(files) != needed:
    raise SystemExit(f"error: {images}: needs {needed} images for {len(poses)} poses, holds {len(files)}")


def read(path: Path) -> cv2.typing.MatLike:
    """The image as it is in the file."""
    image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    if image is None:
        raise SystemExit(f"error: {path}: cannot be read as an image")
    return image


first = read(files[0])
camera = CameraInfo.model_validate(
    {
        "width": first.shape[1],
        "height": first.shape[0],
        "pixel_format": FORMATS[(first.ndim, str(first.dtype))],
        "name": images.name,
    }
)
laser = LaserInfo(stripe="horizontal") if options.laser else None
dataset = Dataset.create(options.folder, camera=camera, laser=laser, planned_views=len(poses))
for i, pose in enumerate(poses):
    if options.laser:
        off, on = read(files[2 * i]), read(files[2 * i + 1])
    else:
        off, on = read(files[i]), None
    dataset.add_view(pose[:3, :3], pose[:3, 3], image=off, laser_image=on)
print(f"{len(dataset)} views in {dataset.folder}; next: cv-active-handeye calibrate {dataset.folder}")
