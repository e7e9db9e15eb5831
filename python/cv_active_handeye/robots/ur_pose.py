# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Poses as a UR controller writes them: x, y, z in metres and a rotation vector (axis times angle, rad)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from .base import Array


def pose_matrix(vector: Sequence[float] | Array) -> Array:
    """The matrix (4, 4) of a pose vector (6,); ValueError where it is no finite pose.

    A rotation vector of any length is right: v and v (1 - 2 pi / |v|) are the same turn, and near |v| = pi a
    controller may write either.
    """
    v = np.asarray(vector, dtype=np.float64)
    if v.shape != (6,) or not np.isfinite(v).all():
        raise ValueError(f"pose vector: needs six finite numbers, given {list(np.ravel(v))}")
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = Rotation.from_rotvec(v[3:]).as_matrix(), v[:3]
    return T


def pose_vector(T: Array) -> list[float]:
    """The pose vector, six numbers, of a matrix (4, 4); the angle is at most pi."""
    rotation = Rotation.from_matrix(T[:3, :3]).as_rotvec()
    return [float(x) for x in (*T[:3, 3], *rotation)]
