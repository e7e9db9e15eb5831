# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The seam of a weld joint from laser images, with the functions of the C++ module: the paper's application.

In every laser image: the stripe, its straight pieces, the corner where the two faces of the groove meet. All corners
together become points of the base frame with covariances. The same as the command `seam`, which has more comforts.

Run: make demo; python samples/python/05_weld_seam.py out/demo/scan out/demo/calibration.yaml
"""

import sys

import numpy as np

import cv_active_handeye as cah
from cv_active_handeye.calibration import Calibration
from cv_active_handeye.dataset import Dataset

if len(sys.argv) != 3:
    sys.exit(__doc__)
dataset, calibration = Dataset.open(sys.argv[1]), Calibration.load(sys.argv[2])
K, D, light_plane = calibration.camera_matrix, calibration.distortion_coefficients, calibration.light_plane
OPENING_DEG, TOLERANCE_DEG, LEAST_COLUMNS = 60, 20, 8

pixels, covariances, views = [], [], []
for view in dataset.views:
    image = dataset.laser_image(view.index)
    if image is None:
        continue
    stripe, sigmas = cah.detectStripe(image, background=dataset.image(view.index))
    if len(stripe) == 0:
        continue
    pieces = cah.splitStripe(stripe, sigmas, K, D, minPoints=LEAST_COLUMNS)
    corners, spreads, angles, _ = cah.findProfileCorners(stripe, sigmas, pieces, K, D, light_plane)
    off = np.abs(angles.reshape(-1) - OPENING_DEG)
    if len(off) and off.min() <= TOLERANCE_DEG:
        pixels.append(corners[off.argmin()])
        covariances.append(spreads[off.argmin()])
        views.append(view.index)
if not views:
    sys.exit(f"{sys.argv[1]}: no groove of {OPENING_DEG} degrees in {len(dataset)} views")

points, spread, _ = cah.measureStripePoints(
    dataset.R_gripper2base,
    dataset.t_gripper2base,
    pixels,
    views,
    range(len(views)),
    K,
    D,
    light_plane,
    calibration.R_cam2gripper,
    calibration.t_cam2gripper,
    calibrationCovariance=calibration.covariance,
    pixelCovariances=covariances,
    robotTranslationSigma=calibration.noise_levels.robot_translation.level,
    robotRotationSigma=calibration.noise_levels.robot_rotation.level,
)

print("view,x,y,z,sigma_x,sigma_y,sigma_z  [mm]")
for view, point, covariance in zip(views, points, spread, strict=True):
    numbers = 1000 * np.concatenate([point, np.sqrt(np.diag(covariance))])
    print(view, *(f"{number:.3f}" for number in numbers), sep=",")
