# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Three pictures of a calibration as PNG files: tracks over an image, the motion in 3-D, the stripe over an image."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from ..files import FloatArray

IntArray = NDArray[np.integer[Any]]

GROUP_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7a5195", "#8c564b")
"""Colours that stay apart for colour-blind readers (Okabe and Ito), then two more."""

UNSURE_COLOUR = "#b0b0b0"
LINES_AT_MOST = 250


def picture_tracks(
    path: str | Path, image: NDArray[Any], image_points: FloatArray, view: int, group: Sequence[int]
) -> None:
    """Points found in `view`, and where the same points lie in the other views of `group` (views of equal orientation).

    `image_points` (V, N, 2) px with NaN = not seen.
    """
    figure, axes = _image_axes(image)
    here = image_points[view]
    seen = np.isfinite(here).all(axis=1)
    others = [other for other in group if other != view]
    handles = []
    for rank, other in enumerate(others):
        both = np.flatnonzero(seen & np.isfinite(image_points[other]).all(axis=1))
        chosen = both[:: max(1, len(both) * len(others) // LINES_AT_MOST)]
        colour = GROUP_COLOURS[rank % len(GROUP_COLOURS)]
        lines = np.stack([here[chosen], image_points[other, chosen]], axis=1)
        axes.add_collection(LineCollection(list(lines), colors=colour, linewidths=1.1, alpha=0.9))
        handles.append(Line2D([], [], color=colour, label=f"to view {other}: {len(both)} points"))
    axes.plot(here[seen, 0], here[seen, 1], ".", color="#ffe14d", markersize=2.5, markeredgewidth=0)
    handles.append(Line2D([], [], color="#ffe14d", marker=".", linestyle="none", label=f"all {seen.sum()} points here"))
    axes.set_title(f"Tracks: view {view} and the pure translations from it", loc="left")
    _legend_below(axes, handles)
    _save(figure, path)


def picture_stripe(
    path: str | Path, image: NDArray[Any], segments: Sequence[tuple[FloatArray, int]], view: int
) -> None:
    """Stripe segments ((M, 2) px, surface number or -1 = not sure) over the laser-on `image` of `view`."""
    figure, axes = _image_axes(image)
    handles: dict[int, Line2D] = {}
    for points, surface in segments:
        colour = UNSURE_COLOUR if surface < 0 else GROUP_COLOURS[surface % len(GROUP_COLOURS)]
        label = "surface not sure" if surface < 0 else f"surface {surface}"
        axes.plot(points[:, 0], points[:, 1], ".", color=colour, markersize=2.2, markeredgewidth=0)
        handles[surface] = Line2D([], [], color=colour, linewidth=3, label=label)
    axes.set_title(f"Laser stripe in view {view}: {len(segments)} straight segments", loc="left")
    _legend_below(axes, [handles[key] for key in sorted(handles)])
    _save(figure, path)


def picture_motion(
    path: str | Path,
    R_gripper2base: FloatArray,
    t_gripper2base: FloatArray,
    R_cam2gripper: FloatArray,
    t_cam2gripper: FloatArray,
    group_ids: IntArray,
    field_of_view: tuple[float, float],
) -> None:
    """Flange axes and camera frusta of all stops in the base frame, groups of equal orientation in one colour each.

    `field_of_view`: half width and half height of the image at distance 1 (that is (w / 2 fx, h / 2 fy)).
    """
    figure = Figure(figsize=(9.0, 7.2), layout="constrained")
    axes: Any = figure.add_subplot(projection="3d")
    size = 0.35 * _extent(1000 * t_gripper2base)
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * field_of_view
    frustum = size * np.vstack([np.zeros(3), np.column_stack([corners, np.ones(4)])])
    handles = []
    groups = [np.flatnonzero(group_ids == number) for number in np.unique(group_ids)]
    for rank, views in enumerate(sorted(groups, key=len, reverse=True)):
        colour = GROUP_COLOURS[rank % len(GROUP_COLOURS)]
        for i in views:
            R, t = R_gripper2base[i], 1000 * t_gripper2base[i]
            _draw_flange(axes, R, t, 0.35 * size)
            _draw_frustum(axes, (frustum @ R_cam2gripper.T + 1000 * t_cam2gripper) @ R.T + t, t, colour)
            _draw_line(axes, 1000 * t_gripper2base[views[0]], t, color=colour, linewidth=1.8)
        text = f"{len(views)} stops, pure translations" if len(views) > 1 else "1 stop"
        handles.append(Line2D([], [], color=colour, linewidth=3, label=text))
    axes.set_xlabel("base x [mm]", labelpad=10)
    axes.set_ylabel("base y [mm]", labelpad=10)
    axes.set_zlabel("base z [mm]", labelpad=10)
    axes.set_aspect("equal")
    axes.locator_params(nbins=6)
    axes.view_init(elev=22, azim=-58)
    axes.set_title("Motion: flange axes (red x, green y, blue z) and camera views, one colour an orientation")
    axes.legend(handles=handles, loc="upper left", bbox_to_anchor=(0.0, 0.96), frameon=False)
    _save(figure, path)


def _extent(positions: FloatArray) -> float:
    return float(max(np.ptp(positions, axis=0).max(), 1.0))


def _draw_line(axes: Any, a: FloatArray, b: FloatArray, **style: Any) -> None:
    axes.plot(*np.column_stack([a, b]), **style)


def _draw_flange(axes: Any, R: FloatArray, t: FloatArray, length: float) -> None:
    for k, colour in enumerate(("#d62728", "#2ca02c", "#1f77b4")):
        _draw_line(axes, t, t + length * R[:, k], color=colour, linewidth=1.5)


def _draw_frustum(axes: Any, points: FloatArray, flange: FloatArray, colour: str) -> None:
    _draw_line(axes, flange, points[0], color="0.55", linewidth=0.8, linestyle=":")
    for k in range(4):
        _draw_line(axes, points[0], points[k + 1], color=colour, linewidth=0.7, alpha=0.8)
        _draw_line(axes, points[k + 1], points[1 + (k + 1) % 4], color=colour, linewidth=1.0, alpha=0.8)


def _image_axes(image: NDArray[Any]) -> tuple[Figure, Any]:
    height, width = image.shape[:2]
    figure = Figure(figsize=(9.0, 9.0 * height / width + 0.9), layout="constrained")
    axes: Any = figure.add_subplot()
    shown = image[:, :, ::-1] if image.ndim == 3 else image
    axes.imshow(shown, cmap="gray", interpolation="nearest", vmin=0, vmax=float(max(image.max(), 1)))
    axes.set_xlim(-0.5, width - 0.5)
    axes.set_ylim(height - 0.5, -0.5)
    axes.set_xlabel("u [px]")
    axes.set_ylabel("v [px]")
    return figure, axes


def _legend_below(axes: Any, handles: list[Line2D]) -> None:
    columns = min(max(len(handles), 1), 5)
    axes.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.09), ncols=columns, frameon=False)


def _save(figure: Figure, path: str | Path) -> None:
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=130, facecolor="white")
