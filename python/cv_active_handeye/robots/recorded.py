# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Poses that were recorded before, in their order, as if a robot took them: to repeat a capture from files.

A CSV file has a row for every pose and the columns x, y, z (mm) and either rx, ry, rz (rotation vector, rad) or qw, qx,
qy, qz (quaternion); other columns are left alone. Flange in the base frame.
"""

from __future__ import annotations

import csv
import time
from pathlib import Path
from types import TracebackType
from typing import Literal

import numpy as np
from pydantic import BaseModel, ConfigDict
from scipy.spatial.transform import Rotation

from ..dataset import FILE_NAME, Dataset
from ..files import FileFormatError
from .base import Array, MoveRefusedError, RobotError, RobotPose, RobotStoppedError, Speed, StopReason
from .workspace import mm_text

_SAME = 1e-6
_POSITION, _VECTOR, _QUATERNION = ("x", "y", "z"), ("rx", "ry", "rz"), ("qx", "qy", "qz", "qw")


class RecordedConfig(BaseModel):
    """path: the folder of a data set, or a CSV file of poses. model: key of `kinematics.ARMS`, where it is known."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    type: Literal["recorded"] = "recorded"
    path: Path
    model: str | None = None


class RecordedRobot:
    """Stands at the present pose of a recording; a move to the next one, and to no other, goes there at once."""

    def __init__(self, name: str, model: str | None, poses: Array, live: bool) -> None:
        """`poses`: (N, 4, 4), m; the first is the present one."""
        self.name, self.model, self.live = name, model, live
        self._poses = poses
        self._row = 0
        self._stopped = False

    def pose(self) -> RobotPose:
        """Returns the present pose; its joints are not known (NaN)."""
        now = time.monotonic()
        return RobotPose(self._poses[self._row].copy(), np.full(6, np.nan), now, now)

    def check_reachable(self, T_gripper2base: Array) -> None:
        """MoveRefusedError where a pose (4, 4) is none of the recording."""
        if not (np.abs(self._poses - T_gripper2base).max(axis=(1, 2)) <= _SAME).any():
            raise MoveRefusedError(f"{self.name}: the pose at {mm_text(T_gripper2base[:3, 3])} mm is not recorded")

    def move_linear(self, T_gripper2base: Array, speed: Speed) -> None:
        """Goes on to the next pose if it is this one (4, 4) within 1e-6; MoveRefusedError otherwise."""
        if not self.live:
            raise MoveRefusedError(f"{self.name}: was not opened to be moved (live)")
        if self._stopped:
            raise RobotStoppedError(StopReason.OPERATOR, f"{self.name}: a stop was asked for")
        if self._row + 1 >= len(self._poses):
            raise MoveRefusedError(f"{self.name}: the recording ends after {len(self._poses)} poses")
        following = self._poses[self._row + 1]
        if np.abs(following - T_gripper2base).max() > _SAME:
            raise MoveRefusedError(
                f"{self.name}: the next recorded pose is at {mm_text(following[:3, 3])} mm, not the one at "
                f"{mm_text(T_gripper2base[:3, 3])} mm or not with its orientation"
            )
        self._row += 1

    def is_steady(self) -> bool:
        """Always."""
        return True

    def stop(self) -> None:
        """No pose follows any more."""
        self._stopped = True

    def set_output(self, pin: int, on: bool) -> None:
        """RobotError: a recording has no outputs."""
        raise RobotError(f"{self.name}: has no outputs, given pin {pin}")

    def close(self) -> None:
        """Stops."""
        self.stop()

    def __enter__(self) -> RecordedRobot:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def connect(config: RecordedConfig, *, live: bool) -> RecordedRobot:
    """Reads the poses; FileFormatError where there are none."""
    poses = _of_dataset(config.path) if (config.path / FILE_NAME).is_file() else read_poses(config.path)
    if not len(poses):
        raise FileFormatError(f"{config.path}: holds no poses")
    return RecordedRobot(f"recorded {config.path.name}", config.model, poses, live)


def read_poses(path: Path) -> Array:
    """Reads poses (N, 4, 4), m, from a CSV file; FileFormatError names row and column."""
    try:
        with path.open(newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise FileFormatError(f"{path}: cannot be read: {error}") from error
    columns = rows[0].keys() if rows else ()
    turn = _QUATERNION if set(_QUATERNION) <= set(columns) else _VECTOR
    missing = [name for name in (*_POSITION, *turn) if rows and name not in columns]
    if missing:
        raise FileFormatError(f"{path}: needs columns x, y, z and rx, ry, rz or qw, qx, qy, qz; has no {missing[0]}")
    return np.array([_pose(path, i, row, turn) for i, row in enumerate(rows)]).reshape(-1, 4, 4)


def _pose(path: Path, number: int, row: dict[str, str], turn: tuple[str, ...]) -> Array:
    x = np.array([_number(path, number, row, name) for name in (*_POSITION, *turn)])
    if turn is _QUATERNION and abs(np.linalg.norm(x[3:]) - 1) > 1e-3:
        raise FileFormatError(f"{path}: row {number}: the quaternion's length is {np.linalg.norm(x[3:]):.4f}, needs 1")
    rotation = Rotation.from_quat(x[3:]) if turn is _QUATERNION else Rotation.from_rotvec(x[3:])
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = rotation.as_matrix(), x[:3] / 1000
    return T


def _number(path: Path, number: int, row: dict[str, str], name: str) -> float:
    try:
        value = float(row[name])
    except (TypeError, ValueError):
        value = np.nan
    if not np.isfinite(value):
        raise FileFormatError(f"{path}: row {number}: column {name!r}: needs a finite number, given {row[name]!r}")
    return value


def _of_dataset(folder: Path) -> Array:
    dataset = Dataset.open(folder)
    poses = np.tile(np.eye(4), (len(dataset), 1, 1))
    poses[:, :3, :3], poses[:, :3, 3] = dataset.R_gripper2base, dataset.t_gripper2base
    return poses
