# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Exact answers about a simulated cell, for judging trackers and stripe detectors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .laser import Laser
from .optics import Camera
from .parts import Array
from .scene import Scene

_SAME_POINT = 2e-5  # metres


@dataclass(frozen=True)
class StripeTruth:
    """The lit centre line of the stripe where it crosses image columns, sorted by column.

    points (N, 2): (column, row) px, one per column and visible crossing; surface_ids (N,): plane of the scene, -1 on
    curved parts; planes (N, 4): that plane (w, e), w.X = e in the camera frame; points_3d (N, 3): camera frame, m.
    """

    points: Array
    surface_ids: NDArray[np.int64]
    planes: Array
    points_3d: Array


def correspond(scene: Scene, camera: Camera, T_a: Array, T_b: Array, points: Array) -> Array:
    """Return pixels (N, 2) in the camera at T_b of what the camera at T_a (4 x 4, camera to scene) sees at `points`."""
    if points.ndim != 2 or points.shape[1] != 2:
        raise ValueError(f"points: needs shape (N, 2), got {points.shape}")
    out = np.full(points.shape, np.nan)
    known = np.flatnonzero(np.isfinite(points).all(axis=1))
    known = known[camera.inside(points[known])]
    directions = camera.rays(points[known]) @ T_a[:3, :3].T
    hits = scene.cast(T_a[:3, 3], directions)
    known, directions, depth = known[hits.triangle >= 0], directions[hits.triangle >= 0], hits.depth[hits.triangle >= 0]
    point = T_a[:3, 3] + depth[:, None] * directions
    in_b = (point - T_b[:3, 3]) @ T_b[:3, :3]
    front = in_b[:, 2] > 0
    pixels = np.full((len(known), 2), np.nan)
    pixels[front] = camera.project(in_b[front])
    seen = front & camera.inside(pixels) & _sees(scene, T_b[:3, 3], point)
    out[known[seen]] = pixels[seen]
    return out


def _sees(scene: Scene, eye: Array, point: Array) -> NDArray[np.bool_]:
    ray = point - eye
    gap = (1 - scene.cast(eye, ray).depth) * np.linalg.norm(ray, axis=1)
    return np.asarray(np.abs(gap) < _SAME_POINT)


def stripe(scene: Scene, camera: Camera, laser: Laser, T_cam2scene: Array) -> StripeTruth:
    """Return the exact stripe of a camera at T_cam2scene (4 x 4).

    Along every column the distance of the seen surface from the light plane changes sign at the stripe; the crossing
    is then solved on the plane of the triangle and kept if camera and laser both see it there.
    """
    columns, rows = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
    rays = camera.rays(np.stack([columns, rows], axis=-1).reshape(-1, 2).astype(np.float64))
    hits = scene.cast(T_cam2scene[:3, 3], rays @ T_cam2scene[:3, :3].T)
    shape = (camera.height, camera.width)
    distance = (hits.depth * (rays @ laser.n) - laser.d).reshape(shape)
    triangle = hits.triangle.reshape(shape)
    row, column = np.nonzero(distance[:-1] * distance[1:] <= 0)
    found = [
        _crossings(scene, camera, laser, T_cam2scene, triangle[row + side, column], column, row) for side in (0, 1)
    ]
    pixel, tri = (np.concatenate(parts) for parts in zip(*found, strict=True))
    _, first = np.unique(np.column_stack([pixel[:, 0], np.round(pixel[:, 1], 5)]), axis=0, return_index=True)
    return _described(scene, camera, laser, T_cam2scene, pixel[first], tri[first])


def _planes(scene: Scene, T_cam2scene: Array, triangle: NDArray[np.int64]) -> Array:
    """Planes (N, 4) of triangles in the camera frame."""
    normal = scene.normal[triangle]
    offset = scene.offset[triangle] - normal @ T_cam2scene[:3, 3]
    return np.column_stack([normal @ T_cam2scene[:3, :3], offset])


def _crossings(
    scene: Scene,
    camera: Camera,
    laser: Laser,
    T_cam2scene: Array,
    triangle: NDArray[np.int64],
    column: NDArray[np.intp],
    row: NDArray[np.intp],
) -> tuple[Array, NDArray[np.int64]]:
    """Solve for the rows v in [row, row + 1] where the stripe crosses; keep the visible and lit ones."""
    plane = _planes(scene, T_cam2scene, triangle)
    v = _solved_rows(camera, plane[:, 3:] * laser.n - laser.d * plane[:, :3], column, row)
    pixel = np.column_stack([column, v])
    rays = camera.rays(pixel) @ T_cam2scene[:3, :3].T
    hits = scene.cast(T_cam2scene[:3, 3], rays)
    point = T_cam2scene[:3, 3] + hits.depth[:, None] * rays
    keep = (v >= row) & (v <= row + 1) & _coplanar(scene, hits.triangle, triangle)
    keep &= laser.lit(scene, T_cam2scene, point, triangle)
    return pixel[keep], triangle[keep]


def _solved_rows(camera: Camera, line: Array, column: NDArray[np.intp], row: NDArray[np.intp]) -> Array:
    """Rows v with m(u, v) . line = 0 by secant steps (one is exact without distortion), stopped one row outside."""

    def value(v: Array) -> Array:
        return np.asarray(np.einsum("ij,ij->i", camera.rays(np.column_stack([column, v])), line), dtype=np.float64)

    low, high = np.asarray(row, dtype=np.float64), np.asarray(row + 1, dtype=np.float64)
    at_low, at_high = value(low), value(high)
    for _ in range(5):
        slope = np.where(at_high == at_low, 1.0, at_high - at_low)
        v = np.clip(high - at_high * (high - low) / slope, row - 1.0, row + 2.0)
        low, high, at_low, at_high = high, v, at_high, value(v)
    return high


def _coplanar(scene: Scene, a: NDArray[np.int64], b: NDArray[np.int64]) -> NDArray[np.bool_]:
    same_patch = scene.patch_index[a] == scene.patch_index[b]
    return np.asarray((a >= 0) & (b >= 0) & ((a == b) | (same_patch & (scene.surface_id[a] >= 0))))


def _described(
    scene: Scene, camera: Camera, laser: Laser, T_cam2scene: Array, pixel: Array, triangle: NDArray[np.int64]
) -> StripeTruth:
    plane = _planes(scene, T_cam2scene, triangle)
    rays = camera.rays(pixel)
    depth = laser.d / (rays @ laser.n)
    return StripeTruth(pixel, scene.surface_id[triangle], plane, depth[:, None] * rays)
