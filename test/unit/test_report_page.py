# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The HTML page says what the summary says, the same bytes every time, and asks nothing of the network."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.refined_recording import K, RefinedRecording, refined_recording
from support.report_page import board_comparison, case_of, page_of

import cv_active_handeye as cah
from cv_active_handeye.report import write_report
from cv_active_handeye.report.tables import provenance
from cv_active_handeye.report.verdict import tool_accuracy, verdict
from cv_active_handeye.report.words import listed, sentence, two_digits
from cv_active_handeye.workflow import Evidence
from cv_active_handeye.workflow.compare import BoardCamera, Comparison, MethodResult

NASTY = "</script><script>alert('x')</script><img src=\"http://example.org/a.png\"> & \u2028"


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> RefinedRecording:
    return refined_recording(tmp_path_factory.mktemp("recorded") / "set", description="Cell 3")


@pytest.fixture
def recording(recorded: RefinedRecording) -> RefinedRecording:
    """With a summary that the test may change."""
    return replace(recorded, summary=deepcopy(recorded.summary))


def counts(recording: RefinedRecording) -> tuple[int, int]:
    """Image points that were left out, and all."""
    return int(recording.summary.rejectedObservations.sum()), recording.calibration.observations


def test_same_input_gives_the_same_bytes_wherever_the_data_set_lies(tmp_path: Path) -> None:
    for name in ("a", "b"):
        r = refined_recording(tmp_path / name / "set")
        write_report(tmp_path / f"{name}.html", r.dataset, r.calibration, r.evidence, r.summary)
    content = (tmp_path / "a.html").read_bytes()
    assert content == (tmp_path / "b.html").read_bytes()
    assert str(tmp_path).encode() not in content


def test_page_takes_what_refineHandEye_gives(recording: RefinedRecording, tmp_path: Path) -> None:
    dataset, points = recording.dataset, recording.evidence.image_points
    start = (None, None, None, None, None)
    *_, summary = cah.refineHandEye(dataset.R_gripper2base, dataset.t_gripper2base, points, *start)
    write_report(tmp_path / "real.html", dataset, recording.calibration, Evidence(points, ()), summary)
    assert "Calibration report" in (tmp_path / "real.html").read_text(encoding="utf-8")


def test_verdict_comes_first_with_accuracy_at_the_tool(recording: RefinedRecording) -> None:
    page = page_of(recording)
    first = next(text for text in page.texts if text.strip() in ("Usable", "Usable in part", "Do not use"))
    assert first.strip() == "Usable"
    accuracy = tool_accuracy(recording.summary)
    assert accuracy is not None
    assert f"working distance of 400 mm is placed to ± {two_digits(accuracy.worst)} mm" in page.words
    left_out, seen = counts(recording)
    assert f"image points used {seen - left_out} of {seen}" in page.words


def test_accuracy_at_the_tool_is_the_longest_axis_of_its_covariance(recording: RefinedRecording) -> None:
    summary = recording.summary
    summary.toolCovariance = np.diag([1e-8, 4e-8, 9e-8])
    summary.intervals95 = np.column_stack([-2.1 * summary.standardDeviations, 2.1 * summary.standardDeviations])
    accuracy = tool_accuracy(summary)
    assert accuracy is not None
    assert accuracy.worst == pytest.approx(1000 * 2.1 * 3e-4)
    assert accuracy.axes == pytest.approx((0.21, 0.42, 0.63))


def test_an_unusable_result_says_why_and_claims_no_accuracy(recording: RefinedRecording) -> None:
    recording.summary.usable = False
    recording.summary.message = "not usable: no convergence after maxIterations = 50"
    page = page_of(recording)
    assert "Do not use" in page.words
    assert "No convergence after maxIterations = 50." in page.words
    assert "Do not move the robot by this result." in page.words
    assert "is placed to ±" not in page.words


def test_parameters_that_were_not_observed_are_named_and_have_no_interval(recording: RefinedRecording) -> None:
    summary = recording.summary
    row = summary.parameterNames.index("tz")
    summary.standardDeviations[row] = np.inf
    summary.intervals95[row] = [-np.inf, np.inf]
    summary.toolCovariance = np.full((3, 3), np.inf)
    summary.weakDirections = ["t_cam2gripper along gripper (0.00, 0.00, 1.00): not observed; add a rotation"]
    page = page_of(recording)
    assert "Usable in part" in page.words
    assert "Not observed: tz." in page.words
    assert "tz 45 not observed mm" in page.words
    assert page.words.count("t_cam2gripper along gripper (0.00, 0.00, 1.00): not observed; add a rotation.") == 2
    assert "cannot be said" in page.words
    assert "tz" not in page.figures()["correlation"]["data"][0]["x"]


def test_parameters_are_shown_to_the_digits_their_interval_allows(recording: RefinedRecording) -> None:
    recording.summary.intervals95[0] = [1411.3, 1414.9]
    recording.summary.intervals95[13] = [0.03497, 0.03503]
    words = page_of(recording).words
    assert "fx 1413.0 ± 1.8 px 1411.3 to 1414.9" in words
    assert "tx 35.000 ± 0.030 mm 34.970 to 35.030" in words
    assert "skew 0 kept px" in words


def test_copied_numbers_are_exact(recording: RefinedRecording) -> None:
    text = next(text for text in page_of(recording).texts if text.startswith("parameter\t"))
    rows = {line.split("\t")[0]: line.split("\t")[1:] for line in text.splitlines()[1:]}
    assert float(rows["fy"][0]) == recording.calibration.camera_matrix[1, 1]
    assert float(rows["d"][0]) == 1000 * recording.calibration.light_plane[3]  # type: ignore[index]
    assert rows["tx"][3] == "mm"
    assert float(rows["k1"][1]) < -0.08 < float(rows["k1"][2])


def test_culprits_and_rejected_parts_are_named(recording: RefinedRecording) -> None:
    recording.summary.culprits = ["view 3: its pose is off by 0.0005"]
    recording.summary.rejectedViews = [3]
    page = page_of(recording)
    assert "View 3: its pose is off by 0.0005." in page.words
    left_out, seen = counts(recording)
    assert f"{left_out} image points of {seen} ({100 * left_out / seen:.1f} %) left out" in page.words
    assert "1 stripe segment of 48 left out" in page.words
    assert "Segments left out (1)" in page.words
    assert "3 not believed" in page.words
    assert len(page.figures()["motion"]["data"]) == 1 + 2 * 4 + 1


def test_without_laser_and_board_their_sections_are_absent(tmp_path: Path) -> None:
    page = page_of(refined_recording(tmp_path / "set", laser=False))
    assert {"stripes", "comparison"}.isdisjoint(attributes.get("id") for _, attributes in page.tags)
    assert "stripes" not in page.figures()
    assert "Light plane" not in page.words


def test_board_comparison_shows_every_method_and_why_one_gave_nothing(recording: RefinedRecording) -> None:
    words = page_of(recording, board_comparison()).words
    assert "stillest with “ours”: 0.120 mm" in words
    assert "of OpenCV's methods, with “OpenCV PARK”: 0.410 mm" in words
    assert "OpenCV TSAI gave NaN – – –" in words


def test_contribution_of_every_group_to_the_light_plane(recording: RefinedRecording, tmp_path: Path) -> None:
    normal, offset = np.degrees(np.sqrt(np.trace(recording.summary.covariance[16:19, 16:19]))), 0.02
    words = page_of(recording).words
    assert f"none 23 {two_digits(normal)} {two_digits(offset)}" in words
    assert "4 views from view 0 on 11 3 0.18 0.42" in words
    assert "4 views from view 4 on 12 3 not determined not determined" in words
    assert "contributes" not in page_of(refined_recording(tmp_path / "dark", laser=False)).words


def test_page_of_a_result_that_used_nothing_still_stands(recording: RefinedRecording) -> None:
    summary = recording.summary
    summary.usable = False
    summary.rejectedObservations[:] = 1
    summary.viewRms[:] = np.nan
    summary.scenePoints[:] = np.nan
    summary.stripeResiduals[:] = np.nan
    summary.poseCorrections[:] = np.nan
    summary.covariance[:] = 0
    summary.standardDeviations[:] = 0
    summary.lensTests[:] = np.nan
    words = page_of(recording).words
    assert "No image point was used." in words
    assert "No point was used in views 0, 1, 2" in words


def test_texts_of_data_set_and_solver_cannot_become_markup(recording: RefinedRecording, tmp_path: Path) -> None:
    nasty = refined_recording(tmp_path / "nasty", description=NASTY)
    for name in ("culprits", "weakDirections"):
        setattr(nasty.summary, name, [NASTY])
    nasty.summary.usable, nasty.summary.message, nasty.summary.stopReason = False, NASTY, NASTY
    comparison = Comparison(BoardCamera(0.2, K, np.zeros(5), [0]), [MethodResult(NASTY, problem=NASTY)])
    nasty_page, page = page_of(nasty, comparison), page_of(recording)
    count = [sum(tag == "script" for tag, _ in found.tags) for found in (nasty_page, page)]
    assert count == [3, 3]
    assert not any(tag == "img" for tag, _ in nasty_page.tags)
    assert "alert('x')" in nasty_page.words


def test_nothing_in_the_page_points_outside(recording: RefinedRecording) -> None:
    page = page_of(recording, board_comparison())
    for tag, attributes in page.tags:
        for name in ("src", "href", "action", "data", "poster", "srcset"):
            assert (attributes.get(name) or "#").startswith(("#", "data:")), (tag, attributes)
    policy = next(a["content"] for tag, a in page.tags if a.get("http-equiv") == "Content-Security-Policy")
    assert policy is not None
    assert "default-src 'none'" in policy
    assert "http" not in policy


def test_provenance_names_version_and_hash_but_no_date(recording: RefinedRecording) -> None:
    facts = dict(provenance(case_of(recording)))
    assert facts["Software"] == f"cv_active_handeye {recording.calibration.software_version}"
    assert facts["Data set (SHA-256)"] == recording.dataset.sha256()
    assert facts["Description"] == "Cell 3"
    assert not any("date" in name.lower() for name in facts)


def test_verdict_names_views_only_where_they_hold_most_of_what_was_left_out(recording: RefinedRecording) -> None:
    rejected = recording.summary.rejectedObservations
    rejected[:] = 0
    rejected[:8, :20] = 1
    assert "most of them" not in verdict(case_of(recording)).left_out[0]
    rejected[5] = 1
    rejected[:4] = 0
    assert "most of them in view 5." in verdict(case_of(recording)).left_out[0]


@pytest.mark.parametrize(
    ("x", "text"), [(0.0, "0"), (0.0123, "0.012"), (0.0996, "0.10"), (9.96, "10"), (1234.0, "1234"), (np.nan, "–")]
)
def test_two_digits_rounds_without_exponents(x: float, text: str) -> None:
    assert two_digits(x) == text


def test_sentences_begin_with_a_capital_unless_with_a_name() -> None:
    assert sentence("view 3: moved") == "View 3: moved."
    assert sentence("cx, cy: weak.") == "cx, cy: weak."
    assert sentence("t_cam2gripper: not observed") == "t_cam2gripper: not observed."
    assert sentence("") == "."


def test_listed_shortens_long_lists() -> None:
    assert listed([3]) == "3"
    assert listed([3, 4, 9]) == "3, 4 and 9"
    assert listed(range(20), most=2) == "0, 1 and 18 more"
