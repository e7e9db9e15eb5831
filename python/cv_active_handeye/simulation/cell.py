# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The simulated cell: robot, camera, laser and workbench behind the controls a real cell has."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ..dataset import Dataset
from ..dataset_format import CameraInfo, LaserInfo
from ..robots import kinematics
from . import exact, marks, motion, nominal
from .bench import weld_root, workbench
from .config import CellConfig
from .desk import desk
from .exact import StripeTruth
from .laser import Laser
from .lettering import Mark
from .light import Lamp
from .optics import Camera, Sensor
from .parts import Array, Patch
from .render import Renderer
from .robot_errors import RobotErrors
from .scene import Scene
from .truth import TrueView, Truth

Image = NDArray[np.uint8] | NDArray[np.uint16]
StopLight = tuple[NDArray[np.float32], NDArray[np.float32] | None]
"""Noise-free light on the sensor (H, W), laser off and on (None in a cell without laser)."""

_HARDWARE, _SCENE, _ROBOT, _SENSOR, _BUMP = range(5)  # keys of the independent random streams
_FIRST_STOP = {"default": 0, "check": 1000, "scan": 2000, "experiment": 3000}  # every visit has noise of its own
_LAMPS = [Lamp((-0.35, 0.30, 0.9), 0.12, 0.62), Lamp((0.5, -0.1, 1.1), 0.25, 0.30)]
_AMBIENT, _AMBIENT_WITHOUT_LAMP = 0.22, 1.0
_AIM = np.array([0.0, 0.0, 0.02])
_BENCH = {"denso_vp6242": (0.311, 0.0, -0.315), "ur5e": (0.50, 0.0, -0.10)}  # its centre in the base frame


@dataclass(frozen=True)
class SimulatedView:
    """One stop. T_reported: what the controller says; T_true: where the flange was (both 4 x 4, gripper to base, m).

    image: laser off; laser_image: laser on, None in a cell without laser; index: the stop its noise belongs to.
    """

    T_reported: Array
    image: Image
    laser_image: Image | None
    T_true: Array
    index: int


class SimulatedCell:
    """A robot with camera and line laser over a workbench. Same configuration, same bytes."""

    def __init__(self, config: CellConfig | None = None) -> None:
        """Sets up robot, camera and laser; the bench is built when it is first looked at (some seconds)."""
        self.config = config or CellConfig()
        self.arm = kinematics.arm(self.config.robot)
        rng = np.random.default_rng([self.config.seed, _HARDWARE])
        self.camera = _camera(self.config, rng)
        self._T_mount2gripper = _mounting(rng)
        self._T_cam2gripper = self._T_mount2gripper @ _bump(self.config)
        self.laser = _laser(self.config, rng)
        self._T_bench2base = _bench_pose(self.config, rng)
        self._errors = RobotErrors(self.config, _ROBOT)
        self._recorded: list[Array] = []
        self._captured = 0

    @cached_property
    def scene(self) -> Scene:
        """The workbench, in its own frame."""
        patches, _, rng = _things(self.config)
        c = self.config
        repeat = c.repeat_mm if c.texture == "repeated" else 0.0
        lamps, ambient = (_LAMPS, _AMBIENT) if c.lamp else ([], _AMBIENT_WITHOUT_LAMP)
        return Scene(patches, c.texel_mm, lamps, ambient, repeat, rng)

    @cached_property
    def marks(self) -> list[Mark]:
        """The marks of the scene, in its own frame; a scene that is not the experiment's has none."""
        return _things(self.config)[1]

    @cached_property
    def _renderer(self) -> Renderer:
        c = self.config
        sensor = Sensor(c.full_well_electrons, c.read_noise_electrons, c.bit_depth)
        return Renderer(self.scene, self.camera, self.laser, sensor, c)

    def plan(self) -> list[Array]:
        """Return the commanded poses (4, 4), gripper to base, of the motion, all reachable; they know of no bump."""
        to_gripper = np.linalg.inv(self._T_mount2gripper)
        cameras = self._cameras()
        poses = [self._T_bench2base @ pose @ to_gripper for pose in cameras]
        motion.check_motion(self.arm, poses)
        return poses

    def start(self) -> Array:
        """Return the commanded pose (4, 4) of the motion's first stop."""
        return np.asarray(self._T_bench2base @ self._cameras()[0] @ np.linalg.inv(self._T_mount2gripper))

    def _cameras(self) -> list[Array]:
        if self.config.motion == "experiment":
            return marks.measuring_poses(self.laser, self.marks)
        return motion.camera_poses(motion.LOOKS[self.config.motion](), _AIM)

    def capture(self, T_gripper2base: Array, index: int | None = None) -> SimulatedView:
        """Move to a commanded pose (4, 4) and take an image with the laser off and, if there is one, on.

        index: the stop whose noise is drawn; None counts the captures of this cell. Raises UnreachableError.
        """
        stop = self._captured if index is None else index
        self.arm.inverse(T_gripper2base)
        reported = self._errors.reported(np.asarray(T_gripper2base, dtype=np.float64), stop)
        true = self._errors.true(reported, stop)
        rng = np.random.default_rng([self.config.seed, _SENSOR, stop])
        image, laser_image = self._renderer.take(self._T_cam2bench(true), rng)
        self._captured += 1
        return SimulatedView(reported, image, laser_image, true, stop)

    def light(self, T_gripper2base: Array, stop: int) -> StopLight:
        """Return what falls on the sensor with the flange at a true pose (4, 4); `stop` draws the stripe's grain."""
        rng = np.random.default_rng([self.config.seed, _SENSOR, stop, 0])
        return self._renderer.irradiance(self._T_cam2bench(T_gripper2base), rng)

    def expose(self, light: NDArray[np.float32], stop: int, count: int) -> Image:
        """Return the image of such light (H, W); the noise is that of exposure number `count` at this stop."""
        rng = np.random.default_rng([self.config.seed, _SENSOR, stop, 1 + count])
        return self._renderer.expose(light, rng)

    @property
    def camera_info(self) -> CameraInfo:
        """Size and pixel format of the images."""
        c = self.config
        return CameraInfo(
            width=c.width, height=c.height, pixel_format="mono8" if c.bit_depth == 8 else "mono16", name="simulated"
        )

    def record(
        self,
        folder: str | Path,
        progress: Callable[[int, int], None] | None = None,
        poses: Sequence[Array] | None = None,
    ) -> Dataset:
        """Record `poses` (default: `plan()`) into a new data set; `progress` gets (stops done, all stops)."""
        stops = self.plan() if poses is None else [np.asarray(pose, dtype=np.float64) for pose in poses]
        motion.check_motion(self.arm, stops)
        c = self.config
        dataset = Dataset.create(
            folder,
            camera=self.camera_info,
            laser=LaserInfo(name="simulated") if c.laser else None,
            description=f"simulated cell, {self.arm.name}",
            planned_views=len(stops),
        )
        self._recorded = []
        for i, pose in enumerate(stops):
            view = self.capture(pose, _FIRST_STOP[c.motion] + i)
            dataset.add_view(
                view.T_reported[:3, :3], view.T_reported[:3, 3], image=view.image, laser_image=view.laser_image
            )
            self._recorded.append(view.T_true)
            if progress is not None:
                progress(i + 1, len(stops))
        return dataset

    @cached_property
    def weld_seam(self) -> Array | None:
        """Ends (2, 3) of the root of the weld joint, m, base frame; None without one."""
        root = weld_root(self.scene.patches)
        return None if root is None else root @ self._T_bench2base[:3, :3].T + self._T_bench2base[:3, 3]

    @property
    def truth(self) -> Truth:
        """The true parameters, with the true poses of the last recording."""
        return Truth(
            seed=self.config.seed,
            camera_matrix=self.camera.K,
            distortion_coefficients=self.camera.D,
            R_cam2gripper=self._T_cam2gripper[:3, :3],
            t_cam2gripper=self._T_cam2gripper[:3, 3],
            light_plane=self.laser.plane,
            views=tuple(TrueView(R_gripper2base=T[:3, :3], t_gripper2base=T[:3, 3]) for T in self._recorded),
        )

    def correspond(self, view_a: SimulatedView, view_b: SimulatedView, points: Array) -> Array:
        """Return the pixels (N, 2) of view b that show what view a shows at pixels `points` (N, 2).

        Exact (no image noise); NaN where view b sees something else, or nothing, there.
        """
        return exact.correspond(
            self.scene,
            self.camera,
            self._T_cam2bench(view_a.T_true),
            self._T_cam2bench(view_b.T_true),
            np.asarray(points, dtype=np.float64),
        )

    def stripe(self, view: SimulatedView) -> StripeTruth:
        """Return where the centre of the stripe crosses each image column, on which surface, exactly."""
        return exact.stripe(self.scene, self.camera, self.laser, self._T_cam2bench(view.T_true))

    def crossings(self, T_gripper2base: Array) -> tuple[Array, Array]:
        """Return where the light crosses the centre lines of the marks' strokes with the flange at a true pose (4, 4).

        Points (M, 3) in the base frame, m, and their pixels (M, 2); exact, whether in the image and lit or not.
        """
        T_cam2bench = self._T_cam2bench(T_gripper2base)
        points = marks.crossings(self.laser, T_cam2bench, self.marks)
        pixels = self.camera.project((points - T_cam2bench[:3, 3]) @ T_cam2bench[:3, :3])
        return self.in_base(points), pixels

    def in_base(self, points: Array) -> Array:
        """Return points (..., 3) of the scene's frame in the base frame, m."""
        return np.asarray(points @ self._T_bench2base[:3, :3].T + self._T_bench2base[:3, 3])

    def _T_cam2bench(self, T_gripper2base: Array) -> Array:
        return np.asarray(np.linalg.inv(self._T_bench2base) @ T_gripper2base @ self._T_cam2gripper)


def _pose(rotation: Rotation, t: Array) -> Array:
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = rotation.as_matrix(), t
    return out


def _camera(config: CellConfig, rng: np.random.Generator) -> Camera:
    scale = np.array([config.width / 640, config.height / 480])
    jitter = rng.uniform(-1, 1, 4)
    fx = config.focal_px * (1 + 0.002 * jitter[0])
    fy = fx * (1.00092 + 0.0002 * jitter[1])
    middle = config.principal_point_px
    cx, cy = middle if middle is not None else np.array([316.8, 243.3]) * scale + 2 * jitter[2:]
    K = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]], dtype=np.float64)
    return Camera(config.width, config.height, K, np.array(config.distortion, dtype=np.float64))


def _mounting(rng: np.random.Generator) -> Array:
    turn = Rotation.from_rotvec(np.radians(nominal.MOUNTING_DEG + rng.uniform(-1, 1, 3)))
    return _pose(turn, nominal.MOUNTING + rng.uniform(-0.003, 0.003, 3))


def _bump(config: CellConfig) -> Array:
    """Camera to where the camera was, seen from where it was."""
    direction, axis = np.random.default_rng([config.seed, _BUMP]).standard_normal((2, 3))
    turn = Rotation.from_rotvec(np.radians(config.bump_deg) * axis / np.linalg.norm(axis))
    return _pose(turn, config.bump_mm / 1000 * direction / np.linalg.norm(direction))


def _laser(config: CellConfig, rng: np.random.Generator) -> Laser:
    origin = nominal.LASER_ORIGIN + rng.uniform(-0.002, 0.002, 3)
    crossing = np.array([0.0, 0.0, motion.STAND_OFF + rng.uniform(-0.01, 0.01)])
    slant = nominal.LASER_SLANT
    along = np.array([np.cos(slant), np.sin(slant + 0.005 * rng.uniform(-1, 1)), 0.015])
    plane = nominal.light_plane_through(origin, crossing, along)
    return Laser(
        plane[:3],
        float(plane[3]),
        origin,
        config.laser_sigma_mm / 1000,
        config.laser_power if config.laser else 0.0,
        motion.STAND_OFF,
    )


def _bench_pose(config: CellConfig, rng: np.random.Generator) -> Array:
    """The bench's y axis points to the robot, so that the robot's arm reaches over it from above the image."""
    turn = Rotation.from_rotvec(np.radians(rng.uniform(-0.5, 0.5, 3))) * Rotation.from_euler("z", 90, degrees=True)
    return _pose(turn, np.array(_BENCH[config.robot]) + rng.uniform(-0.003, 0.003, 3))


def _things(config: CellConfig) -> tuple[list[Patch], list[Mark], np.random.Generator]:
    """Patches and marks of the scene, and the source of its textures."""
    rng = np.random.default_rng([config.seed, _SCENE])
    patches, placed = desk(rng) if config.scene == "experiment" else (workbench(rng), [])
    return patches, placed, rng
