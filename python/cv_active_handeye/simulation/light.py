# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Lamps and the light they bring to the surfaces, shadows included."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from .parts import Array, Patch

_STEP = 0.0015  # grid of the light on a surface, metres; finer than the half-shadows of the lamps
_LIFT = 2e-5  # start of a shadow ray above its surface, metres
_INSET = 1e-4  # outermost grid points lie this far (m) inside the patch

FirstHit = Callable[[Array, Array], NDArray[np.int64]]
"""Origins and directions (N, 3) to triangles (N,), -1 = nothing."""


@dataclass(frozen=True)
class Lamp:
    """A square lamp of `width` metres facing down at `position`; `power` = irradiance straight below at z = 0."""

    position: tuple[float, float, float]
    width: float
    power: float

    def samples(self) -> Array:
        """Return nine points (9, 3) on the lamp."""
        offset = np.array([-1.0, 0.0, 1.0]) * self.width / 2
        x, y = np.meshgrid(offset, offset)
        return np.array(self.position) + np.stack([x.ravel(), y.ravel(), np.zeros(9)], axis=1)


def bake(patches: list[Patch], lamps: list[Lamp], ambient: float, first_hit: FirstHit) -> list[NDArray[np.float32]]:
    """Return the irradiance on each patch as a coarse image (rows along v, columns along u)."""
    grids = [_grid(patch) for patch in patches]
    point = np.concatenate([p.reshape(-1, 3) for p, _ in grids])
    normal = np.concatenate([n.reshape(-1, 3) for _, n in grids])
    light = ambient * (0.6 + 0.4 * normal[:, 2])
    for lamp in lamps:
        samples = lamp.samples()
        for source in samples:
            light += lamp.power / len(samples) * _from_point(source, point, normal, first_hit)
    pieces = np.split(light.astype(np.float32), np.cumsum([p[..., 0].size for p, _ in grids])[:-1])
    return [piece.reshape(p.shape[:2]) for piece, (p, _) in zip(pieces, grids, strict=True)]


def stretched(light: NDArray[np.float32], shape: tuple[int, int]) -> NDArray[np.float32]:
    """Return a coarse light image at the size (rows, columns) of the patch's texture."""
    return np.asarray(cv2.resize(light, shape[::-1], interpolation=cv2.INTER_LINEAR), dtype=np.float32)


def _grid(patch: Patch) -> tuple[Array, Array]:
    """Points and normals (rows, columns, 3) on a patch."""
    u, v = (_steps(length) for length in patch.size)
    v_grid, u_grid = np.meshgrid(v, u, indexing="ij")
    return patch.points(u_grid, v_grid)


def _steps(length: float) -> Array:
    count = max(2, round(length / _STEP))
    return np.clip((np.arange(count) + 0.5) * length / count, _INSET, length - _INSET)


def _from_point(source: Array, point: Array, normal: Array, first_hit: FirstHit) -> Array:
    ray = source - point
    distance = np.sqrt(np.einsum("ij,ij->i", ray, ray))
    cosine = np.einsum("ij,ij->i", ray, normal) / distance
    facing = np.flatnonzero(cosine > 0)
    free = facing[first_hit(point[facing] + _LIFT * normal[facing], ray[facing]) < 0]
    out = np.zeros(len(point))
    out[free] = cosine[free] * (source[2] / distance[free]) ** 2
    return out
