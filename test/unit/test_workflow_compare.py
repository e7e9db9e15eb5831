# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The comparison with OpenCV: boards are found, methods are scored alike, missing functions are said."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from rich.console import Console
from scipy.spatial.transform import Rotation
from support.calibrations import refined

from cv_active_handeye.cli.tables import cameras_table
from cv_active_handeye.dataset import CameraInfo, Dataset
from cv_active_handeye.workflow import BoardSpec, InsufficientDataError, compare
from cv_active_handeye.workflow.boards import find_board

K = np.array([[900.0, 0, 320], [0, 905, 240], [0, 0, 1]])
X = Rotation.from_euler("xyz", [4, -7, 60], degrees=True).as_matrix()
NAMES = ("ours", "ours, on the board")
X_POSITION = np.array([0.03, -0.05, 0.08])


def board_views(count: int = 10) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Gripper poses (V, 4, 4) that look at a board in the base plane z = 0, and board-to-camera poses, all exact."""
    rng = np.random.default_rng(11)
    camera = np.eye(4)
    camera[:3, :3], camera[:3, 3] = X, X_POSITION
    grippers, boards = [], []
    for _ in range(count):
        cam2base = np.eye(4)
        angles = [180 + rng.uniform(-25, 25), rng.uniform(-25, 25), rng.uniform(0, 90)]
        cam2base[:3, :3] = Rotation.from_euler("xyz", angles, degrees=True).as_matrix()
        cam2base[:3, 3] = np.array([0.5, 0.1, 0.0]) - rng.uniform(0.5, 0.7) * cam2base[:3, 2]
        grippers.append(cam2base @ np.linalg.inv(camera))
        boards.append(np.linalg.inv(cam2base))
    return np.array(grippers), np.array(boards)


def recorded(folder: Path, noise_mm: float = 0.0, noise_px: float = 0.0) -> Dataset:
    """A data set with board points; `noise_mm` moves the reported gripper positions, `noise_px` the points."""
    rng = np.random.default_rng(12)
    grippers, boards = board_views()
    corners = np.mgrid[:9, :6].T.reshape(-1, 2) * 0.02 + [0.42, 0.05]
    board = np.column_stack([corners, np.zeros(54)])
    dataset = Dataset.create(folder, camera=CameraInfo(width=640, height=480))
    points = []
    for gripper, pose in zip(grippers, boards, strict=True):
        dataset.add_view(gripper[:3, :3], gripper[:3, 3] + rng.normal(size=3) * noise_mm / 1000)
        projected, _ = cv2.projectPoints(board, cv2.Rodrigues(pose[:3, :3])[0], pose[:3, 3], K, np.zeros(5))
        points.append(projected.reshape(-1, 2))
    dataset.set_image_points(np.array(points) + noise_px * rng.normal(size=(len(points), 54, 2)), board)
    return dataset


needs_calibrate_hand_eye = pytest.mark.skipif(
    not hasattr(cv2, "calibrateHandEye"), reason=f"OpenCV {cv2.__version__} for Python has no calibrateHandEye"
)


@needs_calibrate_hand_eye
def test_exact_board_gives_all_five_methods_and_a_board_that_stands_still(tmp_path: Path) -> None:
    comparison = compare(recorded(tmp_path / "set"), BoardSpec.parse("points"))
    assert [row.name for row in comparison.rows[:5]] == [
        f"OpenCV {name}" for name in ("TSAI", "PARK", "HORAUD", "ANDREFF", "DANIILIDIS")
    ]
    assert comparison.camera.camera_matrix == pytest.approx(K, abs=0.05)
    for row in comparison.rows[:5]:
        assert row.t_cam2gripper == pytest.approx(X_POSITION, abs=2e-4), row.name
        assert row.R_cam2gripper == pytest.approx(X, abs=2e-4), row.name
        assert row.spread_mm is not None
        assert row.spread_mm < 0.05, row.name
        assert row.reprojection_px is not None
        assert row.reprojection_px < 0.1, row.name


@needs_calibrate_hand_eye
def test_wrong_robot_positions_show_as_spread(tmp_path: Path) -> None:
    comparison = compare(recorded(tmp_path / "set", noise_mm=2.0), BoardSpec.parse("points"))
    for row in comparison.rows[:5]:
        assert row.spread_mm is not None
        assert 1.0 < row.spread_mm < 6.0, row.name


@needs_calibrate_hand_eye
def test_ours_without_translations_starts_from_the_best_on_the_board_and_says_so(tmp_path: Path) -> None:
    comparison = compare(recorded(tmp_path / "set", noise_px=0.002), BoardSpec.parse("points"))
    ours = comparison.rows[5:]
    assert [row.name for row in ours] == [f"{name}, with a start" for name in NAMES]
    for row in ours:
        assert row.problem == ""
        assert row.t_cam2gripper == pytest.approx(X_POSITION, abs=2e-4), row.name
        assert row.R_cam2gripper == pytest.approx(X, abs=2e-4), row.name
        assert row.camera is not None
        assert row.camera[0] == pytest.approx(K, abs=0.3)
        assert row.reprojection_px is not None
        assert row.reprojection_px < 0.1


def test_ours_that_cannot_start_holds_the_reason(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(cv2, "calibrateHandEye", raising=False)
    comparison = compare(recorded(tmp_path / "set"), BoardSpec.parse("points"))
    assert [row.name for row in comparison.rows[5:]] == list(NAMES)
    for row in comparison.rows[5:]:
        assert "equal orientation" in row.problem
        assert row.R_cam2gripper is None


@needs_calibrate_hand_eye
def test_given_calibration_is_scored_instead_of_ours(tmp_path: Path) -> None:
    given = refined(camera_matrix=K, distortion_coefficients=np.zeros(5), R_cam2gripper=X, t_cam2gripper=X_POSITION)
    comparison = compare(recorded(tmp_path / "set"), BoardSpec.parse("points"), calibration=given)
    (row,) = comparison.rows[5:]
    assert row.name == "given calibration"
    assert row.spread_mm == pytest.approx(0, abs=1e-3)
    assert row.spread_deg == pytest.approx(0, abs=1e-4)
    assert row.reprojection_px == pytest.approx(0, abs=1e-3)


def test_opencv_without_calibrate_hand_eye_is_said_and_the_rest_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delattr(cv2, "calibrateHandEye", raising=False)
    comparison = compare(recorded(tmp_path / "set"), BoardSpec.parse("points"))
    for row in comparison.rows[:5]:
        assert row.problem == f"OpenCV {cv2.__version__} for Python has no calibrateHandEye"
    assert comparison.camera.camera_matrix == pytest.approx(K, abs=0.05)


def drawn_board(board: BoardSpec) -> NDArray[np.uint8]:
    """The board as a fronto-parallel image, 40 px a unit, on white."""
    image = np.full((480, 640), 255, np.uint8)
    for i in range(board.columns + (board.kind == "chessboard")):
        for j in range(board.rows + (board.kind == "chessboard")):
            if board.kind == "circles":
                cv2.circle(image, (100 + 40 * i, 100 + 40 * j), 10, 0, -1, cv2.LINE_AA)
            elif (i + j) % 2 == 0:
                cv2.rectangle(image, (100 + 40 * i, 100 + 40 * j), (139 + 40 * i, 139 + 40 * j), 0, -1)
    return np.asarray(cv2.GaussianBlur(image, (0, 0), 1.0), np.uint8)


@pytest.mark.parametrize("text", ["chessboard:8x6:20", "circles:9x6:20", "charuco:9x6:20:15:DICT_4X4_50"])
def test_find_board_finds_every_kind_at_its_spacing(tmp_path: Path, text: str) -> None:
    board = BoardSpec.parse(text)
    if board.kind == "charuco":
        dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
        image = cv2.aruco.CharucoBoard((9, 6), 0.02, 0.015, dictionary).generateImage((640, 480), marginSize=40)
        pixels_per_metre = 560 / 9 / 0.02
    else:
        image, pixels_per_metre = drawn_board(board), 40 / 0.02
    dataset = Dataset.create(tmp_path / "set", camera=CameraInfo(width=640, height=480))
    dataset.add_view(np.eye(3), [0, 0, 0], image=np.asarray(image, np.uint8))
    points, objects = find_board(dataset, board, lambda done, total: None)
    assert np.isfinite(points).all()
    distances = np.linalg.norm(points[0][1:] - points[0][0], axis=1)
    expected = np.linalg.norm(objects[1:] - objects[0], axis=1) * pixels_per_metre
    assert distances == pytest.approx(expected, abs=1.5)


def test_board_that_is_not_there_is_refused_with_counts(tmp_path: Path) -> None:
    dataset = Dataset.create(tmp_path / "set", camera=CameraInfo(width=64, height=48))
    dataset.add_view(np.eye(3), [0, 0, 0], image=np.zeros((48, 64), np.uint8))
    with pytest.raises(InsufficientDataError, match="needs 3 views that show it, found it in 0 of 1"):
        compare(dataset, BoardSpec.parse("chessboard:8x6:20"))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("chess:8x6:20", "there is no kind 'chess'"),
        ("chessboard:8x6", "the number of fields is wrong"),
        ("chessboard:8:20", "not enough values"),
        ("chessboard:8x6:-2", "lengths positive"),
        ("charuco:9x6:20:15:DICT_9X9", "OpenCV has no 'DICT_9X9'"),
    ],
)
def test_board_texts_that_make_no_sense_are_refused(text: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        BoardSpec.parse(text)


@needs_calibrate_hand_eye
def test_table_of_cameras_on_a_narrow_terminal_cuts_no_digits_off(tmp_path: Path) -> None:
    comparison = compare(recorded(tmp_path / "set"), BoardSpec.parse("points"))
    distortion = np.array([-0.19, -0.71, -0.0012, -0.0034, 5.77])
    comparison = replace(comparison, camera=replace(comparison.camera, distortion=distortion))
    console = Console(width=80, record=True)
    console.print(cameras_table(comparison))
    text = console.export_text()
    assert "…" not in text
    assert all(number in text for number in ("900.", "905.", "320.", "240.", "-0.19", "-0.71", "5.77"))
