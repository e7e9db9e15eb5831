# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Between groups of stops the rest of a plan is improved, as soon as and only where that can be done."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.planning_cell import settings, start
from support.recordings import Notes
from support.scripted_robot import ScriptedRobot

from cv_active_handeye.config import CalibrationOptions
from cv_active_handeye.dataset import CameraInfo, Dataset
from cv_active_handeye.plan_file import Plan
from cv_active_handeye.workflow.capture import Improve
from cv_active_handeye.workflow.next_motion import next_motion
from cv_active_handeye.workflow.plan import make_plan
from cv_active_handeye.workflow.plan_knowledge import Knowledge

STOPS = 14
KNOWN = {"robot_translation_mm": 0.02, "robot_rotation_deg": 0.005, "lens_model": "none"}


@pytest.fixture(scope="module")
def plan() -> Plan:
    return make_plan(start(None), settings(stops=STOPS))


def recording(folder: Path, plan: Plan, taken: int) -> Dataset:
    """The first stops of the plan, with points that half of the assumed scene shows there."""
    truth, rng = Knowledge.assumed(start(None), settings()), np.random.default_rng(4)
    points = truth.points[np.argsort(truth.points[:, 0])[: len(truth.points) // 2]]
    stops = np.array([stop.T_gripper2base for stop in plan.stops[:taken]])
    turns = Rotation.from_rotvec(np.radians(0.005) * rng.normal(size=(taken, 3))).as_matrix()
    camera = stops @ truth.T_cam2gripper
    Y = np.einsum("vji,vnj->vni", camera[:, :3, :3], points[None] - camera[:, None, :3, 3])
    pixels = Y @ truth.camera_matrix.T
    pixels = pixels[..., :2] / pixels[..., 2:] + rng.normal(0, 0.1, (*Y.shape[:2], 2))
    pixels[((pixels < 0) | (pixels > (639, 479))).any(axis=2)] = np.nan
    dataset = Dataset.create(folder, camera=CameraInfo(width=640, height=480))
    for turn, T in zip(turns, stops, strict=True):
        dataset.add_view(turn @ T[:3, :3], T[:3, 3] + 2e-5 * rng.normal(size=3))
    dataset.set_image_points(pixels)
    return dataset


def asked(notes: Notes, **changes: object) -> Improve:
    options = CalibrationOptions.model_validate(KNOWN)
    return next_motion(ScriptedRobot(), options, settings(**{"stops": STOPS, **changes}), notes)


def same(a: Plan | None, b: Plan) -> bool:
    return a is not None and a.sha256() == b.sha256()


def test_rest_of_the_plan_is_improved_when_the_views_can_be_calibrated(plan: Plan, tmp_path: Path) -> None:
    improve = asked(Notes())
    better = improve(recording(tmp_path / "set", plan, 10), plan)
    assert better is not None
    assert not same(better, plan)
    assert len(better.stops) == STOPS
    assert better.stops[:10] == plan.stops[:10]
    # soon after it stays as it is
    assert same(improve(recording(tmp_path / "more", better, 12), better), better)


def test_plan_stays_as_long_as_the_views_cannot_be_calibrated(plan: Plan, tmp_path: Path) -> None:
    assert same(asked(Notes())(recording(tmp_path / "few", plan, 2), plan), plan)
    assert same(asked(Notes())(recording(tmp_path / "group", plan, 4), plan), plan)


def test_plan_without_a_target_ends_with_its_last_stop(plan: Plan, tmp_path: Path) -> None:
    assert same(asked(Notes())(recording(tmp_path / "set", plan, STOPS), plan), plan)


def test_target_that_is_met_ends_the_capture(plan: Plan, tmp_path: Path) -> None:
    assert asked(Notes(), stops=None, target_sigma_mm=5.0)(recording(tmp_path / "set", plan, 10), plan) is None


def test_target_that_is_not_met_by_the_last_stop_asks_for_more(plan: Plan, tmp_path: Path) -> None:
    predicted = plan.predictions[-1].t_cam2gripper_mm
    assert predicted is not None
    improve = asked(Notes(), stops=None, target_sigma_mm=0.8 * predicted, most_stops=40)
    longer = improve(recording(tmp_path / "set", plan, STOPS), plan)
    assert longer is not None
    assert STOPS < len(longer.stops) < 40
    assert longer.stops[:STOPS] == plan.stops


def test_target_out_of_reach_is_told_and_the_plan_stays(plan: Plan, tmp_path: Path) -> None:
    notes = Notes()
    improve = asked(notes, stops=None, target_sigma_mm=0.001, most_stops=16)
    assert same(improve(recording(tmp_path / "set", plan, 10), plan), plan)
    assert "the plan stays as it is: target_sigma_mm: 0.001 mm is out of reach" in " ".join(notes.notes)
