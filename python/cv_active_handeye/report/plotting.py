# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Figures as plotly.js reads them: plain dictionaries.

Colours are names of the style sheet's custom properties ("--ink"); the page's script puts in their values, so that
figures follow the light or dark scheme of the page.
"""

from __future__ import annotations

import base64
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Json = dict[str, Any]

GROUP_COLOURS = tuple(f"--group-{number}" for number in range(8))
OTHER_COLOUR = "--muted"
FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif"


class Key(NamedTuple):
    """One entry of a figure's legend: what a colour and a mark stand for."""

    colour: str
    mark: str
    text: str


class Figure(NamedTuple):
    """One figure of the page: `spec` for plotly.js, and in words what it shows, for all readers."""

    name: str
    title: str
    words: str
    spec: Json
    keys: tuple[Key, ...] = ()


def packed(values: Any) -> Json:
    """An array in plotly's compact form, single precision; NaN makes a gap in a line."""
    array = np.ascontiguousarray(values, dtype="<f4")
    shape = {"shape": ", ".join(map(str, array.shape))} if array.ndim > 1 else {}
    return {"dtype": "f4", "bdata": base64.b64encode(array.tobytes()).decode("ascii"), **shape}


def layout(**changes: Any) -> Json:
    """The common look of the figures."""
    return {
        "font": {"family": FONT, "size": 13, "color": "--ink"},
        "paper_bgcolor": "--clear",
        "plot_bgcolor": "--clear",
        "colorway": list(GROUP_COLOURS),
        "margin": {"l": 54, "r": 12, "t": 8, "b": 44},
        "hoverlabel": {"bgcolor": "--raised", "bordercolor": "--line", "font": {"color": "--ink", "size": 13}},
        "dragmode": False,
        "showlegend": False,
        **changes,
    }


def axis(title: str, **changes: Any) -> Json:
    """A quiet axis."""
    return {
        "title": {"text": title, "font": {"color": "--muted"}, "standoff": 8},
        "gridcolor": "--grid",
        "linecolor": "--line",
        "tickcolor": "--line",
        "tickfont": {"color": "--muted", "size": 12},
        "zeroline": False,
        "automargin": True,
        **changes,
    }


def colour_bar(**changes: Any) -> Json:
    """A thin bar under the figure that explains its colours."""
    place = {"orientation": "h", "x": 0.5, "xanchor": "center", "yref": "container", "y": 0.01, "yanchor": "bottom"}
    look = {"thickness": 10, "len": 0.7, "outlinewidth": 0, "tickfont": {"color": "--muted", "size": 12}}
    return {**place, **look, **changes}


def line(y: float, colour: str, dash: str = "dash", **reference: str) -> Json:
    """A horizontal line across the whole figure."""
    ends = {"x0": 0, "x1": 1, "y0": y, "y1": y}
    stroke = {"color": colour, "width": 1.5, "dash": dash}
    return {"type": "line", "xref": "paper", "yref": "y", **ends, "line": stroke, "layer": "below", **reference}


def polylines(lines: NDArray[np.float64]) -> NDArray[np.float64]:
    """(L, P, D) polylines as one (L * (P + 1), D) line with NaN between them."""
    gaps = np.full((len(lines), 1, lines.shape[2]), np.nan)
    return np.concatenate([lines, gaps], axis=1).reshape(-1, lines.shape[2])


def view_axis(views: int, **changes: Any) -> Json:
    """The axis of view numbers, with ticks at whole numbers that have room on a narrow page."""
    step = next(step for step in (1, 2, 5, 10, 20, 50, 10**9) if views <= 12 * step)
    return axis("view", showgrid=False, range=[-0.6, views - 0.4], dtick=step, tickangle=0, **changes)


def evenly(count: int, most: int) -> NDArray[np.int64]:
    """At most `most` numbers out of 0 ... count - 1, evenly spread."""
    return np.arange(count) if count <= most else np.linspace(0, count - 1, most).round().astype(np.int64)
