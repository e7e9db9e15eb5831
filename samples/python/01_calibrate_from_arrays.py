# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Calibrates camera and hand-eye transform from plain arrays: poses of the robot and pixels of scene points.

Needs numpy only. The arrays come from a made-up camera here, so that the result can be checked; in your program the
poses come from the robot and the pixels from any tracker: row j is the same scene point in every view, NaN = not seen.

Run: python samples/python/01_calibrate_from_arrays.py
"""

import numpy as np

import cv_active_handeye as cah


def rotation(axis: list[float], degrees: float) -> np.ndarray:
    """Rotation matrix about an axis (Rodrigues' formula)."""
    x, y, z = np.asarray(axis) / np.linalg.norm(axis)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = np.radians(degrees)
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


rng = np.random.default_rng(1)

# The truth nobody tells the calibration.
true_camera = np.array([[1413.0, 0, 320], [0, 1410, 240], [0, 0, 1]])
true_R, true_t = rotation([0.3, -0.5, 1], 25), np.array([0.04, -0.06, 0.05])
scene = rng.uniform([-0.15, -0.12, 0.50], [0.15, 0.12, 0.65], (80, 3))

# The robot: two orientations with five stops each (four translations), and two more orientations.
steps = 0.05 * np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0.7, 0.7, 0.7]])
turns = [np.eye(3), rotation([1, 0.3, 0], 15), rotation([0, 0, 1], 70), rotation([0.2, -1, 0], 15)]
start = true_R.T  # the camera looks along the z axis of the base frame
R_gripper2base, t_gripper2base = [], []
for turn, stops in zip(turns, (5, 5, 1, 1), strict=True):
    for step in steps[:stops]:
        R = turn @ start
        R_gripper2base.append(R)
        t_gripper2base.append(step + turn @ [0, 0, -0.57] + [0, 0, 0.57] - R @ true_t)

# What the camera sees, with 0.1 px of noise; what falls outside of 640 x 480 is not seen.
imagePoints = []
for R, t in zip(R_gripper2base, t_gripper2base, strict=True):
    in_camera = ((scene - t) @ R - true_t) @ true_R
    pixels = in_camera @ true_camera.T
    pixels = pixels[:, :2] / pixels[:, 2:] + rng.normal(0, 0.1, (len(scene), 2))
    pixels[(pixels < 0).any(axis=1) | (pixels > [639, 479]).any(axis=1)] = np.nan
    imagePoints.append(pixels)

# The calibration: pure translations give K and R, changes of orientation give t.
rms, cameraMatrix, R_cam2gripper, covariance = cah.calibrateHandEyeTranslations(
    R_gripper2base, t_gripper2base, imagePoints, None, None, flags=cah.TRANSLATIONS_ZERO_SKEW
)
print(f"K and R: RMS {rms:.3f} px\n{cameraMatrix.round(2)}\n{R_cam2gripper.round(5)}")
print("sigma of fx, fy, cx, cy [px]:", np.sqrt(np.diag(covariance))[:4].round(2))

rms, t_cam2gripper, covariance = cah.calibrateHandEyeRotation(
    R_gripper2base, t_gripper2base, imagePoints, cameraMatrix, None, R_cam2gripper
)
print(f"t: RMS {rms:.3f} px, {(1000 * t_cam2gripper.ravel()).round(2)} mm")

cosine = (np.trace(true_R.T @ R_cam2gripper) - 1) / 2
errors = np.degrees(np.arccos(min(cosine, 1.0))), 1000 * np.linalg.norm(t_cam2gripper.ravel() - true_t)
print(
    f"errors: fx {cameraMatrix[0, 0] - true_camera[0, 0]:+.2f} px, rotation {errors[0]:.3f} deg, t {errors[1]:.2f} mm"
)
