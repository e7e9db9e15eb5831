# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Figures of the model: correlations, corrections of the robot's poses, stripe residuals."""

from __future__ import annotations

import numpy as np

from ..files import FloatArray
from .inputs import BoolArray, ReportInput
from .plotting import Figure, Json, Key, axis, colour_bar, layout, line, packed, polylines, view_axis
from .words import counted, views_listed

STRONG = 0.9
AXES = {"x": ("--group-1", "circle", "●"), "y": ("--group-2", "square", "■"), "z": ("--group-0", "diamond", "◆")}


def correlation_figure(case: ReportInput) -> Figure | None:
    """Correlations of all parameters that were estimated; None for fewer than two."""
    names = [case.summary.parameterNames[i] for i in case.free]
    if len(names) < 2:
        return None
    rho = correlations(case)
    scale = [[0, "--minus"], [0.5, "--raised"], [1, "--plus"]]
    heat = {
        "type": "heatmap",
        "z": packed(rho),
        "x": names,
        "y": names,
        "zmin": -1,
        "zmax": 1,
        "xgap": 1,
        "ygap": 1,
        "colorscale": scale,
        "colorbar": colour_bar(tickvals=[-1, -0.5, 0, 0.5, 1]),
        "hovertemplate": "%{y}, %{x}: %{z:.3f}<extra></extra>",
    }
    labels = {"showgrid": False, "dtick": 1, "constrain": "domain", "tickfont": {"color": "--muted", "size": 11}}
    x = axis("", side="top", tickangle=-90, **labels)
    y = axis("", autorange="reversed", scaleanchor="x", **labels)
    spec = {"data": [heat], "layout": layout(xaxis=x, yaxis=y, margin={"l": 8, "r": 8, "t": 8, "b": 58})}
    words = f"Of {counted(len(names), 'parameter')} that were estimated. Positive: both err to the same side."
    return Figure("correlation", "Correlation of the parameters", words, spec)


def correlations(case: ReportInput) -> FloatArray:
    """Correlation matrix of the parameters in `case.free`."""
    C = np.asarray(case.summary.covariance, np.float64)[np.ix_(case.free, case.free)]
    sigmas = np.sqrt(np.diag(C))
    return np.asarray(np.clip(C / np.outer(sigmas, sigmas), -1, 1), np.float64)


def strongest_correlations(case: ReportInput, most: int = 8) -> list[tuple[str, str, str]]:
    """Pairs of parameters beyond `STRONG` with their correlation, strongest first; else the strongest pair alone."""
    names, rho = [case.summary.parameterNames[i] for i in case.free], correlations(case)
    i, j = np.triu_indices(len(names), 1)
    order = np.argsort(-np.abs(rho[i, j]), kind="stable")
    chosen = [k for k in order if abs(rho[i[k], j[k]]) > STRONG] or list(order[:1])
    return [(names[i[k]], names[j[k]], f"{rho[i[k], j[k]]:+.3f}") for k in chosen[:most]]


def poses_figure(case: ReportInput) -> Figure | None:
    """Pose corrections of each view beside twice the robot's sigma; None where the robot is taken as exact."""
    sigmas = np.array([1000 * case.summary.robotTranslationSigma, np.degrees(case.summary.robotRotationSigma)])
    if not (sigmas > 0).any():
        return None
    translation, rotation = case.pose_corrections[:, 3:], case.pose_corrections[:, :3]
    data = [*_corrections(translation, "y", "mm"), *_corrections(rotation, "y2", "deg")]
    upper = axis("translation [mm]", domain=[0.55, 1], zeroline=True, zerolinecolor="--line")
    lower = axis("rotation [deg]", domain=[0, 0.45], zeroline=True, zerolinecolor="--line")
    both = zip(("y", "y2"), sigmas, strict=True)
    bands = [line(side * 2 * sigma, "--muted", yref=ref) for ref, sigma in both for side in (-1, 1) if sigma > 0]
    look = layout(xaxis=view_axis(len(case.dataset), anchor="y2"), yaxis=upper, yaxis2=lower, shapes=bands)
    keys = (Key(colour, mark, f"base {name}") for name, (colour, _, mark) in AXES.items())
    words = _poses_words(case, sigmas)
    return Figure("poses", "Corrections of the robot's poses", words, {"data": data, "layout": look}, tuple(keys))


def _corrections(values: FloatArray, y: str, unit: str) -> list[Json]:
    return [
        {
            "type": "scatter",
            "mode": "markers",
            "x": list(range(len(values))),
            "y": packed(values[:, k]),
            "yaxis": y,
            "marker": {"color": colour, "symbol": symbol, "size": 7},
            "hovertemplate": f"view %{{x}}, {name}: %{{y:.4f}} {unit}<extra></extra>",
        }
        for k, (name, (colour, symbol, _)) in enumerate(AXES.items())
    ]


def _poses_words(case: ReportInput, sigmas: FloatArray) -> str:
    sizes = np.abs(np.nan_to_num(case.pose_corrections))
    translation, rotation = sizes[:, 3:].max(axis=1), sizes[:, :3].max(axis=1)
    t, r = int(translation.argmax()), int(rotation.argmax())
    text = "Dashed: ± 2 sigma of the robot. "
    text += f"Largest: view {t} with {translation[t]:.3f} mm, view {r} with {rotation[r]:.4f} deg."
    with_sigma = np.where(sigmas > 0, sigmas, np.inf)
    beyond = np.flatnonzero((translation > 3 * with_sigma[0]) | (rotation > 3 * with_sigma[1]))
    return f"{text} Beyond 3 sigma: {views_listed(beyond) if len(beyond) else 'none'}."


def stripes_figure(case: ReportInput) -> Figure | None:
    """Distance of both ends of every stripe segment from the prediction, along the stripe; None without stripes."""
    residuals = case.stripe_residuals
    known = np.isfinite(residuals).all(axis=1)
    if not known.any():
        return None
    vertical = case.dataset.laser is not None and case.dataset.laser.stripe == "vertical"
    along = np.array([segment.points[[0, -1], 1 if vertical else 0] for segment in case.evidence.segments])
    rejected = np.zeros(len(residuals), np.bool_)
    rejected[list(case.summary.rejectedSegments)] = True
    data = [
        _segments(along, residuals, known & ~rejected, "--accent"),
        _segments(along, residuals, known & rejected, "--bad"),
    ]
    keys = (Key("--accent", "━", "used"), Key("--bad", "━", "left out")) if (known & rejected).any() else ()
    extent = case.image_size[1] if vertical else case.image_size[0]
    x = axis(f"along the stripe: {'v' if vertical else 'u'} [px]", range=[-0.5, extent - 0.5])
    y = axis("residual [px]", zeroline=True, zerolinecolor="--line")
    words = _stripes_words(residuals, known & ~rejected, int((~known & ~rejected).sum()))
    return Figure("stripes", "Stripe residuals", words, {"data": data, "layout": layout(xaxis=x, yaxis=y)}, keys)


def _stripes_words(residuals: FloatArray, used: BoolArray, unsure: int) -> str:
    text = f"{counted(int(used.sum()), 'segment')} used, one line each from end to end"
    if used.any():
        text += f"; RMS {np.sqrt(np.mean(residuals[used] ** 2)):.3f} px"
    return f"{text}." + (f" {counted(unsure, 'segment')} not used: the surface is not known." if unsure else "")


def _segments(along: FloatArray, residuals: FloatArray, chosen: BoolArray, colour: str) -> Json:
    ends = polylines(np.stack([along[chosen], residuals[chosen]], axis=2))
    return {
        "type": "scatter",
        "mode": "lines+markers",
        "x": packed(ends[:, 0]),
        "y": packed(ends[:, 1]),
        "customdata": np.repeat(np.flatnonzero(chosen), 3).tolist(),
        "hovertemplate": "segment %{customdata}: %{y:.3f} px<extra></extra>",
        "line": {"color": colour, "width": 1},
        "marker": {"color": colour, "size": 4},
    }
