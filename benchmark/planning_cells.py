# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The simulated cells of planning.py as a planner knows them and as they are, and the stops that are compared."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

import cv_active_handeye as cah
from cv_active_handeye.robots.workspace import Box, Workspace
from cv_active_handeye.simulation import CellConfig, SimulatedCell
from cv_active_handeye.simulation.motion import STAND_OFF, Look, default_looks
from cv_active_handeye.workflow.plan import make_plan
from cv_active_handeye.workflow.plan_knowledge import Knowledge
from cv_active_handeye.workflow.plan_order import motor_seconds, order_stops
from cv_active_handeye.workflow.plan_settings import PlanSettings
from cv_active_handeye.workflow.plan_views import Start

from . import boards
from .demo_cells import GROUP, HERE, LOOKS_12, LOOKS_24, gripper_poses
from .refine_trials import settings
from .scene import Array
from .world import Noise, World, in_image

Robot = Literal["denso_vp6242", "ur5e"]
ROBOTS: tuple[Robot, ...] = ("denso_vp6242", "ur5e")
NOISE = Noise(0.1, 0.02, 0.005)
BOARD = boards.corners()
POINTS = 400
"""Scene points over 0.4 x 0.4 m; an image shows about a hundred of them."""
LOOKS_18 = [
    *default_looks()[:2],
    Look((18, 0, -90), 0.6 * GROUP),
    *(Look((-18, 0, -35), HERE), Look((0, -18, -90), HERE), Look((12, -12, -60), HERE)),
]
PAPER = {12: LOOKS_12, 14: default_looks(), 18: LOOKS_18, 24: LOOKS_24}
"""The paper's set: two groups of translations, and turns; more of both where there are more stops."""
REACH_MM = 400.0


@dataclass(frozen=True)
class PlanningCell:
    """A simulated cell: where a plan starts, what the planner is told, and what is true."""

    robot: Robot
    start: Start
    asked: PlanSettings
    truth: Knowledge

    @classmethod
    def simulated(cls, robot: Robot, seed: int) -> PlanningCell:
        """The camera looks straight down at the middle of the bench; mounting and optics are told as by a ruler."""
        cell = SimulatedCell(CellConfig(robot=robot, seed=seed))
        pose = gripper_poses(cell, [Look((0, 0, 0), HERE)])[0]
        start = Start("simulated", robot, pose, cell.arm.inverse(pose))
        middle = 1000 * pose[:3, 3]
        box = Box(lower_mm=tuple(middle - REACH_MM), upper_mm=tuple(middle + REACH_MM))
        asked = PlanSettings(
            workspace=Workspace(box=box),
            image_width=640,
            image_height=480,
            focal_px=1400,
            t_cam2gripper_mm=(0, 100, 100),
            R_cam2gripper_deg=(4, -5, 3),
            stand_off_mm=1000 * STAND_OFF,
            stops=24,
            point_sigma_px=NOISE.point_px,
            robot_mm=NOISE.robot_mm,
            robot_deg=NOISE.robot_deg,
        )
        mounted = np.eye(4)
        mounted[:3, :3], mounted[:3, 3] = cell.truth.R_cam2gripper, cell.truth.t_cam2gripper
        camera = pose @ mounted
        spread = np.random.default_rng([seed, 1]).uniform(-1, 1, (POINTS, 3)) * [0.2, 0.2, 0.03]
        points = camera[:3, 3] + STAND_OFF * camera[:3, 2] + spread
        assumed = Knowledge.assumed(start, asked)
        truth = replace(assumed, camera_matrix=cell.truth.camera_matrix, T_cam2gripper=mounted, points=points)
        return cls(robot, start, asked, truth)

    def planned(self, stops: int) -> list[Array]:
        """Flange poses (4, 4) of a plan."""
        plan = make_plan(self.start, self.asked.model_copy(update={"stops": stops}))
        return [stop.T_gripper2base for stop in plan.stops]

    def paper(self, stops: int, seed: int) -> list[Array]:
        """Flange poses (4, 4) of the paper's set over the same bench."""
        return gripper_poses(SimulatedCell(CellConfig(robot=self.robot, seed=seed)), PAPER[stops])

    def world(self, poses: Sequence[Array]) -> World:
        """The true cell with these stops."""
        stops, T = np.asarray(poses), self.truth.T_cam2gripper
        seen = np.ones((len(stops), POINTS), bool)
        K, points = self.truth.camera_matrix, self.truth.points
        world = World(K, np.zeros(5), T[:3, :3], T[:3, 3], stops[:, :3, :3], stops[:, :3, 3], points, seen)
        return replace(world, visible=in_image(world, points))

    def seconds_nearest_next(self, world: World) -> float:
        """Motor time of the stops of a world, from the first on, the nearest next."""
        poses = np.tile(np.eye(4), (len(world.R_gripper2base), 1, 1))
        poses[:, :3, :3], poses[:, :3, 3] = world.R_gripper2base, world.t_gripper2base
        everywhere = Workspace(box=Box(lower_mm=(-1e6,) * 3, upper_mm=(1e6,) * 3))
        free = self.asked.model_copy(update={"workspace": everywhere})
        order = order_stops(Start("free", None, poses[0]), list(poses[1:]), list(range(len(poses) - 1)), free)
        return self.seconds([poses[0], *(poses[1 + i] for i in order.visited)])

    def seconds(self, poses: Sequence[Array]) -> float:
        """Motor time from the first stop on."""
        return motor_seconds(poses[0], list(poses), self.asked)


def board_world(world: World, rng: np.random.Generator, stops: int) -> World:
    """The camera of a world before a board, at random views of it; neither boxes nor arm are asked."""
    orientations, positions = boards.board_stops(rng, stops, BOARD)
    R = orientations @ world.R_cam2gripper.T
    t = positions - R @ world.t_cam2gripper
    return boards.put_board(rng, replace(world, R_gripper2base=R, t_gripper2base=t), BOARD)


def refined_error(world: World, rng: np.random.Generator) -> Array:
    """Rotation [deg] and t_cam2gripper [mm]: squared errors of refineHandEye on one noisy recording, levels given."""
    recording = world.record(rng, NOISE)
    _, _, _, R, t, _, _ = cah.refineHandEye(
        recording.R_gripper2base,
        recording.t_gripper2base,
        recording.image_points,
        world.camera_matrix,
        None,
        world.R_cam2gripper,
        world.t_cam2gripper,
        None,
        params=settings(cah.LENS_FIXED, NOISE),
    )
    return np.asarray(boards.hand_eye_error(world, R, t) ** 2)


def board_error(world: World, rng: np.random.Generator) -> Array:
    """The same (5, 2) of OpenCV's methods on a board; NaN where one has no answer."""
    found = boards.opencv(world.record(rng, NOISE), BOARD).hand_eye
    missing = np.full(2, np.nan)
    return np.array(
        [boards.hand_eye_error(world, *found[name]) ** 2 if name in found else missing for name in boards.METHODS]
    )
