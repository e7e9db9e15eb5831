# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The rest of a plan, chosen anew from what the first stops have shown."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.planning_cell import Array, settings, start
from support.recordings import known_distortion, noisy_dataset

import cv_active_handeye as cah
from cv_active_handeye.plan_file import Plan
from cv_active_handeye.workflow import calibrate_with_evidence
from cv_active_handeye.workflow.plan import improve_plan, make_plan
from cv_active_handeye.workflow.plan_knowledge import Knowledge, predict

TAKEN, STOPS = 9, 14


@pytest.fixture(scope="module")
def plan() -> Plan:
    return make_plan(start(None), settings(stops=STOPS))


@pytest.fixture(scope="module")
def truth() -> Knowledge:
    """The camera is 25 mm, 3 degrees and 3 % from what was told, and only the scene's left half has texture."""
    assumed = Knowledge.assumed(start(None), settings())
    T = assumed.T_cam2gripper.copy()
    T[:3, :3] = Rotation.from_rotvec(np.radians([2, 2, 1])).as_matrix() @ T[:3, :3]
    T[:3, 3] += [0.015, -0.015, 0.013]
    K = assumed.camera_matrix * np.array([[1.03], [1.03], [1]])
    points = assumed.points[np.argsort(assumed.points[:, 0])[: len(assumed.points) // 2]]
    return replace(assumed, T_cam2gripper=T, camera_matrix=K, points=points)


def poses(plan: Plan) -> list[Array]:
    return [stop.T_gripper2base for stop in plan.stops]


def test_rest_of_a_plan_is_better_for_what_is_known_and_keeps_what_was_taken(plan: Plan, truth: Knowledge) -> None:
    better = improve_plan(plan, TAKEN, truth, settings(stops=STOPS))
    assert better.stops[:TAKEN] == plan.stops[:TAKEN]
    assert len(better.stops) == STOPS
    before, after = (predict(poses(p), truth).t_cam2gripper_mm for p in (plan, better))
    assert before is not None
    assert after is not None
    assert after < 0.98 * before
    assert better.predictions[-1].t_cam2gripper_mm == after
    assert better.workspace == plan.workspace


def test_stop_that_was_taken_does_not_come_again() -> None:
    """Without rolls, what was taken already would be among the best again."""
    asked = settings(stops=20, roll_deg=0.0)
    first = make_plan(start(None), asked)
    better = improve_plan(first, TAKEN, Knowledge.assumed(start(None), asked), asked)
    assert len(np.unique(np.round(poses(better), 6), axis=0)) == 20


def test_rest_of_a_plan_is_as_short_as_the_target_allows(plan: Plan, truth: Knowledge) -> None:
    found = predict(poses(plan), truth).t_cam2gripper_mm
    assert found is not None
    asked = settings(stops=None, target_sigma_mm=1.15 * found, most_stops=18)
    better = improve_plan(plan, TAKEN, truth, asked)
    assert TAKEN < len(better.stops) < STOPS
    assert better.predictions[-1].t_cam2gripper_mm is not None
    assert better.predictions[-1].t_cam2gripper_mm <= 1.15 * found


def test_prediction_after_the_first_group_agrees_with_the_calibration_from_noisy_points(
    plan: Plan, truth: Knowledge
) -> None:
    """Points of the true cell, refined from the told mounting: what this knows improves the plan as the truth does."""
    rng = np.random.default_rng(8)
    stops = np.array(poses(plan)[:TAKEN])
    camera = stops @ truth.T_cam2gripper
    Y = np.einsum("vji,vnj->vni", camera[:, :3, :3], truth.points[None] - camera[:, None, :3, 3])
    pixels = Y @ truth.camera_matrix.T
    pixels = pixels[..., :2] / pixels[..., 2:] + rng.normal(0, 0.1, (*Y.shape[:2], 2))
    pixels[((pixels < 0) | (pixels > (639, 479))).any(axis=2)] = np.nan
    turns = Rotation.from_rotvec(np.radians(0.005) * rng.normal(size=(TAKEN, 3))).as_matrix()
    reported = turns @ stops[:, :3, :3], stops[:, :3, 3] + 2e-5 * rng.normal(size=(TAKEN, 3))
    told = settings()
    found = cah.refineHandEye(
        *reported, pixels, told.camera_matrix, None, told.T_cam2gripper[:3, :3], told.T_cam2gripper[:3, 3], None,
        params=told.refine_params(),
    )  # fmt: skip
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = found[3], np.ravel(found[4])
    points = np.asarray(found[6].scenePoints)
    known = replace(truth, camera_matrix=found[1], T_cam2gripper=T, points=points[np.isfinite(points).all(axis=1)])
    stated = 1000 * float(np.sqrt(np.sum(np.ravel(found[6].standardDeviations)[13:16] ** 2)))
    assert predict(list(stops), known).t_cam2gripper_mm == pytest.approx(stated, rel=0.1)
    after, best = (
        predict(poses(improve_plan(plan, TAKEN, what, settings(stops=STOPS))), truth).t_cam2gripper_mm
        for what in (known, truth)
    )
    assert after == pytest.approx(best, rel=0.05)


def test_knowledge_of_a_calibration_is_what_it_found(tmp_path: Path) -> None:
    dataset = noisy_dataset(tmp_path / "set")
    calibration, evidence = calibrate_with_evidence(dataset, known_distortion())
    assert evidence.summary is not None
    known = Knowledge.learned(calibration, evidence.summary, start(None), settings(lens_model="k3"))
    np.testing.assert_array_equal(known.camera_matrix, calibration.camera_matrix)
    np.testing.assert_array_equal(known.T_cam2gripper[:3, 3], calibration.t_cam2gripper)
    assert known.params.pointSigma == evidence.summary.pointSigma
    assert known.params.robotTranslationSigma == evidence.summary.robotTranslationSigma
    assert len(known.points) == np.isfinite(np.asarray(evidence.summary.scenePoints)).all(axis=1).sum()
    assert known.params.lensModel == cah.LENS_FIXED, "the distortion was given"


def test_number_of_stops_taken_has_to_be_one_of_the_plan(plan: Plan, truth: Knowledge) -> None:
    for taken in (0, STOPS + 1):
        with pytest.raises(ValueError, match=f"taken: needs 1 to the plan's {STOPS} stops, given {taken}"):
            improve_plan(plan, taken, truth, settings(stops=STOPS))
