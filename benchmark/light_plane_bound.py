# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The Cramér-Rao bound of the light plane alone: camera, poses and R_cam2gripper known, t_cam2gripper not.

Then a surface of two groups of equal orientation counts as two. Derivatives are complex steps of the stripe's rows; no
code is shared with C++.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .fisher import STEP, plane_tangent
from .scene import Array
from .world import World


def light_plane_bound(world: World, stops: Sequence[int], sigma: float) -> Array:
    """Covariance (4, 4) of nx, ny, nz, d for stripe rows with independent errors of `sigma` px.

    `stops`: views of each group, in their order.
    """
    assert world.stripes is not None
    light, surfaces = world.stripes.light_plane, world.stripes.surfaces
    ways = plane_tangent(light)
    information, first = np.zeros((3, 3)), 0
    for count in stops:
        views = slice(first, first + count)
        first += count
        poses = world.R_gripper2base[views], world.t_gripper2base[views]
        for surface, columns in zip(surfaces, world.stripes.columns, strict=True):
            alone = type(world.stripes)(light, surface[None], columns[None])
            moved = [(light + 1j * STEP * way, surface) for way in ways.T]
            moved += [(light, surface + 1j * STEP * way) for way in plane_tangent(surface).T]
            rows = [alone.rows(world, world.parameters(), plane, s[None], *poses) for plane, s in moved]
            J = np.stack([row.imag.ravel() / STEP for row in rows], axis=1)
            N = J.T @ J / sigma**2
            information += N[:3, :3] - N[:3, 3:] @ np.linalg.solve(N[3:, 3:], N[3:, :3])
    return np.asarray(ways @ np.linalg.inv(information) @ ways.T)
