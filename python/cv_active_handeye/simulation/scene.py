# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The workbench: geometry, textures and baked light. Frame: bench centre, z up, metres.

All surfaces are matt, so their radiance does not depend on the view: the lamp's light with its shadows is computed
once, when the scene is built, and multiplied into the textures.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import trimesh
from numpy.typing import NDArray

from . import light
from .lettering import print_on
from .light import Lamp
from .parts import Array, Patch
from .texture import STYLES, synthesize, tile


@dataclass(frozen=True)
class Hits:
    """What N rays met. triangle -1 (and NaN elsewhere) = nothing; depth in units of the ray's direction vector."""

    triangle: NDArray[np.int64]
    depth: Array


class Scene:
    """Ray-castable textured triangles.

    patches: the parts; texel_mm: edge of a texel; lamps and ambient: light (irradiance 1 = white paper at radiance 1);
    repeat_mm: 0 for natural texture, else the period of one tile on all surfaces; rng: source of all randomness.
    """

    def __init__(
        self,
        patches: list[Patch],
        texel_mm: float,
        lamps: list[Lamp],
        ambient: float,
        repeat_mm: float,
        rng: np.random.Generator,
    ) -> None:
        """Builds triangles, textures and light; ImportError without embreex."""
        if not trimesh.ray.has_embree:
            raise ImportError("the simulation needs the package embreex: pip install 'cv_active_handeye[sim]'")
        self.patches = patches
        self._build_triangles(patches, texel_mm)
        mesh = trimesh.Trimesh(
            self._corners.reshape(-1, 3), np.arange(3 * len(self._corners)).reshape(-1, 3), process=False
        )
        self._caster = mesh.ray
        self._bake(texel_mm, lamps, ambient, repeat_mm, rng)

    def _build_triangles(self, patches: list[Patch], texel_mm: float) -> None:
        self._corners = np.concatenate([p.vertices[p.faces] for p in patches])
        a, b, c = self._corners.transpose(1, 0, 2)
        normal = np.cross(b - a, c - a)
        self.normal = normal / np.linalg.norm(normal, axis=1, keepdims=True)
        self.offset = np.einsum("ij,ij->i", self.normal, a)
        self.patch_index = np.repeat(np.arange(len(patches)), [len(p.faces) for p in patches])
        self.surface_id = np.array([p.surface_id for p in patches])[self.patch_index]
        texel = texel_mm / 1000
        self._axes = np.stack([p.axes for p in patches]) / texel
        self._origin = np.stack([p.axes @ p.origin for p in patches]) / texel
        self.texture_shape = np.array([[int(p.size[1] / texel) + 3, int(p.size[0] / texel) + 3] for p in patches])
        self.texture_start = np.concatenate([[0], np.cumsum(self.texture_shape.prod(axis=1))])

    def _bake(
        self, texel_mm: float, lamps: list[Lamp], ambient: float, repeat_mm: float, rng: np.random.Generator
    ) -> None:
        tile_seed = int(rng.integers(2**32))
        self.albedo = np.empty(self.texture_start[-1], np.float32)
        self.radiance = np.empty(self.texture_start[-1], np.float32)
        lights = light.bake(self.patches, lamps, ambient, self._caster.intersects_first)
        for i, (patch, irradiance) in enumerate(zip(self.patches, lights, strict=True)):
            shape = (int(self.texture_shape[i, 0]), int(self.texture_shape[i, 1]))
            if repeat_mm > 0:
                albedo = tile(shape, texel_mm, np.random.default_rng(tile_seed), repeat_mm)
            else:
                albedo = synthesize(STYLES[patch.style], shape, texel_mm, rng)[::-1]  # rows go up on the part
            if patch.lettering is not None:
                ends = patch.lettering.ends @ self._axes[i].T - self._origin[i]
                albedo = print_on(albedo, ends, patch.lettering.widths / (texel_mm / 1000))
            span = slice(self.texture_start[i], self.texture_start[i + 1])
            self.albedo[span] = albedo.ravel()
            self.radiance[span] = (albedo * light.stretched(irradiance, shape)).ravel()

    def cast(self, origin: Array, directions: Array) -> Hits:
        """Return the first triangle on each ray from one `origin` (3,) along `directions` (N, 3), seen from outside.

        Embree (float32) chooses the triangle; the depth comes from its plane in float64.
        """
        triangle = self._caster.intersects_first(np.broadcast_to(origin, directions.shape), directions)
        hit = triangle >= 0
        index = triangle[hit]
        depth = np.full(len(directions), np.nan)
        height = self.offset[index] - self.normal[index] @ origin
        depth[hit] = height / np.einsum("ij,ij->i", self.normal[index], directions[hit])
        return Hits(triangle, depth)

    def sample(self, image: NDArray[np.float32], triangle: NDArray[np.int64], point: Array) -> NDArray[np.float32]:
        """Return the texture `image` (`albedo` or `radiance`), bilinear, at points (N, 3) on triangles (N,)."""
        patch = self.patch_index[triangle]
        where = np.einsum("nij,nj->ni", self._axes[patch], point) - self._origin[patch]
        shape = self.texture_shape[patch]
        where = np.clip(where, 0.0, shape[:, ::-1] - 1.001)
        cell = where.astype(np.int64)
        fu, fv = (where - cell).T.astype(np.float32)
        stride = shape[:, 1]
        index = self.texture_start[patch] + cell[:, 1] * stride + cell[:, 0]
        top = image[index] * (1 - fu) + image[index + 1] * fu
        bottom = image[index + stride] * (1 - fu) + image[index + stride + 1] * fu
        return np.asarray(top * (1 - fv) + bottom * fv, dtype=np.float32)
