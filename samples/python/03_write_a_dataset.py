# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Writes a data set from your own robot and camera, view by view; then `cv-active-handeye calibrate` does the rest.

Replace `read_robot` and `read_camera` by calls of your devices. A recording that was interrupted continues where it
stopped: every view is complete on the disk before `add_view` returns.

Run: python samples/python/03_write_a_dataset.py out/recording
"""

import sys
import time
from pathlib import Path

import numpy as np

from cv_active_handeye.dataset import CameraInfo, Dataset, LaserInfo

STOPS = 4


def read_robot(stop: int) -> tuple[np.ndarray, np.ndarray]:
    """Orientation (3 x 3) and position (metres) of the gripper in the base frame, as the controller reports them."""
    return np.eye(3), np.array([0.4, 0.05 * stop, 0.6])


def read_camera(laser: bool) -> np.ndarray:
    """An image, 480 x 640, 8 bit, grey."""
    image = np.full((480, 640), 60, np.uint8)
    image[238:242] = 250 if laser else 60
    return image


folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/recording")
if (folder / "dataset.yaml").exists():
    dataset = Dataset.open(folder)
else:
    camera = CameraInfo(width=640, height=480, name="my camera")
    dataset = Dataset.create(folder, camera=camera, laser=LaserInfo(stripe="horizontal"), planned_views=STOPS)

for stop in range(len(dataset), STOPS):
    R, t = read_robot(stop)
    off, on = read_camera(laser=False), read_camera(laser=True)
    view = dataset.add_view(R, t, image=off, laser_image=on, timestamp=time.time())
    print(f"view {view.index}: {view.image}, {view.laser_image}")

print("complete" if not dataset.problems() else dataset.problems())
