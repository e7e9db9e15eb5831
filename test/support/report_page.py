# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The HTML report of a refined recording, taken apart."""

from __future__ import annotations

import json
from html.parser import HTMLParser
from typing import Any

import numpy as np
from support.refined_recording import R_CAM2GRIPPER, T_CAM2GRIPPER, K, RefinedRecording

from cv_active_handeye.report.inputs import ReportInput
from cv_active_handeye.report.page import render_report
from cv_active_handeye.workflow.compare import BoardCamera, Comparison, MethodResult


class Page(HTMLParser):
    """Elements, links and texts of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.texts: list[str] = []
        self.scripts: list[str] = []
        self._inside = ""
        self.feed(text)
        self.words = " ".join(" ".join(self.texts).split())

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        self._inside = tag

    def handle_endtag(self, tag: str) -> None:
        self._inside = ""

    def handle_data(self, data: str) -> None:
        if self._inside == "script":
            self.scripts.append(data)
        elif self._inside != "style":
            self.texts.append(data)

    def figures(self) -> dict[str, Any]:
        specs: dict[str, Any] = json.loads(next(text for text in self.scripts if text.startswith("{")))
        return specs


def case_of(recording: RefinedRecording, comparison: Comparison | None = None) -> ReportInput:
    return ReportInput(recording.dataset, recording.calibration, recording.evidence, recording.summary, comparison)


def page_of(recording: RefinedRecording, comparison: Comparison | None = None) -> Page:
    return Page(render_report(case_of(recording, comparison)))


def board_comparison() -> Comparison:
    rows = [
        MethodResult("OpenCV PARK", R_CAM2GRIPPER, T_CAM2GRIPPER, 0.41, 0.03, 1.2),
        MethodResult("OpenCV TSAI", problem="gave NaN"),
        MethodResult("ours", R_CAM2GRIPPER, T_CAM2GRIPPER, 0.12, 0.01, 0.3, (K, np.zeros(5))),
    ]
    return Comparison(BoardCamera(0.21, K, np.zeros(5), [0, 1, 2]), rows)
