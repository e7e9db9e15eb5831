# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""From a camera pose to images with the laser off and on."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from .config import CellConfig
from .laser import Laser
from .optics import Camera, Sensor, subpixel_grid, through_lens
from .parts import Array
from .scene import Scene

Image = NDArray[np.uint8] | NDArray[np.uint16]

_NOTHING = 0.02  # radiance beyond the bench


class Renderer:
    """Casts the rays of a stop once and shades them twice."""

    def __init__(self, scene: Scene, camera: Camera, laser: Laser, sensor: Sensor, config: CellConfig) -> None:
        """Prepares the rays of all samples in the camera frame."""
        self._scene, self._laser, self._sensor, self._config = scene, laser, sensor, config
        self._per_axis = config.samples_per_axis
        self._shape = (camera.height * self._per_axis, camera.width * self._per_axis)
        self._rays = camera.rays(subpixel_grid(camera, self._per_axis))
        self._across = self._rays @ laser.n

    def take(self, T_cam2scene: Array, rng: np.random.Generator) -> tuple[Image, Image | None]:
        """Return the images with the laser off and on (None without laser) from a camera pose (4, 4)."""
        off, on = self.irradiance(T_cam2scene, rng)
        image = self.expose(off, rng)
        return image, None if on is None else self.expose(on, rng)

    def expose(self, light: NDArray[np.float32], rng: np.random.Generator) -> Image:
        """Return the image of light on the sensor (H, W)."""
        return self._sensor.expose(light, self._config.exposure, rng)

    def irradiance(
        self, T_cam2scene: Array, rng: np.random.Generator
    ) -> tuple[NDArray[np.float32], NDArray[np.float32] | None]:
        """Return the noise-free light on the sensor (H, W), laser off and on; `rng` draws the speckle."""
        R, t = T_cam2scene[:3, :3], T_cam2scene[:3, 3]
        directions = self._rays @ R.T
        hits = self._scene.cast(t, directions)
        hit = hits.triangle >= 0
        radiance = np.full(len(directions), _NOTHING, np.float32)
        point = t + hits.depth[hit, None] * directions[hit]
        radiance[hit] = self._scene.sample(self._scene.radiance, hits.triangle[hit], point)
        off = self._on_sensor(radiance)
        if not self._config.laser:
            return off, None
        near = np.flatnonzero(np.abs(hits.depth * self._across - self._laser.d) < self._laser.reach())
        return off, off + self._stripe(T_cam2scene, directions, hits.triangle, hits.depth, near, rng)

    def _stripe(
        self,
        T_cam2scene: Array,
        directions: Array,
        triangle: NDArray[np.int64],
        depth: Array,
        near: NDArray[np.intp],
        rng: np.random.Generator,
    ) -> NDArray[np.float32]:
        light = np.zeros(len(directions), np.float32)
        point = T_cam2scene[:3, 3] + depth[near, None] * directions[near]
        albedo = self._scene.sample(self._scene.albedo, triangle[near], point)
        light[near] = albedo * self._laser.irradiance(self._scene, T_cam2scene, point, triangle[near])
        if self._config.laser_speckle > 0:
            light *= self._speckle(rng).ravel()
        return self._on_sensor(light)

    def _speckle(self, rng: np.random.Generator) -> NDArray[np.float32]:
        """Grain of one pixel, mean 1, contrast as configured."""
        size = (self._shape[0] // self._per_axis, self._shape[1] // self._per_axis)
        coarse = rng.standard_normal(size, dtype=np.float32)
        grain = cv2.resize(coarse, self._shape[::-1], interpolation=cv2.INTER_CUBIC)
        return np.asarray(np.maximum(0, 1 + self._config.laser_speckle * grain), dtype=np.float32)

    def _on_sensor(self, samples: NDArray[np.float32]) -> NDArray[np.float32]:
        return through_lens(samples.reshape(self._shape), self._per_axis, self._config.blur_px)
