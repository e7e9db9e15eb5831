# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Going on with a capture that ended early, after looking whether everything still stands where it stood."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from ..dataset import Dataset, Image
from ..files import FileFormatError, FloatArray
from ..plan_file import Plan
from ..robots.workspace import step_size
from .capture import PLAN_NAME, CaptureError, CaptureSettings, Station
from .event_log import EventLog
from .settle import SettleSettings, settle

LARGEST_SHIFT = 1.0
"""Pixels by which the whole image may differ from that of the same stop before."""


def reopen(folder: Path, station: Station, settings: SettleSettings) -> tuple[Plan, Dataset]:
    """Opens an unfinished capture; FileFormatError where it does not belong to this camera, robot or plan."""
    dataset, plan = Dataset.open(folder), Plan.load(folder / PLAN_NAME)
    have, need = station.camera.info, dataset.camera
    if (have.width, have.height, have.pixel_format) != (need.width, need.height, need.pixel_format):
        raise FileFormatError(
            f"{folder}: was taken with {need.width} x {need.height} {need.pixel_format}, the camera gives "
            f"{have.width} x {have.height} {have.pixel_format}"
        )
    if dataset.description != station.robot.robot.name:
        raise FileFormatError(f"{folder}: was taken with {dataset.description}, this is {station.robot.robot.name}")
    if len(dataset) > len(plan.stops):
        raise FileFormatError(f"{folder}: holds {len(dataset)} views, its plan has {len(plan.stops)} stops")
    for view in dataset.views:
        stop = plan.stops[view.index].T_gripper2base
        _check_near(_matrix(view.R_gripper2base, view.t_gripper2base), stop, settings, f"{folder}: view {view.index}")
    return plan, dataset


def check_again(dataset: Dataset, plan: Plan, station: Station, settings: CaptureSettings, log: EventLog) -> None:
    """Goes back to the last stop taken and compares pose and image with what is stored.

    CaptureError where the image shifted: scene or camera were moved, and old and new views do not belong together.
    """
    if len(dataset) == 0:
        return
    last = len(dataset) - 1
    target = plan.stops[last].T_gripper2base
    log("check_again", view=last)
    station.robot.move_to(target)
    settle(station.robot, target, settings.settle)
    station.laser.switch(False)
    before = dataset.image(last)
    shift = None if before is None else image_shift(before, station.camera.grab().image)
    log("checked_again", view=last, shift_px=shift)
    if shift is not None and not shift <= LARGEST_SHIFT:
        raise CaptureError(
            f"{dataset.folder}: at the stop of view {last} the image is {shift:.1f} px away from the stored one (at "
            f"most {LARGEST_SHIFT:g}): the scene, the camera or the light was changed; begin a new capture"
        )


def image_shift(before: Image, now: Image) -> float:
    """By how many pixels the whole image moved, found by phase correlation (cv2); inf where nothing agrees."""
    a, b = (_grey(image) for image in (before, now))
    window = cv2.createHanningWindow((a.shape[1], a.shape[0]), cv2.CV_64F)
    (u, v), response = cv2.phaseCorrelate(a, b, window)
    return float(np.hypot(u, v)) if response > 0.1 else float("inf")


def _grey(image: Image) -> FloatArray:
    return np.asarray(image.mean(axis=2) if image.ndim == 3 else image, dtype=np.float64)


def _check_near(pose: FloatArray, stop: FloatArray, settings: SettleSettings, where: str) -> None:
    length, angle = step_size(pose, stop)
    if 1000 * length > settings.arrival_mm or angle > settings.arrival_deg:
        raise FileFormatError(
            f"{where}: its pose is {1000 * length:.3f} mm and {angle:.4f} deg from its stop in {PLAN_NAME}; plan and "
            f"views do not belong together"
        )


def _matrix(R: FloatArray, t: FloatArray) -> FloatArray:
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = R, t
    return out
