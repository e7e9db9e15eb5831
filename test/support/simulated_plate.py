# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A bare plate in front of a small camera, for tests of the renderer with known answers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cv_active_handeye.simulation.config import CellConfig
from cv_active_handeye.simulation.laser import Laser
from cv_active_handeye.simulation.light import Lamp
from cv_active_handeye.simulation.optics import Camera, Sensor
from cv_active_handeye.simulation.parts import Patch, plate, pose
from cv_active_handeye.simulation.render import Renderer
from cv_active_handeye.simulation.scene import Scene

Array = NDArray[np.float64]

DISTORTION = (-0.25, 0.3, 0.002, -0.003, 0.1)
TEXEL_MM = 0.4


def small_camera(distortion: tuple[float, ...] = (0, 0, 0, 0, 0)) -> Camera:
    """160 x 120 pixels, f = 353 px: a quarter of the default camera in every direction."""
    K = np.array([[353.3, 0, 79.1], [0, 353.7, 60.7], [0, 0, 1]])
    return Camera(160, 120, K, np.array(distortion, dtype=np.float64))


def level_plate(extra: list[Patch] | None = None, lamps: list[Lamp] | None = None, ambient: float = 0.8) -> Scene:
    """A plate of 300 x 240 mm with its top at z = 0 and uniform albedo 0.5, and other parts."""
    parts = plate("plate", "steel", (0.30, 0.24, 0.01), np.eye(4)) + (extra or [])
    scene = Scene(parts, TEXEL_MM, lamps or [], ambient, 0.0, np.random.default_rng(0))
    paint(scene, np.full_like(scene.albedo, 0.5))
    return scene


def paint(scene: Scene, albedo: NDArray[np.float32]) -> None:
    """Replaces the texture and keeps the light."""
    scene.radiance *= albedo / scene.albedo
    scene.albedo[:] = albedo


def looking_down(tilt_deg: tuple[float, float, float] = (0, 0, 0), distance: float = 0.55) -> Array:
    """Camera pose (4, 4) that looks at the origin of the scene from `distance`, turned in the camera's axes."""
    down = pose(0, 0, 0, (180, 0, 0)) @ pose(0, 0, 0, tilt_deg)
    down[:3, 3] = -distance * down[:3, 2]
    return down


def small_laser(sigma_mm: float = 2.6) -> Laser:
    """A sheet of light from 100 mm above the camera; 2.6 mm is 1.7 px of the small camera."""
    n = np.array([0.03, -0.98, 0.18])
    n /= np.linalg.norm(n)
    origin = np.array([0.0, -0.1, 0.01])
    d = 0.55 * n[2]
    origin[1] = (d - n[2] * origin[2]) / n[1]
    return Laser(n, d, origin, sigma_mm / 1000, 0.9, 0.55)


def renderer(scene: Scene, camera: Camera, sheet: Laser, **settings: object) -> Renderer:
    """A renderer with the given settings of `CellConfig`; no speckle unless told otherwise."""
    config = CellConfig.model_validate({"laser_speckle": 0.0, "texel_mm": TEXEL_MM, **settings})
    sensor = Sensor(config.full_well_electrons, config.read_noise_electrons, config.bit_depth)
    return Renderer(scene, camera, sheet, sensor, config)
