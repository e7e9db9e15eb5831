# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Starts for refineHandEye."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from .scene import HEIGHT, WIDTH, Array
from .world import World

Start = tuple[Array | None, Array | None, Array | None, Array | None, Array | None]
"""K, distortion, R, t, light plane; None = the function finds it."""
NO_START: Start = (None, None, None, None, None)


def rough_start(rng: np.random.Generator, world: World) -> Start:
    """What somebody measures by hand and reads in a data sheet: f wrong by 3 %, 2 degrees and 20 mm off."""
    f = world.camera_matrix[0, 0] * rng.choice([0.97, 1.03])
    K = np.array([[f, 0, WIDTH / 2], [0, f, HEIGHT / 2], [0, 0, 1]])
    axis, way = (v / np.linalg.norm(v) for v in rng.normal(size=(2, 3)))
    R = Rotation.from_rotvec(np.radians(2) * axis).as_matrix() @ world.R_cam2gripper
    return K, None, R, world.t_cam2gripper + 0.02 * way, None
