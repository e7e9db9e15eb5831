# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A calibration as a recording for the rerun viewer: robot, camera, images, tracks, scene and light plane in 3-D."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
from numpy.typing import NDArray

from ..calibration import Calibration
from ..dataset import Dataset
from ..files import FloatArray
from .figures_motion import known_scene_points
from .inputs import ReportInput

if TYPE_CHECKING:
    import rerun as rr

    from ..workflow import Evidence

USED, LEFT_OUT, LIGHT = (255, 225, 77), (213, 94, 0), (213, 94, 0, 60)
"""Colours of image points and of the light plane."""

CAMERA = "base/gripper/camera"
JPEG_QUALITY = 85


def require_rerun() -> None:
    """RuntimeError without the viewer's package: told before a calibration, not after it."""
    if importlib.util.find_spec("rerun") is None:
        raise RuntimeError("--rerun needs the package rerun-sdk: pip install 'cv_active_handeye[viz]'")


def write_rerun(path: Path, dataset: Dataset, calibration: Calibration, evidence: Evidence) -> None:
    """Writes `path` (.rrd); the timeline "view" goes through the stops. Metres, base frame, z up."""
    import rerun as rr

    assert evidence.summary is not None
    case = ReportInput(dataset, calibration, evidence, evidence.summary)
    path.parent.mkdir(parents=True, exist_ok=True)
    recording = rr.RecordingStream("cv_active_handeye")
    recording.save(path)
    _log_what_stands_still(recording, case)
    for view in range(len(dataset)):
        recording.set_time("view", sequence=view)
        _log_view(recording, case, view)
    recording.flush()
    recording.disconnect()


def _log_what_stands_still(recording: rr.RecordingStream, case: ReportInput) -> None:
    import rerun as rr

    calibration = case.calibration
    recording.log("base", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    recording.log("base/scene", rr.Points3D(known_scene_points(case), colors=(150, 150, 150)), static=True)
    recording.log("base/path", rr.LineStrips3D([case.dataset.t_gripper2base]), static=True)
    cam2gripper = rr.Transform3D(translation=calibration.t_cam2gripper, mat3x3=calibration.R_cam2gripper)
    recording.log(CAMERA, cam2gripper, static=True)
    size = list(case.image_size)
    pinhole = rr.Pinhole(image_from_camera=calibration.camera_matrix, resolution=size)
    recording.log(f"{CAMERA}/image", pinhole, static=True)
    if calibration.light_plane is not None:
        corners = _light_plane(calibration.light_plane, case.summary.workingDistance)
        both_sides = [[0, 1, 2], [0, 2, 3], [2, 1, 0], [3, 2, 0]]
        mesh = rr.Mesh3D(vertex_positions=corners, triangle_indices=both_sides, albedo_factor=LIGHT)
        recording.log(f"{CAMERA}/light_plane", mesh, static=True)


def _log_view(recording: rr.RecordingStream, case: ReportInput, view: int) -> None:
    import rerun as rr

    R, t = case.dataset.R_gripper2base[view], case.dataset.t_gripper2base[view]
    recording.log("base/gripper", rr.Transform3D(translation=t, mat3x3=R))
    for name, image in (("image", case.dataset.image(view)), ("image/laser", case.dataset.laser_image(view))):
        if image is not None:
            jpeg = _jpeg(image)
            recording.log(f"{CAMERA}/{name}", rr.EncodedImage(contents=jpeg, media_type="image/jpeg"))
    for name, chosen, colour in (("used", case.used[view], USED), ("left_out", case.rejected[view], LEFT_OUT)):
        points = rr.Points2D(case.image_points[view][chosen], colors=colour, radii=2)
        recording.log(f"{CAMERA}/image/{name}", points)
    recording.log("reprojection_error_px", rr.Scalars(float(case.view_rms[view])))


def _jpeg(image: NDArray[Any]) -> bytes:
    pixels = (image // 257).astype(np.uint8) if image.dtype == np.uint16 else image
    done, data = cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    assert done
    return data.tobytes()


def _light_plane(plane: FloatArray, distance: float) -> FloatArray:
    """Corners (4, 3) of a square of the plane around the optical axis at a working distance, camera frame."""
    n, d = np.asarray(plane[:3]), float(plane[3])
    across = np.cross(n, np.eye(3)[np.abs(n).argmin()])
    across /= np.linalg.norm(across)
    along = np.cross(n, across)
    middle = np.array([0, 0, distance])
    middle = middle + n * (d - n @ middle)
    square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * 0.4 * distance
    return np.asarray(middle + square @ np.stack([across, along]))
