# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The judge of the fault campaign finds every kind of broken promise."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmark import faults
from benchmark.faults import Capture, Trial
from cv_active_handeye.dataset import CameraInfo, Dataset


def trial(folder: Path, capture: Capture, stored: int, readable: int, fault: str = "protective_stop") -> list[str]:
    dataset = Dataset.create(folder / "set", camera=CameraInfo(width=8, height=6))
    for _ in range(readable):
        dataset.add_view(np.eye(3), np.zeros(3), image=np.zeros((6, 8), np.uint8))
    lines = [json.dumps({"event": "stored"}) for _ in range(stored)]
    (folder / "set" / "events.jsonl").write_text("\n".join(lines) + "\n")
    return faults._judged(folder, capture, fault)


@pytest.mark.parametrize(
    ("capture", "stored", "readable", "text"),
    [
        (Capture(6, "protective stop: touched", 3.0), 2, 2, None),
        (Capture(6, "something went wrong", 3.0), 2, 2, "not named"),
        (Capture(6, "protective stop", 3.0), 3, 2, "lost views: 3 were stored, 2 can be read"),
        (Capture(1, "Traceback: protective stop", 3.0), 2, 2, "exception, status 1"),
        (Capture(None, "", 90.0), 2, 2, "hang"),
        (Capture(0, "", 3.0), 2, 2, "an incomplete capture ended as a complete one"),
    ],
)
def test_broken_promises_of_a_capture_are_found(
    tmp_path: Path, capture: Capture, stored: int, readable: int, text: str | None
) -> None:
    broken = trial(tmp_path, capture, stored, readable)
    if text is None:
        assert broken == []
    else:
        assert [one for one in broken if text in one]


def event(kind: str, time: float, **what: Any) -> str:
    return json.dumps({"kind": kind, "time": time, **what})


@pytest.mark.parametrize(("asked", "found"), [(9.9, 0), (10.2, 0), (10.4, 1), (20.0, 1)])
def test_motion_asked_for_after_a_stop_is_found(tmp_path: Path, asked: float, found: int) -> None:
    log = tmp_path / "controller.jsonl"
    lines = [
        event("motion_begin", 1.0, motion=1, asked=1.0),
        event("stop_condition", 10.0, reason="link lost"),
        event("motion_begin", asked, motion=2, asked=asked),
        event("cleared", 30.0),
        event("motion_begin", 31.0, motion=3, asked=31.0),
    ]
    log.write_text("\n".join(lines) + "\n")
    assert len(faults._judged_by_controller(log)) == found


def test_every_broken_promise_is_counted_in_its_measure() -> None:
    texts = ["moved after a stop: x", "lost views: x", "hang: x", "exception, status 1: x", "not named: x"]
    texts += ["resumed: not completed, x", "resumed: changed views x"]
    report = faults.report_of([Trial("ur", "drop_link", "@move1", "stopped", 2, 3.0, (text,)) for text in texts])
    counts = {measure.name: measure.value for measure in report.measures}
    assert counts == {
        "fault trials": 7,
        "moves after a stop condition": 1,
        "lost or changed views": 2,
        "hangs": 1,
        "unhandled exceptions": 1,
        "faults that were not named": 1,
        "captures that could not be completed afterwards": 1,
    }
    assert not faults.report_of([Trial("ur", "drop_link", "", "stopped", 2, 3.0, ())] * 200).missed


def test_moments_are_drawn_from_the_seed() -> None:
    moments = [faults._moment(np.random.default_rng([seed, 5]), "protective_stop") for seed in range(60)]
    assert moments == [faults._moment(np.random.default_rng([seed, 5]), "protective_stop") for seed in range(60)]
    kinds = {"later" if moment.endswith("later") else moment[:5] for moment in moments}
    assert kinds == {"later", "@move", "@stop"}
