# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The motion in 3-D: where the camera stood, what it looked at, and the scene points."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..files import FloatArray
from .inputs import IntArray, ReportInput
from .plotting import GROUP_COLOURS, OTHER_COLOUR, Figure, Json, Key, evenly, layout, packed, polylines
from .words import counted, views_listed

MAX_SCENE_POINTS = 3000
FRUSTUM_SHARE = 0.3
"""Depth of a drawn frustum as a share of the largest distance between stops."""


def motion_figure(case: ReportInput) -> Figure:
    """Camera frusta and flanges in the base frame, one colour a group of equal orientation."""
    R = np.einsum("vij,jk->vik", case.dataset.R_gripper2base, case.calibration.R_cam2gripper)
    flange = 1000 * case.dataset.t_gripper2base
    centres = flange + 1000 * case.dataset.R_gripper2base @ case.calibration.t_cam2gripper
    frusta = _frusta(case, R, centres, flange)
    traces, keys = [_scene_points(case)], [Key("--muted", "●", "scene points")]
    for name, views, colour in coloured_groups(case.group_ids):
        traces += _views(views, colour, frusta[views], centres[views])
        keys.append(Key(colour, "●", name))
    rejected = np.array(sorted(case.summary.rejectedViews), dtype=np.int64)
    if len(rejected):
        traces.append(_crosses(rejected, centres[rejected]))
        keys.append(Key("--bad", "✕", "pose not believed"))
    box = np.vstack([frusta.reshape(-1, 3), 1000 * known_scene_points(case)])
    look = layout(scene=_scene(box), margin={"l": 0, "r": 0, "t": 0, "b": 0})
    return Figure("motion", "The motion", _words(case), {"data": traces, "layout": look}, tuple(keys))


def coloured_groups(group_ids: IntArray) -> list[tuple[str, IntArray, str]]:
    """Name, views and colour of each group, largest first; what exceeds the colours shares one entry."""
    numbers = np.unique(group_ids)
    groups = sorted((np.flatnonzero(group_ids == number) for number in numbers), key=len, reverse=True)
    room = len(GROUP_COLOURS) if len(groups) <= len(GROUP_COLOURS) else len(GROUP_COLOURS) - 1
    found: list[tuple[str, IntArray, str]] = [
        (f"orientation {k + 1}: {counted(len(views), 'stop')}", views, GROUP_COLOURS[k])
        for k, views in enumerate(groups[:room])
    ]
    if groups[room:]:
        others = np.sort(np.concatenate(groups[room:]))
        found.append((f"{len(groups) - room} others: {counted(len(others), 'stop')}", others, OTHER_COLOUR))
    return found


def _frusta(case: ReportInput, R: FloatArray, centres: FloatArray, flange: FloatArray) -> FloatArray:
    """(V, 12, 3) mm: one line a view, from the flange to the camera and along all edges of the frustum."""
    width, height = case.image_size
    K = case.calibration.camera_matrix
    size = FRUSTUM_SHARE * max(float(np.ptp(flange, axis=0).max()), 50.0)
    u, v = np.array([[0, 1, 1, 0], [0, 0, 1, 1]]) * [[width], [height]]
    rays = np.stack([(u - K[0, 2]) / K[0, 0], (v - K[1, 2]) / K[1, 1], np.ones(4)], axis=1)
    corners = centres[:, None] + size * rays @ R.swapaxes(1, 2)
    path = np.stack([flange, centres, *corners.swapaxes(0, 1)], axis=1)
    return np.asarray(path[:, [0, 1, 2, 3, 1, 4, 5, 1, 2, 5, 4, 3]], np.float64)


def _views(views: IntArray, colour: str, frusta: FloatArray, centres: FloatArray) -> list[Json]:
    lines = {"mode": "lines", "line": {"color": colour, "width": 2.5}, "hoverinfo": "skip"}
    dots: Json = {"mode": "markers", "marker": {"color": colour, "size": 4}}
    dots |= {"customdata": views.tolist(), "hovertemplate": "view %{customdata}" + _PLACE}
    return [_trace(polylines(frusta), **lines), _trace(centres, **dots)]


_PLACE = "<br>(%{x:.1f}, %{y:.1f}, %{z:.1f}) mm<extra></extra>"


def _crosses(views: IntArray, centres: FloatArray) -> Json:
    marker = {"color": "--bad", "size": 7, "symbol": "x"}
    hover = {"customdata": views.tolist(), "hovertemplate": "view %{customdata}: pose not believed" + _PLACE}
    return _trace(centres, mode="markers", marker=marker, **hover)


def _scene_points(case: ReportInput) -> Json:
    points = known_scene_points(case)
    shown = 1000 * points[evenly(len(points), MAX_SCENE_POINTS)]
    marker = {"color": "--muted", "size": 2 if len(shown) < 500 else 1, "opacity": 0.7}
    return _trace(shown, mode="markers", marker=marker, hovertemplate="scene point" + _PLACE)


def known_scene_points(case: ReportInput) -> FloatArray:
    """(M, 3) m, those that were determined and lie within reach of the others (far points hide the rest)."""
    points = np.asarray(case.summary.scenePoints, np.float64).reshape(-1, 3)
    points = points[np.isfinite(points).all(axis=1)]
    if not len(points):
        return points
    distance = np.linalg.norm(points - np.median(points, axis=0), axis=1)
    near: FloatArray = points[distance <= 5 * max(float(np.median(distance)), 1e-9)]
    return near


def _trace(points: FloatArray, **style: Any) -> Json:
    x, y, z = (packed(coordinate) for coordinate in points.T)
    return {"type": "scatter3d", "x": x, "y": y, "z": z, **style}


def _scene(points: FloatArray) -> Json:
    """Axes around `points` (N, 3) mm with equal scales; the longest side of the box is 1."""
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.03 * float((high - low).max())
    sides = (high - low + 2 * margin) / ((high - low).max() + 2 * margin)
    quiet = {"showbackground": False, "showspikes": False, "nticks": 6, "gridcolor": "--line", "zeroline": False}
    axes: Json = {
        f"{name}axis": {
            **quiet,
            "title": {"text": f"{name} [mm]", "font": {"color": "--muted"}},
            "tickfont": {"color": "--muted", "size": 11},
            "range": [float(low[k]) - margin, float(high[k]) + margin],
        }
        for k, name in enumerate("xyz")
    }
    ratio = dict(zip("xyz", sides.tolist(), strict=True))
    camera = {"eye": {"x": 1.0, "y": -1.15, "z": 0.5}, "center": {"x": 0, "y": 0, "z": -0.08}}
    return {**axes, "aspectmode": "manual", "aspectratio": ratio, "dragmode": "orbit", "camera": camera}


def _words(case: ReportInput) -> str:
    sizes = [int((case.group_ids == number).sum()) for number in np.unique(case.group_ids)]
    several = sum(size > 1 for size in sizes)
    text = f"{counted(len(case.dataset), 'stop')} in {counted(len(sizes), 'orientation')}, {several} of them with pure"
    text += " translations. Each line runs from the flange to the camera, which opens towards what it sees."
    known = known_scene_points(case)
    if len(known) > MAX_SCENE_POINTS:
        text += f" {MAX_SCENE_POINTS} of {len(known)} scene points are drawn."
    if case.summary.rejectedViews:
        text += f" Crosses: poses that were not believed ({views_listed(sorted(case.summary.rejectedViews))})."
    return text
