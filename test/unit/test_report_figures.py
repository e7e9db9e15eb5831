# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The figures of the HTML page hold the numbers of the summary, and look right in both colour schemes."""

from __future__ import annotations

import base64
import json
import re
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from plotly import graph_objects  # type: ignore[import-untyped]  # plotly has no type information
from support.refined_recording import POINT_SIGMA, RefinedRecording, refined_recording
from support.report_page import Page, case_of, page_of

from cv_active_handeye.dataset import CameraInfo, Dataset, LaserInfo
from cv_active_handeye.report.figures_image import coverage_figure, residuals_figure
from cv_active_handeye.report.figures_motion import coloured_groups
from cv_active_handeye.report.figures_statistics import correlations, stripes_figure, strongest_correlations
from cv_active_handeye.report.page import render_report
from cv_active_handeye.report.tables import noise_levels
from cv_active_handeye.workflow import Evidence, StripeSegment


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> RefinedRecording:
    return refined_recording(tmp_path_factory.mktemp("recorded") / "set")


@pytest.fixture
def recording(recorded: RefinedRecording) -> RefinedRecording:
    """With a summary that the test may change."""
    return replace(recorded, summary=deepcopy(recorded.summary))


def unpacked(packed: dict[str, str]) -> np.ndarray[Any, Any]:
    """The array that plotly.js reads."""
    values = np.frombuffer(base64.b64decode(packed["bdata"]), "<f4")
    return values.reshape([int(n) for n in packed["shape"].split(",")]) if "shape" in packed else values


def test_every_figure_has_a_name_and_words_for_those_who_cannot_see_it(recording: RefinedRecording) -> None:
    page = page_of(recording)
    ids = {attributes["id"] for _, attributes in page.tags if "id" in attributes}
    plots = [attributes for _, attributes in page.tags if "data-figure" in attributes]
    assert {plot["data-figure"] for plot in plots} == set(page.figures())
    for plot in plots:
        assert {plot["aria-labelledby"], plot["aria-describedby"]} <= ids


def test_every_figure_is_valid_for_plotly(recording: RefinedRecording) -> None:
    recording.summary.rejectedViews = [3]
    for name, spec in page_of(recording).figures().items():
        coloured = json.loads(re.sub(r'"--[a-z0-9-]+"', '"#123456"', json.dumps(spec)))
        graph_objects.Figure({"data": coloured["data"], "layout": coloured["layout"]})
        assert name == "residuals" or coloured["data"]


def test_style_sheet_has_every_colour_and_enough_contrast(recording: RefinedRecording) -> None:
    page = render_report(case_of(recording))
    style = page.partition("<style>")[2].partition("</style>")[0]
    schemes = style.split("@media screen", 1)
    light, dark = (dict(re.findall(r"(--[a-z0-9-]+): (#[0-9a-f]{6})", part)) for part in schemes)
    for used in set(re.findall(r'"(--[a-z0-9-]+)"', json.dumps(Page(page).figures()))) - {"--clear"}:
        assert used in light, used
    for colours in (light, dark):
        for ink in ("--ink", "--muted", "--accent", "--good", "--warn", "--bad"):
            for ground in ("--page", "--raised"):
                assert contrast(colours[ink], colours[ground]) >= 4.5, (ink, ground)
        for state in ("good", "warn", "bad"):
            assert contrast(colours[f"--{state}"], colours[f"--{state}-soft"]) >= 4.5, state


def contrast(a: str, b: str) -> float:
    """Contrast of two colours #rrggbb as WCAG defines it."""

    def luminance(colour: str) -> float:
        channels = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
        linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
        return float(linear @ [0.2126, 0.7152, 0.0722])

    low, high = sorted((luminance(a), luminance(b)))
    return (high + 0.05) / (low + 0.05)


def test_large_recordings_are_thinned_out_and_say_so(tmp_path: Path) -> None:
    page = render_report(case_of(refined_recording(tmp_path / "set", views=40, points=20000)))
    words = Page(page).words
    assert len(page) < 10e6
    assert "At most 500 points of a view are drawn" in words
    assert "3000 of 20000 scene points are drawn" in words


def test_exact_robot_has_no_corrections_to_show(recording: RefinedRecording) -> None:
    summary = recording.summary
    summary.robotTranslationSigma = summary.robotRotationSigma = 0.0
    summary.noiseLevels[2:] = 0.0
    page = page_of(recording)
    assert "poses were taken as exact" in page.words
    assert "poses" not in page.figures()
    assert [row.origin for row in noise_levels(case_of(recording))] == ["estimated"] * 2 + ["taken as exact"] * 2


def test_coverage_counts_every_point_that_was_used(recording: RefinedRecording) -> None:
    case = case_of(recording)
    counts = unpacked(coverage_figure(case).spec["data"][0]["z"])
    assert np.nansum(counts) == case.used.sum()
    assert np.nanmin(counts) >= 1


def test_coverage_names_the_edges_where_nothing_was_seen(recording: RefinedRecording) -> None:
    points = recording.evidence.image_points.copy()
    points[(points[:, :, 0] > 400)] = np.nan
    words = coverage_figure(case_of(replace(recording, evidence=Evidence(points, ())))).words
    assert re.search(r"Nothing was seen within 2[34]\d px at the right edge: there the lens", words)


def test_arrows_are_points_and_residuals_of_each_view(recording: RefinedRecording) -> None:
    case = case_of(recording)
    averaged, *views = residuals_figure(case).spec["views"]
    for view, spec in enumerate(views):
        used = unpacked(spec["used"])
        assert used[:, :2] == pytest.approx(case.image_points[view, case.used[view]], abs=1e-4)
        assert used[:, 2:] == pytest.approx(case.residuals[view, case.used[view]], abs=1e-6)
        assert len(unpacked(spec["rejected"])) == case.rejected[view].sum()
    assert np.abs(unpacked(averaged["used"])[:, 2:]).mean() < POINT_SIGMA
    assert 0.01 * 640 < views[0]["enlargement"] * POINT_SIGMA < 0.05 * 640


def test_groups_beyond_the_colours_share_one_entry() -> None:
    found = coloured_groups(np.repeat(np.arange(12), 3))
    assert len(found) == 8
    assert found[-1][0] == "5 others: 15 stops"
    assert sorted(np.concatenate([views for _, views, _ in found])) == list(range(36))


def test_correlations_are_those_of_the_covariance_without_what_was_kept(recording: RefinedRecording) -> None:
    case = case_of(recording)
    rho = correlations(case)
    assert len(rho) == 16
    assert np.diag(rho) == pytest.approx(1)
    first, second, value = strongest_correlations(case)[0]
    names = [case.summary.parameterNames[i] for i in case.free]
    assert float(value) == pytest.approx(rho[names.index(first), names.index(second)], abs=1e-3)
    assert abs(float(value)) == pytest.approx(np.abs(rho - np.eye(16)).max(), abs=1e-3)


def test_stripe_residuals_run_along_a_vertical_stripe(recording: RefinedRecording, tmp_path: Path) -> None:
    camera, laser = CameraInfo(width=640, height=480), LaserInfo(stripe="vertical")
    dataset = Dataset.create(tmp_path / "set", camera=camera, laser=laser)
    for R, t in zip(recording.dataset.R_gripper2base, recording.dataset.t_gripper2base, strict=True):
        dataset.add_view(R, t)
    turned = tuple(StripeSegment(s.view, s.points[:, ::-1], s.surface) for s in recording.evidence.segments)
    evidence = Evidence(recording.evidence.image_points, turned)
    figure = stripes_figure(case_of(replace(recording, dataset=dataset, evidence=evidence)))
    assert figure is not None
    assert figure.spec["layout"]["xaxis"]["title"]["text"] == "along the stripe: v [px]"
    assert unpacked(figure.spec["data"][0]["x"])[:2] == pytest.approx([40, 210])
    assert "31 segments used" in figure.words
    assert "16 segments not used: the surface is not known." in figure.words
