# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Where the camera could go: orientations about what it looks at, and translations, as arm and boxes allow."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from ..files import FloatArray
from ..robots.base import MoveRefusedError, Robot
from ..robots.kinematics import SerialArm, UnreachableError, arm
from .plan_settings import PlanSettings
from .reporter import InsufficientDataError

Tilt = tuple[float, float]

_STEP_SHARE, _STEP_DEG = 0.08, 2.5  # of the reach; on the way to a possible view: chosen ways are checked closely
_ROLLS_DEG = (0.0, 60.0, 120.0, 180.0)
_TILTS = (
    *((0, 0), (1, 0), (0, 1), (-1, 0), (0, -1), (0.7, 0.7), (-0.7, 0.7), (-0.7, -0.7), (0.7, -0.7)),
    *((0.5, 0), (0, 0.5), (-0.5, 0), (0, -0.5)),
)
_PLACES = np.array([(0, 0, 0), (0, 0, 1), (0, 0, -1), *np.ndindex(2, 2, 2)], dtype=np.float64)
_PLACES[3:] = 2 * _PLACES[3:] - 1
_MIDDLE = np.zeros(3)


@dataclass(frozen=True)
class Start:
    """Where a plan begins. robot: `Robot.name`; model: key of `kinematics.ARMS` or None; T_gripper2base (4, 4), m;
    joints (6,), rad, None where the model is not known."""

    robot: str
    model: str | None
    T_gripper2base: FloatArray
    joints: FloatArray | None = None

    @property
    def arm(self) -> SerialArm | None:
        """The arm's geometry, where it is known."""
        return None if self.model is None else arm(self.model)


@dataclass
class Views:
    """Flange poses (4, 4) that are possible, and how many were refused for which reason, with an example of each."""

    poses: list[FloatArray] = field(default_factory=list)
    refused: Counter[str] = field(default_factory=Counter)
    examples: dict[str, str] = field(default_factory=dict)

    def refuse(self, kind: str, text: str, count: int = 1) -> None:
        """Counts poses that are not possible; the first text of every kind is kept."""
        self.refused[kind] += count
        self.examples.setdefault(kind, text)

    def obstacles(self) -> str:
        """What is in the way, the most frequent reason first, each with an example."""
        total = sum(self.refused.values()) + len(self.poses)
        found = [f"{count} by {kind} ({self.examples[kind]})" for kind, count in self.refused.most_common()]
        return f"of {total} views looked at {sum(self.refused.values())} are refused: {'; '.join(found)}"


def start_of(robot: Robot) -> Start:
    """Where an opened robot stands now."""
    pose = robot.pose()
    return Start(robot.name, robot.model, pose.T_gripper2base, None if robot.model is None else pose.joints)


def scene_of(start: Start, settings: PlanSettings) -> FloatArray:
    """Assumed scene points (N, 3), base frame, m: spread over what the camera sees from the start, seeded."""
    rng = np.random.default_rng(settings.seed)
    K = settings.camera_matrix
    half_depth = min(settings.scene_depth_mm, 0.5 * settings.stand_off_mm) / 1000
    depth = settings.stand_off_mm / 1000 + rng.uniform(-half_depth, half_depth, settings.tracks)
    pixels = rng.uniform(0, 1, (settings.tracks, 2)) * (settings.image_width - 1, settings.image_height - 1)
    rays = np.column_stack([pixels, np.ones(len(pixels))]) @ np.linalg.inv(K).T
    T = start.T_gripper2base @ settings.T_cam2gripper
    return np.asarray((rays * depth[:, None]) @ T[:3, :3].T + T[:3, 3])


def surface_of(start: Start, settings: PlanSettings) -> FloatArray:
    """The plane (1, 4) on which stripes are predicted: across the optical axis of the start, at the stand-off."""
    T = start.T_gripper2base @ settings.T_cam2gripper
    normal = -T[:3, 2]
    point = T[:3, 3] + settings.stand_off_mm / 1000 * T[:3, 2]
    return np.array([[*normal, normal @ point]])


def possible_views(start: Start, settings: PlanSettings) -> Views:
    """Views of a grid that boxes and arm allow; InsufficientDataError names what is in the way where there are none."""
    try:
        settings.workspace.check_pose(start.T_gripper2base)
    except MoveRefusedError as error:
        raise InsufficientDataError(f"the start pose itself is not allowed: {error}") from error
    if start.arm is not None and start.joints is None:
        raise InsufficientDataError(f"start: needs the joints of the {start.arm.name}, given none")
    grid = _Grid(start, settings)
    for side in (1, -1):
        grid.add_side(side)
    if len(grid.views.poses) < 2:
        raise InsufficientDataError(f"{len(grid.views.poses)} views are possible: {grid.views.obstacles()}")
    return grid.views


class _Grid:
    """Orientation by orientation, each reached from one nearby so that the joints are followed."""

    def __init__(self, start: Start, settings: PlanSettings) -> None:
        self._start, self._settings, self.views = start, settings, Views()

    def add_side(self, side: int) -> None:
        """All views rolled to one side, from roll to roll."""
        joints = self._start.joints
        for roll in _ROLLS_DEG:
            if roll > self._settings.roll_deg or (side < 0 and roll in (0.0, 180.0)):
                continue
            middle = flange_pose(self._start, self._settings, (0, 0), side * roll, _MIDDLE)
            try:
                joints = self._follow(joints, middle)
            except UnreachableError:
                try:
                    joints = self._anyhow(middle)
                except UnreachableError as error:
                    self.views.refuse("the arm", str(error), len(_PLACES) * len(_TILTS))
                    continue
            for tilt in _TILTS:
                self._add_orientation(tilt, side * roll, joints)

    def _add_orientation(self, tilt: Tilt, roll_deg: float, joints: FloatArray | None) -> None:
        try:
            middle = self._follow(joints, flange_pose(self._start, self._settings, tilt, roll_deg, _MIDDLE))
        except UnreachableError as error:
            self.views.refuse("the arm", str(error), len(_PLACES))
            return
        for place in _PLACES:
            pose = flange_pose(self._start, self._settings, tilt, roll_deg, place)
            try:
                self._settings.workspace.check_pose(pose)
                self._follow(middle, pose)
                self.views.poses.append(pose)
            except MoveRefusedError as error:
                self.views.refuse("the boxes", str(error))
            except UnreachableError as error:
                self.views.refuse("the arm", str(error))

    def _anyhow(self, pose: FloatArray) -> FloatArray | None:
        """Joints for a pose to which no straight line leads from here; another stop's may."""
        arm, joints = self._start.arm, self._start.joints
        return None if arm is None or joints is None else arm.inverse(pose, near=joints)

    def _follow(self, joints: FloatArray | None, pose: FloatArray) -> FloatArray | None:
        arm = self._start.arm
        if arm is None or joints is None:
            return None
        return np.asarray(arm.follow(joints, pose, _STEP_SHARE * arm.reach, _STEP_DEG)[-1])


def flange_pose(start: Start, settings: PlanSettings, tilt: Tilt, roll_deg: float, place: FloatArray) -> FloatArray:
    """Flange pose (4, 4), m: the camera tilted and rolled about what it looks at from the start, then displaced.

    tilt: about the image's x and y axes, in units of tilt_deg; roll_deg: about the optical axis; place (3,): in
    units of translation_mm along the camera's axes.
    """
    T = start.T_gripper2base @ settings.T_cam2gripper
    turn = Rotation.from_euler("xyz", [*(settings.tilt_deg * np.array(tilt)), roll_deg], degrees=True)
    aim = T[:3, 3] + settings.stand_off_mm / 1000 * T[:3, 2]
    camera = np.eye(4)
    camera[:3, :3] = T[:3, :3] @ turn.as_matrix()
    seen_from = settings.translation_mm * place - [0, 0, settings.stand_off_mm]
    camera[:3, 3] = aim + camera[:3, :3] @ (seen_from / 1000)
    return np.asarray(camera @ np.linalg.inv(settings.T_cam2gripper))
