# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Pictures as PNG files: tracks over an image, the motion in 3-D, the stripe over an image, errors of new views."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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
POINT_COLOUR = "#ffe14d"
STAR_CELLS = (6, 4)


def picture_tracks(
    path: str | Path, image: NDArray[Any], image_points: FloatArray, view: int, group: Sequence[int]
) -> None:
    """Points found in `view`; some of them as stars whose rays end where the other views of `group` see the same point.

    `image_points` (V, N, 2) px with NaN = not seen; `group` holds views of equal orientation, so that rays of one
    colour point to one focus of expansion.
    """
    figure = Figure(figsize=(9.0, 9.0 * image.shape[0] / image.shape[1] + 1.0), layout="constrained")
    axes = _show_image(figure.add_subplot(), image)
    here, seen = image_points[view], np.asarray(np.isfinite(image_points).all(axis=2), np.bool_)
    axes.plot(*here[seen[view]].T, ".", color=POINT_COLOUR, markersize=2.5, markeredgewidth=0)
    label = f"all {seen[view].sum()} points of view {view}"
    handles = [Line2D([], [], color=POINT_COLOUR, marker="o", markersize=5, linestyle="none", label=label)]
    stars = _spread_out(here, seen[list(group)].sum(axis=0) * seen[view], image.shape[1], image.shape[0])
    for rank, other in enumerate(number for number in group if number != view):
        colour = GROUP_COLOURS[rank % len(GROUP_COLOURS)]
        chosen = [j for j in stars if seen[other, j]]
        rays = np.stack([here[chosen], image_points[other, chosen]], axis=1)
        axes.add_collection(LineCollection(list(rays), colors=colour, linewidths=1.6))
        axes.plot(*rays[:, 1].T, "o", color=colour, markersize=4)
        count = int((seen[view] & seen[other]).sum())
        handles.append(Line2D([], [], color=colour, linewidth=2.5, label=f"to view {other} ({count} in common)"))
    axes.plot(*here[stars].T, "o", markerfacecolor=POINT_COLOUR, markeredgecolor="black", markersize=5)
    axes.set_title(f"Tracks of view {view} into the views of equal orientation", loc="left")
    figure.legend(handles=handles, loc="outside lower center", ncols=3, frameon=False)
    save_figure(figure, path)


def picture_stripe(
    path: str | Path, image: NDArray[Any], segments: Sequence[tuple[FloatArray, int]], view: int
) -> None:
    """Stripe segments ((M, 2) px, surface number or -1 = not sure) over the laser-on `image` of `view`, and zoomed."""
    vertical = np.ptp(np.vstack([points for points, _ in segments]), axis=0).argmax() == 1
    figure = Figure(figsize=(9.0, 9.0 * image.shape[0] / image.shape[1] + 3.0), layout="constrained")
    whole, detail = figure.subplots(2, 1, height_ratios=(3, 1))
    _show_image(whole, image)
    detail.imshow(_for_display(image.swapaxes(0, 1) if vertical else image), cmap="gray", aspect="auto")
    handles: dict[int, Line2D] = {}
    for points, surface in segments:
        colour = UNSURE_COLOUR if surface < 0 else GROUP_COLOURS[surface % len(GROUP_COLOURS)]
        label = "surface not sure" if surface < 0 else f"surface {surface}"
        whole.plot(*points.T, color=colour, linewidth=3)
        detail.plot(*(points[:, ::-1] if vertical else points).T, ".", color=colour, markersize=3, markeredgewidth=0)
        handles[surface] = Line2D([], [], color=colour, linewidth=4, label=label)
    across = np.concatenate([points[:, 0 if vertical else 1] for points, _ in segments])
    detail.set_ylim(across.max() + 12, across.min() - 12)
    detail.set(xlabel="v [px]" if vertical else "u [px]", ylabel="u [px]" if vertical else "v [px]")
    detail.set_title("enlarged across the stripe", loc="left", fontsize="medium")
    whole.set_title(f"Laser stripe of view {view}: {len(segments)} straight segments and their surfaces", loc="left")
    ordered = [handles[key] for key in sorted(handles, key=lambda key: (key < 0, key))]
    figure.legend(handles=ordered, loc="outside lower center", ncols=5, frameon=False)
    save_figure(figure, path)


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
        stops = f"{len(views)} stops, pure translations" if len(views) > 1 else "1 stop"
        text = f"orientation {rank + 1}: {stops}"
        handles.append(Line2D([], [], color=colour, linewidth=3, label=text))
    axes.set_xlabel("base x [mm]", labelpad=10)
    axes.set_ylabel("base y [mm]", labelpad=10)
    axes.set_zlabel("base z [mm]", labelpad=10)
    axes.set_aspect("equal")
    box = [float(np.ptp(limits)) for limits in (axes.get_xlim(), axes.get_ylim(), axes.get_zlim())]
    axes.set_box_aspect(box, zoom=1.12)
    axes.locator_params(nbins=6)
    axes.view_init(elev=22, azim=-58)
    figure.suptitle("Motion: flange axes (red x, green y, blue z) and what the camera looks at")
    figure.legend(handles=handles, loc="outside lower center", ncols=2, frameon=False)
    save_figure(figure, path)


def picture_view_errors(
    path: str | Path, errors: FloatArray, expected: FloatArray, contradicting: Sequence[int]
) -> None:
    """RMS errors (V,) of predicted views in pixels as bars beside what is expected (V,); NaN = not predicted."""
    figure = Figure(figsize=(9.0, 4.0), layout="constrained")
    axes = figure.add_subplot()
    views = np.arange(len(errors))
    colours = [GROUP_COLOURS[1] if view in contradicting else GROUP_COLOURS[0] for view in views]
    axes.bar(views, np.nan_to_num(errors), 0.6, color=colours)
    axes.hlines(expected, views - 0.4, views + 0.4, color="black", linewidth=2)
    axes.set(xlabel="view", ylabel="RMS error [px]", xticks=views)
    axes.set_title("New views predicted from each other", loc="left")
    handles = [
        Line2D([], [], color=GROUP_COLOURS[0], linewidth=8, label="error"),
        Line2D([], [], color=GROUP_COLOURS[1], linewidth=8, label="far more than expected"),
        Line2D([], [], color="black", linewidth=2, label="expected from image, robot and calibration"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3, frameon=False)
    save_figure(figure, path)


def picture_points(path: str | Path, views: Sequence[tuple[NDArray[Any], Mapping[str, tuple[float, float]]]]) -> None:
    """Named points (u, v) px, each over the image of its view: (image, points by name), two views side by side."""
    height, width = views[0][0].shape[:2]
    rows = -(-len(views) // 2)
    figure = Figure(figsize=(10.0, 5.0 * rows * height / width), layout="constrained")
    for axes, (image, points) in zip(figure.subplots(rows, 2, squeeze=False).flat, views, strict=False):
        _show_image(axes, image)
        for name, (u, v) in points.items():
            axes.plot(u, v, "+", color=POINT_COLOUR, markersize=9)
            axes.annotate(name, (u, v), (5, 7), textcoords="offset points", color=POINT_COLOUR, fontsize=9)
        axes.set(xlabel="", ylabel="", title=", ".join(points))
    for axes in figure.axes[len(views) :]:
        axes.set_axis_off()
    save_figure(figure, path)


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


def _spread_out(points: FloatArray, views: IntArray, width: int, height: int) -> list[int]:
    """In every cell of a grid over the image the track that is seen most often (`views` counts; 1 = here only)."""
    best: dict[tuple[int, int], int] = {}
    for j in np.flatnonzero(views > 1):
        cell = (int(points[j, 0] / width * STAR_CELLS[0]), int(points[j, 1] / height * STAR_CELLS[1]))
        if cell not in best or views[j] > views[best[cell]]:
            best[cell] = int(j)
    return list(best.values())


def _for_display(image: NDArray[Any]) -> NDArray[Any]:
    colour = image[:, :, ::-1] if image.ndim == 3 else image
    return np.asarray(colour / max(float(image.max()), 1.0))


def _show_image(axes: Any, image: NDArray[Any]) -> Any:
    axes.imshow(_for_display(image), cmap="gray")
    axes.set(xlim=(-0.5, image.shape[1] - 0.5), ylim=(image.shape[0] - 0.5, -0.5), xlabel="u [px]", ylabel="v [px]")
    return axes


def save_figure(figure: Figure, path: str | Path) -> None:
    """Writes a PNG file, and its folder if need be."""
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=130, facecolor="white")
