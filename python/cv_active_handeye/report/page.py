# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""One self-contained HTML page about a calibration: works from a file, asks no network, same input same bytes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup
from plotly.offline import get_plotlyjs  # type: ignore[import-untyped]  # plotly has no type information

from ..calibration import Calibration
from ..dataset import Dataset
from ..files import write_atomic
from . import parameters, tables
from .figures_image import coverage_figure, residuals_figure, view_rms_figure
from .figures_motion import motion_figure
from .figures_statistics import correlation_figure, poses_figure, stripes_figure, strongest_correlations
from .inputs import ReportInput, Summary
from .plotting import Figure
from .verdict import verdict
from .words import sentence

if TYPE_CHECKING:
    from ..workflow.compare import Comparison
    from ..workflow.evidence import Evidence


def write_report(
    path: str | Path,
    dataset: Dataset,
    calibration: Calibration,
    evidence: Evidence,
    summary: Summary,
    comparison: Comparison | None = None,
) -> None:
    """Writes the page to `path`, atomic; `summary` is the `cah.RefineSummary` behind `calibration`."""
    page = render_report(ReportInput(dataset, calibration, evidence, summary, comparison))
    write_atomic(Path(path), page.encode())


def render_report(case: ReportInput) -> str:
    """The page as text."""
    loader = PackageLoader("cv_active_handeye.report")
    environment = Environment(
        loader=loader,
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals["inline"] = lambda name: Markup(loader.get_source(environment, name)[0])
    return environment.get_template("report.html.j2").render(_content(case))


def _content(case: ReportInput) -> dict[str, Any]:
    groups = parameters.parameter_groups(case)
    figures = _figures(case)
    return {
        "case": case,
        "sections": _sections(case),
        "verdict": verdict(case),
        "groups": groups,
        "unobserved": case.unobserved,
        "table_text": parameters.table_text(groups),
        "matrices_text": parameters.matrices_text(case.calibration),
        "figures": figures,
        "specs": _json({name: figure.spec for name, figure in figures.items() if figure}),
        "weak_directions": [sentence(text) for text in case.summary.weakDirections],
        "correlated": strongest_correlations(case) if len(case.free) > 1 else [],
        "noise": tables.noise_levels(case),
        "chi_square": tables.chi_square_words(case),
        "lens_tests": tables.lens_tests(case),
        "views": tables.views_table(case),
        "stripe_groups": tables.stripe_groups(case.summary),
        "segments": tables.rejected_segments(case),
        "comparison": tables.comparison_table(case),
        "comparison_words": tables.comparison_words(case),
        "provenance": tables.provenance(case),
        "plotly": Markup(get_plotlyjs()),
    }


def _sections(case: ReportInput) -> dict[str, str]:
    """Name and title of every section in the order of the page; each has its template."""
    sections = {
        "verdict": "Verdict",
        "parameters": "Parameters",
        "residuals": "Residuals and coverage",
        "determinacy": "What the data determine",
        "motion": "Motion",
        "model": "Noise and model",
    }
    if case.evidence.segments:
        sections["stripes"] = "Light plane and stripe"
    if case.comparison:
        sections["comparison"] = "Comparison with OpenCV"
    return {**sections, "provenance": "Provenance"}


def _figures(case: ReportInput) -> dict[str, Figure | None]:
    """By name; None where there is nothing to show."""
    return {
        "view_rms": view_rms_figure(case),
        "residuals": residuals_figure(case),
        "coverage": coverage_figure(case),
        "correlation": correlation_figure(case),
        "motion": motion_figure(case),
        "poses": poses_figure(case),
        "stripes": stripes_figure(case),
    }


def _json(value: Any) -> Markup:
    """JSON that can stand in a script element: nothing in it can end the element."""
    text = json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return Markup(text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e"))
