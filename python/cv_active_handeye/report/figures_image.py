# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Figures over the image: where points were seen, how far they miss, view by view."""

from __future__ import annotations

import math

import numpy as np

from ..files import FloatArray
from .inputs import ReportInput
from .plotting import Figure, Json, Key, axis, colour_bar, evenly, layout, line, packed, view_axis
from .words import counted, listed, two_digits, views_listed

MAX_ARROWS = 60_000
"""In the whole page; shared evenly by the views."""

MAX_ARROWS_OF_VIEW = 500
ARROW_SHARE = 0.045
"""Length of a typical arrow, as a share of the image's width."""

MIN_POINTS_OF_CELL = 3


def coverage_figure(case: ReportInput) -> Figure:
    """How many image points were used in each square cell of the image, over all views."""
    width, height = case.image_size
    points = case.image_points[case.used]
    cell = cell_size(width, height, len(points))
    columns, rows = math.ceil(width / cell), math.ceil(height / cell)
    counts, _, _ = np.histogram2d(
        points[:, 1], points[:, 0], (rows, columns), ((-0.5, rows * cell - 0.5), (-0.5, columns * cell - 0.5))
    )
    heat = {
        "type": "heatmap",
        "z": packed(np.where(counts > 0, counts, np.nan)),
        "x0": cell / 2 - 0.5,
        "dx": cell,
        "y0": cell / 2 - 0.5,
        "dy": cell,
        "xgap": 1,
        "ygap": 1,
        "zmin": 0,
        "colorscale": [[0, "--heat-low"], [0.5, "--heat-middle"], [1, "--heat-high"]],
        "colorbar": colour_bar(),
        "hovertemplate": "%{z:.0f} points around (%{x:.0f}, %{y:.0f}) px<extra></extra>",
    }
    spec = {"data": [heat], "layout": image_layout(width, height)}
    words = f"Image points in each cell of {cell:.0f} px, over all views. "
    return Figure("coverage", "Where points were seen", words + _coverage_words(points, width, height, counts), spec)


def cell_size(width: int, height: int, points: int) -> float:
    """Side of the square cells, px: about ten points a cell if they lay evenly, 10 to 40 cells across the image."""
    wished = math.sqrt(10 * width * height / max(points, 1))
    return width / float(np.clip(round(width / wished), 10, 40))


def image_layout(width: int, height: int, around: float = 0.0, above: float = 0.0) -> Json:
    """Axes in pixels, y down, equal scales, the image's frame drawn; `around`, `above`: free space, px."""
    x = axis("u [px]", range=[-0.5 - around, width - 0.5 + around], showgrid=False, constrain="domain")
    y = axis("v [px]", range=[height - 0.5 + around, -0.5 - around - above], showgrid=False, scaleanchor="x")
    x, y = {**x, "showline": False}, {**y, "showline": False, "constrain": "domain"}
    corners = {"x0": -0.5, "y0": -0.5, "x1": width - 0.5, "y1": height - 0.5}
    frame = {"type": "rect", **corners, "line": {"color": "--muted", "width": 1}, "layer": "below"}
    return layout(xaxis=x, yaxis=y, shapes=[frame])


def _coverage_words(points: FloatArray, width: int, height: int, counts: FloatArray) -> str:
    if not len(points):
        return "No image point was used."
    centre = np.array([width - 1, height - 1]) / 2
    reach = np.linalg.norm(points - centre, axis=1).max() / np.linalg.norm(centre)
    text = f"Points were used in {100 * (counts > 0).mean():.0f} % of the cells"
    text += f" and out to {100 * reach:.0f} % of the way from the centre to the corners"
    low, high = points.min(axis=0), points.max(axis=0)
    gaps = {"left": low[0], "right": width - 1 - high[0], "upper": low[1], "lower": height - 1 - high[1]}
    empty = [f"{gap:.0f} px at the {side} edge" for side, gap in gaps.items() if gap > 0.1 * width]
    if empty:
        return f"{text}. Nothing was seen within {listed(empty)}: there the lens is extrapolated."
    return f"{text}. Beyond that, the lens is extrapolated." if reach < 0.8 else f"{text}."


def view_rms_figure(case: ReportInput) -> Figure:
    """RMS residual of every view; a click on a bar chooses the view in the figure of arrows."""
    rms, views = case.view_rms, np.arange(len(case.dataset))
    rejected = set(case.summary.rejectedViews)
    bars = {
        "type": "bar",
        "x": views.tolist(),
        "y": packed(rms),
        "marker": {"color": ["--bad" if view in rejected else "--bar" for view in views.tolist()]},
        "unselected": {"marker": {"opacity": 0.4}},
        "customdata": case.used.sum(axis=1).tolist(),
        "hovertemplate": "view %{x}: %{y:.3f} px, %{customdata} points<extra></extra>",
    }
    y = axis("RMS residual [px]", rangemode="tozero")
    look = layout(xaxis=view_axis(len(views)), yaxis=y, bargap=0.45, shapes=[line(case.summary.rms, "--ink", "dot")])
    spec = {"data": [bars], "layout": look}
    keys = (Key("--bar", "■", "view"), Key("--bad", "■", "view whose pose was not believed")) if rejected else ()
    return Figure("view_rms", "Residuals of each view", _rms_words(case), spec, keys)


def _rms_words(case: ReportInput) -> str:
    rms = case.view_rms
    text = f"RMS of all points used: {case.summary.rms:.3f} px (dotted line)."
    if np.isfinite(rms).any():
        worst = int(np.nanargmax(rms))
        text += f" Largest: view {worst} with {rms[worst]:.3f} px."
    empty = np.flatnonzero(~np.isfinite(rms))
    if len(empty):
        text += f" No point was used in {views_listed(empty)}."
    return text


def residuals_figure(case: ReportInput) -> Figure:
    """Residual vectors: one set of arrows for every view, and the mean of each cell over all views."""
    width, height = case.image_size
    most = int(np.clip(MAX_ARROWS // max(len(case.dataset), 1), 50, MAX_ARROWS_OF_VIEW))
    typical = float(np.sqrt(np.mean(case.residuals[case.used] ** 2))) if case.used.any() else 1.0
    views = [_mean_arrows(case), *(_view_arrows(case, view, typical, most) for view in range(len(case.dataset)))]
    spec = {
        "data": [],
        "layout": image_layout(width, height, around=0.03 * width, above=0.07 * height) | {"dragmode": "zoom"},
        "width": width,
        "height": height,
        "views": views,
    }
    words = "Arrows run from the measured point towards its prediction, enlarged as the arrow above the image says."
    if case.seen.sum(axis=1).max(initial=0) > most:
        words += f" At most {most} points of a view are drawn, evenly taken from all."
    keys = (Key("--accent", "→", "used"), Key("--bad", "✕", "left out")) if case.rejected.any() else ()
    return Figure("residuals", "Residual vectors", words, spec, keys)


def _view_arrows(case: ReportInput, view: int, typical: float, most: int) -> Json:
    used, rejected = np.flatnonzero(case.used[view]), np.flatnonzero(case.rejected[view])
    shown, crossed = used[evenly(len(used), most)], rejected[evenly(len(rejected), most)]
    words = f"{counted(len(used), 'point')} used"
    words += f", RMS {case.view_rms[view]:.3f} px" if len(used) else ""
    words += f"; {len(shown)} drawn" if len(shown) < len(used) else ""
    words += f"; {len(rejected)} left out (crosses)" if len(rejected) else ""
    words += "; the pose of this view was not believed" if view in case.summary.rejectedViews else ""
    return {
        "label": f"View {view}",
        "words": f"{words}.",
        "used": packed(np.hstack([case.image_points[view, shown], case.residuals[view, shown]])),
        "rejected": packed(np.hstack([case.image_points[view, crossed], case.residuals[view, crossed]])),
        **_scale(typical, case.image_size[0]),
    }


def _mean_arrows(case: ReportInput) -> Json:
    """The mean residual of every cell: what all views have in common, as an error of the lens model has."""
    width, height = case.image_size
    points, residuals = case.image_points[case.used], case.residuals[case.used]
    cell = 1.5 * cell_size(width, height, len(points))
    columns = math.ceil(width / cell)
    index = ((points[:, 1] + 0.5) // cell * columns + (points[:, 0] + 0.5) // cell).astype(np.int64)
    index = np.clip(index, 0, None)
    counts = np.maximum(np.bincount(index), 1)
    means = [np.bincount(index, weights=x) / counts for x in (*points.T, *residuals.T)]
    arrows = np.column_stack(means)[np.bincount(index) >= MIN_POINTS_OF_CELL] if len(points) else np.zeros((0, 4))
    typical = float(np.sqrt(np.mean(arrows[:, 2:] ** 2))) if len(arrows) else 1.0
    words = f"Mean residual of each {cell:.0f} px cell with at least {MIN_POINTS_OF_CELL} points, over all views: "
    words += f"RMS {typical:.3f} px. A pattern here, such as all arrows pointing outwards, means that the lens model "
    words += "is not right."
    empty = packed(np.zeros((0, 4)))
    return {
        "label": "All views, averaged",
        "words": words if len(arrows) else "Too few points for means.",
        "used": packed(arrows),
        "rejected": empty,
        **_scale(typical, width),
    }


def _scale(typical: float, width: int) -> Json:
    """Enlargement of the arrows, and a round length in pixels for the arrow that explains it."""
    typical = max(typical, 1e-9)
    wished = ARROW_SHARE * width / (math.sqrt(2) * typical)
    enlargement = _round_number(wished)
    reference = _round_number(0.1 * width / enlargement)
    label = f"{reference:.9f}".rstrip("0").rstrip(".") if reference < 1 else two_digits(reference)
    return {"enlargement": enlargement, "reference": reference, "referenceLabel": f"{label} px"}


def _round_number(x: float) -> float:
    """The largest of 1, 2, 5 x 10^k that is not above `x`."""
    power = 10.0 ** math.floor(math.log10(x))
    return float(next(step * power for step in (5, 2, 1) if step * power <= x * (1 + 1e-12)))
