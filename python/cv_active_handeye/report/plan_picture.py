# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A plan as a picture: where the camera goes, seen from two sides, and what comes of it stop by stop."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..files import FloatArray
from ..plan_file import Plan
from .pictures import GROUP_COLOURS, save_figure

_SINGLE = "#808080"


def picture_plan(
    path: str | Path, plan: Plan, T_cam2gripper: FloatArray, half_view: tuple[float, float], stand_off: float
) -> None:
    """Draws flange, camera and view cone of every stop over the boxes, and predicted sigma against number of stops.

    T_cam2gripper (4, 4), m; half_view: half width and half height of the image at distance 1; stand_off: m. Groups of
    two stops and more have a colour each, the other stops are grey.
    """
    figure = Figure(figsize=(12.0, 5.4), layout="constrained")
    front, side, curve = figure.subplots(1, 3, width_ratios=(1, 1, 0.9))
    cones = [_cone(stop.T_gripper2base @ T_cam2gripper, half_view, stand_off) for stop in plan.stops]
    colours = _colours([stop.group for stop in plan.stops])
    for axes, (across, up) in ((front, (0, 2)), (side, (1, 2))):
        _draw_boxes(axes, plan, across, up)
        _draw_stops(axes, plan, cones, colours, (across, up))
        axes.set(xlabel=f"base {'xyz'[across]} [mm]", ylabel="base z [mm]", aspect="equal")
    front.set_title("Seen along base y", loc="left")
    side.set_title("Seen along base x", loc="left")
    _draw_predictions(curve, plan)
    handles = [
        Line2D([], [], color="black", linewidth=1.2, label="way of the flange"),
        Line2D([], [], color=GROUP_COLOURS[0], linewidth=3, label="cameras and views, a colour for every group"),
        Line2D([], [], color=_SINGLE, linewidth=3, label="single stops"),
        Line2D([], [], color="#d62728", linewidth=1.5, linestyle=":", label="no-go boxes"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=4, frameon=False)
    save_figure(figure, path)


def _cone(T_cam2base: FloatArray, half_view: tuple[float, float], stand_off: float) -> FloatArray:
    """Camera centre and the corners of what it sees at the stand-off (5, 3), mm, base frame."""
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half_view
    points = stand_off * np.vstack([np.zeros(3), np.column_stack([corners, np.ones(4)])])
    return np.asarray(1000 * (points @ T_cam2base[:3, :3].T + T_cam2base[:3, 3]))


def _colours(groups: list[int]) -> list[str]:
    shared = [group for group in dict.fromkeys(groups) if groups.count(group) > 1]
    return [GROUP_COLOURS[shared.index(group) % len(GROUP_COLOURS)] if group in shared else _SINGLE for group in groups]


def _draw_boxes(axes: Any, plan: Plan, across: int, up: int) -> None:
    for box, style in [(plan.workspace.box, ("0.6", "-")), *((box, ("#d62728", ":")) for box in plan.workspace.no_go)]:
        (left, right), (low, high) = ((box.lower_mm[k], box.upper_mm[k]) for k in (across, up))
        outline = np.array([(left, low), (right, low), (right, high), (left, high), (left, low)])
        axes.plot(*outline.T, color=style[0], linestyle=style[1], linewidth=1.2)


def _draw_stops(axes: Any, plan: Plan, cones: list[FloatArray], colours: list[str], shown: tuple[int, int]) -> None:
    way = 1000 * np.array([plan.start.t_gripper2base, *(stop.t_gripper2base for stop in plan.stops)])
    axes.plot(*way[:, shown].T, ".-", color="black", linewidth=0.8, markersize=3, alpha=0.6)
    for cone, colour in zip(cones, colours, strict=True):
        points = cone[:, shown]
        for k in range(4):
            axes.plot(*points[[0, k + 1]].T, color=colour, linewidth=0.5, alpha=0.5)
        axes.plot(*points[[1, 2, 3, 4, 1]].T, color=colour, linewidth=0.8, alpha=0.6)
        axes.plot(*points[0], "s", color=colour, markersize=4)


def _draw_predictions(axes: Any, plan: Plan) -> None:
    known = [p for p in plan.predictions if p.t_cam2gripper_mm is not None]
    stops = [p.stops for p in known]
    axes.plot(stops, [p.t_cam2gripper_mm for p in known], "o-", color=GROUP_COLOURS[0], markersize=4)
    axes.set(xlabel="stops", ylabel="predicted sigma of t_cam2gripper [mm]", xlim=(0, len(plan.stops) + 1))
    axes.set_ylim(bottom=0)
    axes.grid(True, linewidth=0.3)
    axes.set_title("What comes of it", loc="left")
    if known:
        last = known[-1]
        text = f"{last.stops} stops: {last.t_cam2gripper_mm:.2g} mm"
        axes.text(0.96, 0.94, text, transform=axes.transAxes, ha="right", va="top")
