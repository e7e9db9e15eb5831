# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The default workbench: a welding jig with a V-groove joint, tilted plates, boxes, bolts and a rough casting."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import cv2
import numpy as np

from .parts import Array, Patch, Relief, bolt, box, extrusion, height_field, plate, polygon_patch, pose

BENCH_SIZE = (0.60, 0.54)
"""Extent of the bench plate along x and y, metres."""


def workbench(rng: np.random.Generator) -> list[Patch]:
    """Return all patches of the bench, planar ones numbered by surface_id; `rng` shifts every part a little."""
    x, y = BENCH_SIZE
    corners = np.array([[-x, -y, 0], [x, -y, 0], [x, y, 0], [-x, y, 0]]) / 2
    parts = [polygon_patch("bench", "bench", corners)]
    parts += _weld_joint(near(0.016, -0.008, 0.016, (0, 0, 2), rng))
    parts += plate("plate left", "rust", (0.075, 0.175, 0.006), near(-0.092, 0.006, 0.034, (4, 21, -5), rng))
    parts += plate("plate right", "paint", (0.080, 0.150, 0.006), near(0.116, -0.022, 0.030, (-5, -17, 4), rng))
    parts += plate("ramp", "stone", (0.110, 0.080, 0.006), near(-0.005, 0.146, 0.032, (19, 3, 10), rng))
    parts += box("box tall", "card", (0.046, 0.040, 0.058), near(0.128, 0.104, 0.0, (0, 0, 24), rng))
    parts += box("box flat", "card", (0.070, 0.052, 0.022), near(-0.118, 0.142, 0.0, (0, 0, -13), rng))
    parts += box("box small", "steel", (0.034, 0.048, 0.036), near(0.064, 0.090, 0.0, (0, 0, -38), rng))
    parts += box("block", "stone", (0.064, 0.046, 0.030), near(-0.030, -0.152, 0.0, (0, 0, 17), rng))
    for x, y, turn in ((-0.055, 0.108, 12), (0.052, -0.150, 80), (-0.150, -0.118, -20), (0.165, 0.040, -75)):
        parts += box("label", "label", (0.042, 0.024, 0.0003), near(x, y, 0.0, (0, 0, turn), rng))
    parts += bolts(rng)
    parts += casting(near(0.100, -0.148, 0.004, (0, 0, 8), rng), rng)
    return numbered(parts)


def near(x: float, y: float, z: float, euler_deg: tuple[float, float, float], rng: np.random.Generator) -> Array:
    """The pose at about (x, y), turned by about these angles; what is not turned stays upright."""
    shift = rng.uniform(-0.003, 0.003, 2)
    turn = np.array(euler_deg) + rng.uniform(-1.5, 1.5, 3) * [abs(a) > 0 for a in euler_deg]
    return pose(x + shift[0], y + shift[1], z, turn.tolist())


def _weld_joint(where: Array) -> list[Patch]:
    """Two 12 mm plates, 170 mm long, bevelled to a V-groove of 60 degrees with a root gap of 1.5 mm."""
    width, thick, gap, land = 0.042, 0.012, 0.00075, 0.001
    bevel = gap + (thick - land) * np.tan(np.radians(30))
    right = np.array([[gap, 0], [width, 0], [width, thick], [bevel, thick], [gap, land]])
    left = right[::-1] * [-1.0, 1.0]
    strip = box("backing", "steel", (0.024, 0.160, 0.004), where @ pose(0, 0, -0.004))
    feet = [f for s in (-1, 1) for f in box("foot", "paint", (0.07, 0.014, 0.012), where @ pose(0, s * 0.06, -0.016))]
    return (
        extrusion("weld left", "steel", left, 0.170, where)
        + extrusion("weld right", "steel", right, 0.170, where)
        + strip
        + feet
    )


def weld_root(patches: Sequence[Patch]) -> Array | None:
    """Return the ends (2, 3) of the line in which the two bevels of the weld joint would meet; None without a joint."""
    bevels = [_bevel([p for p in patches if p.name.startswith(f"weld {side}/")]) for side in ("left", "right")]
    if bevels[0] is None or bevels[1] is None:
        return None
    normals = np.array([bevel.normal for bevel in bevels if bevel is not None])
    offsets = [bevel.normal @ bevel.origin for bevel in bevels if bevel is not None]
    direction = np.cross(*normals) / np.linalg.norm(np.cross(*normals))
    point = np.linalg.lstsq(normals, np.array(offsets), rcond=None)[0]
    along = (bevels[0].vertices - point) @ direction
    return np.asarray(point + np.outer([along.min(), along.max()], direction))


def _bevel(faces: Sequence[Patch]) -> Patch | None:
    """The one face that is neither level nor upright."""
    oblique = [face for face in faces if 0.3 < face.normal[2] < 0.8]
    return oblique[0] if oblique else None


def bolts(rng: np.random.Generator) -> list[Patch]:
    """Bolts with washers, between the other parts."""
    spots = [(0.058, -0.118), (-0.066, -0.118), (0.060, 0.122), (-0.062, 0.126), (-0.165, -0.085), (0.178, 0.080)]
    out: list[Patch] = []
    for x, y in spots:
        where = near(x, y, 0.0, (0, 0, float(rng.uniform(1, 60))), rng)
        out += bolt("washer", "steel", 0.011, 0.002, 16, where)
        out += bolt("bolt", "steel", 0.0075, 0.008, 6, where @ pose(0, 0, 0.002))
    return out


def casting(where: Array, rng: np.random.Generator) -> list[Patch]:
    """A rough casting of 100 x 76 mm with hills of some millimetres."""
    step, size = 0.002, (0.100, 0.076)
    rows, columns = round(size[1] / step) + 1, round(size[0] / step) + 1
    height = np.zeros((rows, columns))
    for wavelength, amplitude in ((0.05, 0.0035), (0.025, 0.0016), (0.012, 0.0006)):
        cells = (int(size[1] / wavelength) + 4, int(size[0] / wavelength) + 4)
        height += amplitude * cv2.resize(rng.standard_normal(cells), (columns, rows), interpolation=cv2.INTER_CUBIC)
    edge_v = np.minimum(np.arange(rows), np.arange(rows)[::-1])[:, None]
    edge_u = np.minimum(np.arange(columns), np.arange(columns)[::-1])[None, :]
    height = (np.abs(height) + 0.006) * np.clip(np.minimum(edge_v, edge_u) / 3, 0, 1)
    return [height_field("casting", "stone", size, Relief(height, step), where @ pose(0, 0, -0.003))]


def numbered(patches: list[Patch]) -> list[Patch]:
    """The patches, planar ones with their numbers."""
    planar = iter(range(len(patches)))
    return [p if p.relief is not None else dataclasses.replace(p, surface_id=next(planar)) for p in patches]
