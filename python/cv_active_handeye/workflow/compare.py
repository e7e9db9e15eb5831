# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""OpenCV's board calibration and hand-eye methods beside ours, on one data set.

Without truth the fair question is: how much does the board seem to move in the base frame, where it stands still?
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

import cv_active_handeye as cah

from ..calibration import Calibration
from ..config import CalibrationOptions
from ..dataset import Dataset
from ..files import FloatArray
from ..report.errors import rotation_angle_deg
from .boards import BoardSpec, find_board
from .calibrate import calibrate_with_evidence
from .evidence import ImagePoints, find_points
from .refinement import Start
from .reporter import InsufficientDataError, Reporter, Silent

METHODS = ("TSAI", "PARK", "HORAUD", "ANDREFF", "DANIILIDIS")
MIN_VIEWS = 3
MIN_POINTS = 6


@dataclass(frozen=True)
class BoardCamera:
    """What `cv2.calibrateCamera` makes of the board: RMS in px, K (3, 3), distortion (5,), and which views saw it."""

    rms: float
    camera_matrix: FloatArray
    distortion: FloatArray
    views: list[int]


@dataclass(frozen=True)
class MethodResult:
    """One hand-eye result and how well the board stands still with it.

    `spread_mm`, `spread_deg`: RMS distance and angle of the board's poses in the base frame from their mean;
    `reprojection_px`: RMS distance of the board points from where the mean board pose puts them. `camera` is (K, D)
    where it is ours. `problem` is the text of a method that gave no answer; its other fields are None.
    """

    name: str
    R_cam2gripper: FloatArray | None = None
    t_cam2gripper: FloatArray | None = None
    spread_mm: float | None = None
    spread_deg: float | None = None
    reprojection_px: float | None = None
    camera: tuple[FloatArray, FloatArray] | None = None
    problem: str = ""


@dataclass(frozen=True)
class Comparison:
    """`camera` from the board, and one row per method; ours come last."""

    camera: BoardCamera
    rows: list[MethodResult]


def compare(
    dataset: Dataset,
    board: BoardSpec,
    options: CalibrationOptions | None = None,
    reporter: Reporter | None = None,
    calibration: Calibration | None = None,
) -> Comparison:
    """Calibrates with OpenCV on `board`, target-free with ours, and scores all alike.

    Ours runs twice with the camera unknown (or as `options` say): target-free, and on the corners of the board with
    their known places. Where it finds no start by itself (no pure translations), it starts from the camera of the board
    and OpenCV's best result, and the row says so; also where it calls its own result not usable. A given `calibration`
    is scored instead. Where ours cannot answer, the row holds the reason.
    """
    options, reporter = options or CalibrationOptions(), reporter or Silent()
    points, objects = find_board(dataset, board, reporter.step(f"finding the board in {len(dataset)} views"))
    camera = calibrate_board_camera(dataset, points, objects)
    progress = reporter.step("OpenCV's hand-eye methods")
    rows = opencv_hand_eye(dataset, points, objects, camera)
    progress(1, 1)
    if calibration is not None:
        ours: dict[str, Calibration | str] = {"given calibration": calibration}
    else:
        corners = ImagePoints(points, object_points=objects)
        ours = _ours(dataset, corners, _best(rows, camera), options, reporter)
    for name, result in ours.items():
        if isinstance(result, str):
            rows.append(MethodResult(name, problem=result))
            continue
        K, D = result.camera_matrix, result.distortion_coefficients
        X = _transform(result.R_cam2gripper, result.t_cam2gripper)
        not_usable = "" if result.verdict is None or result.verdict.usable else ", not usable"
        score = score_hand_eye(name + not_usable, dataset, points, objects, camera.views, K, D, X)
        rows.append(replace(score, camera=(K, D)))
    return Comparison(camera, rows)


def _best(rows: list[MethodResult], camera: BoardCamera) -> Start | None:
    """The camera of the board, and the method whose board points miss their places least."""
    scored = [row for row in rows if row.reprojection_px is not None]
    best = min(scored, key=lambda row: row.reprojection_px or 0.0, default=None)
    return None if best is None else Start(camera.camera_matrix, best.R_cam2gripper, best.t_cam2gripper)


def _ours(
    dataset: Dataset,
    corners: ImagePoints,
    start: Start | None,
    options: CalibrationOptions,
    reporter: Reporter,
) -> dict[str, Calibration | str]:
    """Where the closed forms refuse (no pure translations), the refinement begins at `start`."""
    options = options.model_copy(update={"use_laser": False})
    found: dict[str, Calibration | str] = {}
    for name, own in (("ours", None), ("ours, on the board", corners)):
        try:
            points = own or find_points(dataset, options, reporter)
        except InsufficientDataError as error:
            found[name] = str(error)
            continue
        result = _calibration_or_reason(dataset, options, points)
        if isinstance(result, str) and start is not None:
            again = _calibration_or_reason(dataset, options, points, start)
            name, result = (name, result) if isinstance(again, str) else (f"{name}, with a start", again)
        found[name] = result
    return found


def _calibration_or_reason(
    dataset: Dataset, options: CalibrationOptions, points: ImagePoints, start: Start | None = None
) -> Calibration | str:
    try:
        return calibrate_with_evidence(dataset, options, points=points, start=start)[0]
    except (cah.error, InsufficientDataError) as error:
        return str(error)


def calibrate_board_camera(dataset: Dataset, points: FloatArray, objects: FloatArray) -> BoardCamera:
    """`cv2.calibrateCamera` on the views that show at least six points of the board."""
    seen: NDArray[np.bool_] = np.asarray(np.isfinite(points).all(axis=2))
    views = [int(i) for i in np.flatnonzero(seen.sum(axis=1) >= MIN_POINTS)]
    if len(views) < MIN_VIEWS:
        raise InsufficientDataError(
            f"board: needs {MIN_VIEWS} views that show it, found it in {len(views)} of {len(dataset)}"
        )
    object_lists = [objects[seen[i]].astype(np.float32) for i in views]
    image_lists = [points[i, seen[i]].astype(np.float32) for i in views]
    size = (dataset.camera.width, dataset.camera.height)
    no_guess: Any = None
    rms, K, D, _, _ = cv2.calibrateCamera(object_lists, image_lists, size, no_guess, no_guess)
    return BoardCamera(rms, np.asarray(K, np.float64), np.asarray(D, np.float64).reshape(-1), views)


def opencv_hand_eye(
    dataset: Dataset, points: FloatArray, objects: FloatArray, camera: BoardCamera
) -> list[MethodResult]:
    """All methods of `cv2.calibrateHandEye`; where this OpenCV lacks the function every row says so."""
    if not hasattr(cv2, "calibrateHandEye"):
        missing = f"OpenCV {cv2.__version__} for Python has no calibrateHandEye"
        return [MethodResult(f"OpenCV {name}", problem=missing) for name in METHODS]
    K, D = camera.camera_matrix, camera.distortion
    poses = board_poses(points, objects, camera.views, K, D)
    R_g2b = [dataset.R_gripper2base[i] for i in camera.views]
    t_g2b = [dataset.t_gripper2base[i].reshape(3, 1) for i in camera.views]
    R_b2c, t_b2c = [pose[:3, :3] for pose in poses], [pose[:3, 3:] for pose in poses]
    rows = []
    for name in METHODS:
        try:
            R, t = cv2.calibrateHandEye(R_g2b, t_g2b, R_b2c, t_b2c, method=getattr(cv2, f"CALIB_HAND_EYE_{name}"))
        except cv2.error as error:
            rows.append(MethodResult(f"OpenCV {name}", problem=str(error).strip()))
            continue
        X = _transform(R, t)
        if not np.isfinite(X).all():
            rows.append(MethodResult(f"OpenCV {name}", problem="gave NaN"))
            continue
        rows.append(score_hand_eye(f"OpenCV {name}", dataset, points, objects, camera.views, K, D, X))
    return rows


def _transform(R: Any, t: Any) -> FloatArray:
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = R, np.reshape(t, 3)
    return T


def board_poses(
    points: FloatArray, objects: FloatArray, views: list[int], K: FloatArray, D: FloatArray
) -> list[FloatArray]:
    """Board to camera, one (4, 4) per view."""
    poses = []
    for i in views:
        seen = np.isfinite(points[i]).all(axis=1)
        _, rvec, tvec = cv2.solvePnP(objects[seen], points[i, seen], K, D)
        poses.append(_transform(cv2.Rodrigues(rvec)[0], tvec))
    return poses


def score_hand_eye(
    name: str,
    dataset: Dataset,
    points: FloatArray,
    objects: FloatArray,
    views: list[int],
    K: FloatArray,
    D: FloatArray,
    X: FloatArray,
) -> MethodResult:
    """How well the board stands still in the base frame when the camera is K, D and cam2gripper is X."""
    R, t = dataset.R_gripper2base, dataset.t_gripper2base
    gripper = [_transform(R[i], t[i]) for i in views]
    board2base = [G @ X @ B for G, B in zip(gripper, board_poses(points, objects, views, K, D), strict=True)]
    centre = objects.mean(axis=0)
    positions = np.array([B[:3, :3] @ centre + B[:3, 3] for B in board2base])
    U, _, Vt = np.linalg.svd(sum(B[:3, :3] for B in board2base))
    mean = U @ np.diag([1, 1, np.linalg.det(U @ Vt)]) @ Vt
    angles = [rotation_angle_deg(mean.T @ B[:3, :3]) for B in board2base]
    scene = (objects - centre) @ mean.T + positions.mean(axis=0)
    residuals = [_residuals(points[i], scene, K, D, G @ X) for i, G in zip(views, gripper, strict=True)]
    return MethodResult(
        name,
        X[:3, :3],
        X[:3, 3],
        float(1000 * np.sqrt(((positions - positions.mean(axis=0)) ** 2).sum(axis=1).mean())),
        float(np.sqrt(np.mean(np.square(angles)))),
        float(np.sqrt(np.mean(np.concatenate(residuals) ** 2))),
    )


def _residuals(
    observed: FloatArray, scene: FloatArray, K: FloatArray, D: FloatArray, cam2base: FloatArray
) -> FloatArray:
    base2cam = np.linalg.inv(cam2base)
    projected, _ = cv2.projectPoints(scene, cv2.Rodrigues(base2cam[:3, :3])[0], base2cam[:3, 3], K, D)
    distance = np.linalg.norm(projected.reshape(-1, 2) - observed, axis=1)
    return np.asarray(distance[np.isfinite(distance)], np.float64)
