# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A point cloud as a PNG file: its height and its sigma, seen along the base axis in which it is thinnest."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ..files import FloatArray
from .pictures import save_figure

MOST_POINTS = 200_000
"""Drawn of a cloud, evenly chosen; more cannot be told apart."""

INCHES = (10.0, 3.2, 11.0)
"""Width of the picture, least and largest height."""


def picture_cloud(file: str | Path, points: FloatArray, sigmas: FloatArray, path: FloatArray | None = None) -> None:
    """Points (N, 3) in metres of the base frame, coloured by height and by their sigmas (N,) in metres.

    Both panels show the two base axes in which the cloud is widest; infinite sigmas have the colour of the largest.
    path (M, 3): drawn as a line upon the cloud, a seam for instance.
    """
    chosen = np.linspace(0, len(points) - 1, min(len(points), MOST_POINTS)).round().astype(np.int64)
    shown, sigma = 1000 * points[chosen], 1000 * sigmas[chosen]
    thin = int(np.argmin(np.ptp(shown, axis=0)))
    across, up = (axis for axis in range(3) if axis != thin)
    x_limits, y_limits = _limits(shown[:, across], shown[:, up])
    figure, panels = _panels((y_limits[1] - y_limits[0]) / (x_limits[1] - x_limits[0]))
    spots = {"s": _spot(len(chosen)), "linewidths": 0, "rasterized": True}
    heights = panels[0].scatter(shown[:, across], shown[:, up], c=shown[:, thin], cmap="viridis", **spots)
    known = sigma[np.isfinite(sigma)]
    least, largest = np.quantile(known, (0.02, 0.98)) if len(known) else (0.0, 1.0)
    limits = {"vmin": least, "vmax": largest, "cmap": "plasma_r"}
    errors = panels[1].scatter(shown[:, across], shown[:, up], c=np.minimum(sigma, largest), **limits, **spots)
    for axes, dots, label, title in (
        (panels[0], heights, f"base {'xyz'[thin]} [mm]", "height"),
        (panels[1], errors, "sigma [mm]", "standard deviation in the worst direction"),
    ):
        axes.set(xlabel=f"base {'xyz'[across]} [mm]", ylabel=f"base {'xyz'[up]} [mm]", xlim=x_limits, ylim=y_limits)
        axes.set_title(title, loc="left", fontsize="medium")
        if path is not None:
            line = 1000 * path[:, [across, up]].T
            axes.plot(*line, color="crimson", linewidth=1.2, marker="o", markersize=2.5, label="root of the groove")
            axes.legend(loc="upper right", fontsize="small")
        axes.set_aspect("equal")
        axes.grid(color="0.9", linewidth=0.6)
        axes.set_axisbelow(True)
        extend = "both" if dots is errors else "neither"
        figure.colorbar(dots, ax=axes, label=label, extend=extend, shrink=0.85, pad=0.02)
    title = f"{len(points)} points of the laser stripe in the base frame"
    figure.suptitle(title, x=0.01, ha="left", fontsize="large")
    save_figure(figure, file)


def _limits(x: FloatArray, y: FloatArray) -> tuple[tuple[float, float], tuple[float, float]]:
    """Limits of both axes (mm) with a margin, so that a single profile does not shrink to a line without height."""
    least = max(0.25 * max(float(np.ptp(x)), float(np.ptp(y))), 1.0)
    middles = [float(values.min() + values.max()) / 2 for values in (x, y)]
    halves = [0.53 * max(float(np.ptp(values)), least) for values in (x, y)]
    (x_low, y_low), (x_high, y_high) = np.subtract(middles, halves).tolist(), np.add(middles, halves).tolist()
    return (x_low, x_high), (y_low, y_high)


def _panels(ratio: float) -> tuple[Figure, Any]:
    """Two panels of height / width = `ratio`: side by side for a tall cloud, one above the other for a wide one."""
    width, least, largest = INCHES
    beside = ratio > 0.6
    height = (width / 2 - 1.75) * ratio + 1.2 if beside else 2 * ((width - 1.8) * ratio + 1.0)
    figure = Figure(figsize=(width, float(np.clip(height, least, largest))), layout="constrained")
    return figure, figure.subplots(1, 2) if beside else figure.subplots(2, 1)


def _spot(count: int) -> float:
    """Area of a point (in points squared) with which many points still are points."""
    return float(np.clip(40_000 / max(count, 1), 0.6, 12))
