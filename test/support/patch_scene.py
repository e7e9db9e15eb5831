# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A small scene of textured rectangles with exact correspondences, rendered in numpy for fast tests of the tracker.

It shares no code with the simulated cell, so it checks the tracker independently. Lengths are metres, the base frame
has z up and poses are those of the camera (cam2base, 4x4); pixel centres are at integer coordinates as in OpenCV.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Texture = Callable[[int, int], NDArray[np.float32]]
TEXTURE_PIXELS_PER_METRE = 6000.0


def natural_texture(rng: np.random.Generator, height: int, width: int) -> NDArray[np.float32]:
    """Noise of many octaves: structure at every size, nothing repeats."""
    texture = np.zeros((height, width), np.float32)
    for octave in range(3, 10):
        cell = 2**octave
        grid = rng.standard_normal((height // cell + 3, width // cell + 3)).astype(np.float32)
        size = (grid.shape[1] * cell, grid.shape[0] * cell)
        texture += 1.2**octave * cv2.resize(grid, size, interpolation=cv2.INTER_CUBIC)[:height, :width]
    return _to_grey(texture)


def repeated_texture(rng: np.random.Generator, height: int, width: int, period: int = 160) -> NDArray[np.float32]:
    """The same tile everywhere: every feature has identical copies in the same image."""
    tile = natural_texture(rng, period, period)
    return np.tile(tile, (height // period + 1, width // period + 1))[:height, :width]


def _to_grey(texture: NDArray[np.float32]) -> NDArray[np.float32]:
    spread = (texture - texture.mean()) / texture.std()
    return np.asarray(np.clip(120.0 + 45.0 * spread, 5.0, 250.0), np.float32)


@dataclass(frozen=True)
class Rectangle:
    """A textured rectangle: corner + a * side_u + b * side_v with a, b in metres along unit vectors."""

    corner: Array
    side_u: Array
    side_v: Array
    size: tuple[float, float]
    texture: NDArray[np.float32]


@dataclass
class PatchScene:
    """Rectangles seen by one pin-hole camera (640 x 480, f = 1413 px unless told otherwise)."""

    rectangles: list[Rectangle]
    width: int = 640
    height: int = 480
    focal_px: float = 1413.0
    noise: float = 1.5
    blur_px: float = 0.6
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(5))

    @property
    def camera_matrix(self) -> Array:
        centre = ((self.width - 1) / 2, (self.height - 1) / 2)
        return np.array([[self.focal_px, 0, centre[0]], [0, self.focal_px, centre[1]], [0, 0, 1.0]])

    def render(self, cam2base: Array, samples: int = 3, gain: float = 1.0) -> NDArray[np.uint8]:
        """Image of the scene with `samples`^2 rays a pixel, blur, noise and 8-bit rounding."""
        u = (np.arange(self.width * samples) + 0.5) / samples - 0.5
        v = (np.arange(self.height * samples) + 0.5) / samples - 0.5
        pixels = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
        hit, a, b, _ = self._cast(cam2base, pixels)
        fine: NDArray[np.float32] = np.full(len(pixels), 20.0, np.float32)
        for index, rectangle in enumerate(self.rectangles):
            on = hit == index
            at = [np.float32(x[on] * TEXTURE_PIXELS_PER_METRE).reshape(1, -1) for x in (a, b)]
            fine[on] = _bilinear(rectangle.texture, at[0].ravel(), at[1].ravel())
        coarse = fine.reshape(self.height, samples, self.width, samples).mean(axis=(1, 3))
        image = cv2.GaussianBlur(coarse, (0, 0), self.blur_px) * gain
        image = image + self.noise * self.rng.standard_normal(image.shape)
        return np.asarray(np.clip(np.rint(image), 0, 255), np.uint8)

    def correspond(self, cam2base_a: Array, cam2base_b: Array, pixels: Array) -> Array:
        """Exact positions in view b of what is seen at `pixels` (N, 2) of view a; NaN where hidden or outside."""
        hit, _, _, points = self._cast(cam2base_a, pixels)
        local = (points - cam2base_b[:3, 3]) @ cam2base_b[:3, :3]
        projected = local @ self.camera_matrix.T
        there = projected[:, :2] / projected[:, 2:]
        hit_b, _, _, points_b = self._cast(cam2base_b, there)
        inside = (there >= 0).all(axis=1) & (there[:, 0] <= self.width - 1) & (there[:, 1] <= self.height - 1)
        seen = (hit >= 0) & (hit == hit_b) & inside & (np.linalg.norm(points - points_b, axis=1) < 1e-6)
        return np.where(seen[:, None], there, np.nan)

    def _cast(self, cam2base: Array, pixels: Array) -> tuple[NDArray[np.int64], Array, Array, Array]:
        homogeneous = np.column_stack([pixels, np.ones(len(pixels))])
        rays = homogeneous @ np.linalg.inv(self.camera_matrix).T @ cam2base[:3, :3].T
        origin = cam2base[:3, 3]
        best = np.full(len(pixels), np.inf)
        hit = np.full(len(pixels), -1)
        coordinates = np.zeros((2, len(pixels)))
        for index, rectangle in enumerate(self.rectangles):
            normal = np.cross(rectangle.side_u, rectangle.side_v)
            with np.errstate(divide="ignore", invalid="ignore"):
                depth = ((rectangle.corner - origin) @ normal) / (rays @ normal)
                on_plane = origin + depth[:, None] * rays - rectangle.corner
                a, b = on_plane @ rectangle.side_u, on_plane @ rectangle.side_v
            inside = (a >= 0) & (a < rectangle.size[0]) & (b >= 0) & (b < rectangle.size[1])
            nearer = inside & (depth > 0) & (depth < best)
            best[nearer], hit[nearer] = depth[nearer], index
            coordinates[:, nearer] = np.stack([a, b])[:, nearer]
        with np.errstate(invalid="ignore"):
            points = origin + best[:, None] * rays
        return hit, coordinates[0], coordinates[1], points


def _bilinear(texture: NDArray[np.float32], x: NDArray[np.float32], y: NDArray[np.float32]) -> NDArray[np.float32]:
    x0 = np.clip(x.astype(np.int64), 0, texture.shape[1] - 2)
    y0 = np.clip(y.astype(np.int64), 0, texture.shape[0] - 2)
    fx, fy = x - x0, y - y0
    top = texture[y0, x0] * (1 - fx) + texture[y0, x0 + 1] * fx
    bottom = texture[y0 + 1, x0] * (1 - fx) + texture[y0 + 1, x0 + 1] * fx
    return np.asarray(top * (1 - fy) + bottom * fy, np.float32)


def plate(
    centre: Sequence[float], size: tuple[float, float], tilt_deg: tuple[float, float], texture: Texture
) -> Rectangle:
    """A rectangle about `centre`, tilted about x and then about its own y."""
    rotation = _rotation(tilt_deg[0], 0.0, 0.0) @ _rotation(0.0, tilt_deg[1], 0.0)
    corner = np.array(centre) - 0.5 * (size[0] * rotation[:, 0] + size[1] * rotation[:, 1])
    height, width = (int(s * TEXTURE_PIXELS_PER_METRE) + 2 for s in size[::-1])
    return Rectangle(corner, rotation[:, 0], rotation[:, 1], size, texture(height, width))


def workbench(seed: int = 1, repeated: bool = False, table: float = 0.4, **settings: Any) -> PatchScene:
    """A table of `table` metres with two tilted plates and a raised one, centred on the base origin.

    settings: fields of `PatchScene`.
    """
    rng = np.random.default_rng(seed)

    def natural(height: int, width: int) -> NDArray[np.float32]:
        return natural_texture(rng, height, width)

    def tiles(height: int, width: int) -> NDArray[np.float32]:
        return repeated_texture(rng, height, width)

    plates = [
        plate((0.0, 0.0, 0.0), (table, table), (0, 0), tiles if repeated else natural),
        plate((-0.05, 0.03, 0.03), (0.08, 0.06), (15, -10), natural),
        plate((0.06, -0.03, 0.03), (0.07, 0.07), (-10, 20), natural),
        plate((0.03, 0.06, 0.05), (0.08, 0.04), (0, 0), natural),
    ]
    return PatchScene(plates, rng=rng, **settings)


def looking_at(
    target: Sequence[float], stand_off: float, turn_deg: float, tilt_x_deg: float, tilt_y_deg: float
) -> Array:
    """cam2base of a camera looking down at `target`, turned about its optical axis, tilted about its x and y."""
    cam2base = np.eye(4)
    tilt = _rotation(tilt_x_deg, 0.0, 0.0) @ _rotation(0.0, tilt_y_deg, 0.0)
    cam2base[:3, :3] = np.diag([1.0, -1.0, -1.0]) @ tilt @ _rotation(0.0, 0.0, turn_deg)
    cam2base[:3, 3] = np.array(target) - stand_off * cam2base[:3, 2]
    return cam2base


def _rotation(x_deg: float, y_deg: float, z_deg: float) -> Array:
    return np.asarray(cv2.Rodrigues(np.radians([x_deg, y_deg, z_deg]))[0], np.float64)
