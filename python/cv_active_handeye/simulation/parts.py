# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Parts of the scene: textured patches, convex extrusions and a height field."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Relief:
    """Heights over a patch: `height[i, j]` (m) above the texture plane at v = i * step, u = j * step."""

    height: Array
    step: float

    def __call__(self, u: Array, v: Array) -> tuple[Array, Array]:
        """Return height (m) and slope (..., 2) at (u, v) in metres; smooth, for shading."""
        where = np.stack([v, u]) / self.step
        dv, du = np.gradient(self.height, self.step)
        grids: list[Array] = [self.height, np.asarray(du), np.asarray(dv)]
        sample = [map_coordinates(grid, where, order=1, mode="nearest") for grid in grids]
        return sample[0], np.stack(sample[1:], axis=-1)


@dataclass(frozen=True)
class Lettering:
    """Print on a plane: ends (N, 2, 3) of the centre lines of straight strokes, and their widths (N,), metres."""

    ends: Array
    widths: Array


@dataclass(frozen=True)
class Patch:
    """Triangles that share one plane of texture: (u, v) = axes @ (X - origin), both in metres.

    vertices (N, 3), faces (M, 3), outward normal by the right-hand rule; size = extent (u, v) in metres;
    surface_id = number of the plane for `planar` patches, -1 otherwise; lettering = what is printed on it.
    """

    name: str
    style: str
    vertices: Array
    faces: NDArray[np.int64]
    origin: Array
    axes: Array
    size: tuple[float, float]
    surface_id: int = -1
    relief: Relief | None = None
    lettering: Lettering | None = None

    @property
    def normal(self) -> Array:
        """Unit normal of the texture plane."""
        return np.cross(self.axes[0], self.axes[1])

    def points(self, u: Array, v: Array) -> tuple[Array, Array]:
        """Return points (..., 3) on the patch over (u, v) and unit normals there."""
        on_plane = self.origin + u[..., None] * self.axes[0] + v[..., None] * self.axes[1]
        if self.relief is None:
            return on_plane, np.broadcast_to(self.normal, on_plane.shape)
        height, slope = self.relief(u, v)
        normal = self.normal - slope[..., :1] * self.axes[0] - slope[..., 1:] * self.axes[1]
        return on_plane + height[..., None] * self.normal, normal / np.linalg.norm(normal, axis=-1, keepdims=True)


def pose(x: float, y: float, z: float, euler_deg: Sequence[float] = (0.0, 0.0, 0.0)) -> Array:
    """Return the 4 x 4 pose at (x, y, z) in metres, turned by fixed-axis angles about x, y, z in degrees."""
    out = np.eye(4)
    out[:3, :3] = Rotation.from_euler("xyz", euler_deg, degrees=True).as_matrix()
    out[:3, 3] = x, y, z
    return out


def polygon_patch(name: str, style: str, corners: Array) -> Patch:
    """Return a convex planar polygon; corners (N, 3) counter-clockwise seen from outside, first edge = u axis."""
    u = corners[1] - corners[0]
    u = u / np.linalg.norm(u)
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    v = np.cross(normal / np.linalg.norm(normal), u)
    axes = np.stack([u, v])
    uv = (corners - corners[0]) @ axes.T
    low = uv.min(axis=0)
    size = uv.max(axis=0) - low
    fan = np.array([[0, i, i + 1] for i in range(1, len(corners) - 1)])
    origin = corners[0] + low @ axes
    return Patch(name, style, corners, fan, origin, axes, (float(size[0]), float(size[1])))


def extrusion(name: str, style: str, profile: Array, length: float, where: Array) -> list[Patch]:
    """Return the faces of a convex profile (N, 2) in the x-z plane, counter-clockwise, extruded by `length` along y.

    The part is centred on y = 0 and then moved by `where` (4 x 4).
    """
    front = np.stack([profile[:, 0], np.full(len(profile), -length / 2), profile[:, 1]], axis=1)
    back = front + np.array([0.0, length, 0.0])
    rings = [front] + [
        np.stack([front[i], back[i], back[j], front[j]])
        for i, j in ((k, (k + 1) % len(profile)) for k in range(len(profile)))
    ]
    rings.append(back[::-1])
    moved = [ring @ where[:3, :3].T + where[:3, 3] for ring in rings]
    return [polygon_patch(f"{name}/{i}", style, ring) for i, ring in enumerate(moved)]


def box(name: str, style: str, size: Sequence[float], where: Array) -> list[Patch]:
    """Return a box of `size` (x, y, z) in metres standing on the origin of `where`."""
    x, y, z = size
    profile = np.array([[-x / 2, 0.0], [x / 2, 0.0], [x / 2, z], [-x / 2, z]])
    return extrusion(name, style, profile, y, where)


def plate(name: str, style: str, size: Sequence[float], where: Array) -> list[Patch]:
    """Return a box whose top face has the centre of `where` in its middle."""
    return box(name, style, size, where @ pose(0, 0, -size[2]))


def bolt(name: str, style: str, radius: float, height: float, corners: int, where: Array) -> list[Patch]:
    """Return an upright prism of `corners` sides, standing on the origin of `where`."""
    angle = 2 * np.pi * np.arange(corners) / corners
    profile = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    upright = pose(0, 0, height / 2, (90, 0, 0))
    return extrusion(name, style, profile, height, where @ upright)


def height_field(name: str, style: str, size: tuple[float, float], relief: Relief, where: Array) -> Patch:
    """Return a height field over a rectangle `size` (m) centred on `where`."""
    rows, columns = relief.height.shape
    v, u = np.meshgrid(np.linspace(0, size[1], rows), np.linspace(0, size[0], columns), indexing="ij")
    local = np.stack([u - size[0] / 2, v - size[1] / 2, relief.height], axis=-1).reshape(-1, 3)
    index = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    faces = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    origin = where[:3, 3] - where[:3, :2] @ np.array(size) / 2
    vertices = local @ where[:3, :3].T + where[:3, 3]
    return Patch(name, style, vertices, faces, origin, where[:3, :2].T.copy(), size, relief=relief)
