# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Plans keep boxes and joint limits all along their ways, choose the number of stops, and name what is in the way."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.spatial.transform import Rotation, Slerp
from support.calibrations import refined
from support.planning_cell import JOINTS, TOOL_MM, Array, flange, joints_near, settings, smallest_singular_value, start

import cv_active_handeye as cah
from cv_active_handeye.plan_file import Plan
from cv_active_handeye.robots import kinematics
from cv_active_handeye.robots.base import Robot, RobotPose
from cv_active_handeye.robots.workspace import Box, Workspace
from cv_active_handeye.workflow import InsufficientDataError
from cv_active_handeye.workflow.plan import fewest, make_plan, target_met
from cv_active_handeye.workflow.plan_knowledge import Knowledge, predict
from cv_active_handeye.workflow.plan_order import motor_seconds, order_stops
from cv_active_handeye.workflow.plan_settings import PlanSettings
from cv_active_handeye.workflow.plan_views import Start, flange_pose, start_of


@pytest.fixture(scope="module")
def plan() -> Plan:
    return make_plan(start(), settings())


def samples(plan: Plan) -> list[Array]:
    """Flange poses along all straight ways of a plan, not at the places where the planner looks."""
    found = []
    poses = [plan.start.T_gripper2base, *(stop.T_gripper2base for stop in plan.stops)]
    for a, b in pairwise(poses):
        turns = Slerp([0, 1], Rotation.from_matrix(np.stack([a[:3, :3], b[:3, :3]])))
        for s in np.linspace(0, 1, 15):
            T = np.eye(4)
            T[:3, :3], T[:3, 3] = turns(s).as_matrix(), (1 - s) * a[:3, 3] + s * b[:3, 3]
            found.append(T)
    return found


def test_plan_keeps_boxes_limits_and_singularities_all_along_its_ways(plan: Plan) -> None:
    workspace, q = plan.workspace, JOINTS
    for T in samples(plan):
        points = 1000 * (np.vstack([np.zeros(3), np.array(TOOL_MM) / 1000]) @ T[:3, :3].T + T[:3, 3])
        assert (points >= workspace.box.lower_mm).all()
        assert (points <= workspace.box.upper_mm).all()
        assert (points[:, 2] > workspace.no_go[0].upper_mm[2]).all()
        moved = joints_near(T, q)
        assert np.abs(moved - q).max() < 1
        q = moved
        assert np.abs(q).max() < np.radians(357)
        assert smallest_singular_value(q) > 0.039


def test_plan_holds_two_groups_of_translations_that_stay_together_and_turns(plan: Plan) -> None:
    groups = [stop.group for stop in plan.stops]
    assert len(groups) == 12
    counts = [groups.count(group) for group in set(groups)]
    assert sum(count >= 4 for count in counts) >= 2
    # a stop that only another orientation leads to may stand between those of a group
    assert sum(a != b for a, b in pairwise(groups)) <= len(counts) + 1
    rotations = np.array([stop.R_gripper2base for stop in plan.stops])
    assert cah.groupViews(rotations).reshape(-1).tolist() == groups


def test_predictions_of_a_plan_fall_with_every_stop_and_end_with_that_of_all(plan: Plan) -> None:
    assert [p.stops for p in plan.predictions] == list(range(2, 13))
    assert plan.predictions[0].t_cam2gripper_mm is None
    sigmas = [p.t_cam2gripper_mm for p in plan.predictions if p.t_cam2gripper_mm is not None]
    assert all(after < before for before, after in pairwise(sigmas))
    poses = [stop.T_gripper2base for stop in plan.stops]
    assert plan.predictions[-1] == predict(poses, Knowledge.assumed(start(), settings()))


def test_same_seed_gives_the_same_plan_and_its_file_says_the_same(plan: Plan, tmp_path: Path) -> None:
    one, same, other = (make_plan(start(None), settings(seed=seed)) for seed in (3, 3, 4))
    assert one.sha256() == same.sha256() != other.sha256()
    plan.save(tmp_path / "plan.yaml")
    assert Plan.load(tmp_path / "plan.yaml").sha256() == plan.sha256()


def test_target_sigma_takes_the_fewest_stops_that_reach_it() -> None:
    asked = settings(stops=None, target_sigma_mm=0.1, most_stops=16)
    made = make_plan(start(None), asked)
    assert made.predictions[-1].t_cam2gripper_mm is not None
    assert made.predictions[-1].t_cam2gripper_mm <= 0.1
    fewer = make_plan(start(None), settings(stops=len(made.stops) - 1)).predictions[-1].t_cam2gripper_mm
    assert fewer is not None
    assert fewer > 0.1


def test_target_out_of_reach_says_what_is_reached() -> None:
    with pytest.raises(InsufficientDataError, match=r"target_sigma_mm: 0.01 mm is out of reach; 14 stops .* 0\.\d+ mm"):
        make_plan(start(None), settings(stops=None, target_sigma_mm=0.01, most_stops=14))


def test_known_camera_needs_less() -> None:
    known = make_plan(start(None), settings(stops=6, camera_known=True))
    assert known.predictions[-1].fx_percent == 0
    assert known.predictions[-1].t_cam2gripper_mm is not None


def test_lens_to_be_estimated_makes_the_focal_length_less_certain(plan: Plan) -> None:
    poses = [stop.T_gripper2base for stop in plan.stops]
    pinhole, distorted = (
        predict(poses, Knowledge.assumed(start(), settings(lens_model=lens))).fx_percent for lens in ("none", "k3")
    )
    assert pinhole is not None
    assert distorted is not None
    assert distorted > 1.02 * pinhole


def test_light_plane_is_predicted_where_there_is_a_laser() -> None:
    made = make_plan(start(None), settings(light_plane_mm=(0.0, -0.98, 0.19, 100.0)))
    light = made.predictions[-1].light_plane_mm
    assert light is not None
    assert 0 < light < 1
    assert all(stop.laser for stop in made.stops)


def small_box(half: float) -> Workspace:
    middle = 1000 * flange(JOINTS)[:3, 3]
    return Workspace(box=Box(lower_mm=tuple(middle - half), upper_mm=tuple(middle + half)))


def test_box_too_small_is_named_with_numbers() -> None:
    with pytest.raises(InsufficientDataError) as told:
        make_plan(start(), settings(workspace=small_box(30)))
    text = str(told.value)
    assert "views are possible: of 858 views looked at 85" in text
    assert "by the boxes (workspace: the flange would be at (" in text


def test_views_behind_a_wall_are_left_out_and_others_chosen() -> None:
    middle = 1000 * flange(JOINTS)[:3, 3]
    wall = Box(lower_mm=(middle[0] + 90, -2000, -2000), upper_mm=(middle[0] + 95, 2000, 2000))
    free = settings(stops=10).workspace
    made = make_plan(start(None), settings(stops=10, workspace=Workspace(box=free.box, no_go=(*free.no_go, wall))))
    assert len(made.stops) == 10
    assert max(1000 * stop.t_gripper2base[0] for stop in made.stops) < middle[0] + 90


def test_start_outside_of_the_box_is_refused() -> None:
    outside = Workspace(box=Box(lower_mm=(0, 0, 0), upper_mm=(100, 100, 100)))
    with pytest.raises(InsufficientDataError, match="start pose itself is not allowed: workspace: the flange would be"):
        make_plan(start(), settings(workspace=outside))


def test_views_that_see_too_little_are_not_chosen() -> None:
    with pytest.raises(InsufficientDataError, match="which see enough of the scene, hold"):
        make_plan(start(None), settings(seen_share=0.95))


def test_joint_limit_in_the_way_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    narrow = replace(kinematics.ARMS["ur5e"], lower=tuple(JOINTS - np.radians(5)), upper=tuple(JOINTS + np.radians(5)))
    monkeypatch.setitem(kinematics.ARMS, "ur5e", narrow)
    with pytest.raises(InsufficientDataError, match=r"by the arm \(UR5e: joint \d would be at .* deg; its limits are"):
        make_plan(start(), settings())


def test_settings_that_contradict_each_other_are_refused() -> None:
    for changes, text in (
        ({"field_of_view_deg": 25.0}, "focal_px, field_of_view_deg: needs one of the two, given both"),
        ({"target_sigma_mm": 0.1}, "stops, target_sigma_mm: needs one of the two, given both"),
        ({"robot_mm": 0.0}, "robot_mm, robot_deg"),
        ({"light_plane_mm": (0.0, 0.0, 1.0, -3.0)}, "light_plane_mm: needs d > 0, given -3"),
    ):
        with pytest.raises(ValidationError, match=text):
            settings(**changes)


def test_field_of_view_and_focal_length_say_the_same() -> None:
    by_angle = settings(focal_px=None, field_of_view_deg=float(np.degrees(2 * np.arctan(320 / 1400))))
    np.testing.assert_allclose(by_angle.camera_matrix, settings().camera_matrix, rtol=1e-12)


def test_flange_pose_turns_about_what_the_camera_looks_at() -> None:
    asked, first = settings(), start()
    camera = first.T_gripper2base @ asked.T_cam2gripper
    aim = camera @ np.array([0, 0, 0.55, 1])
    for tilt, roll in (((1.0, 0.0), 0.0), ((0.0, -1.0), 120.0), ((0.7, 0.7), -60.0)):
        turned = flange_pose(first, asked, tilt, roll, np.zeros(3)) @ asked.T_cam2gripper
        np.testing.assert_allclose(turned @ np.array([0, 0, 0.55, 1]), aim, atol=1e-12)
        moved = flange_pose(first, asked, tilt, roll, np.array([1, 0, -1])) @ asked.T_cam2gripper
        np.testing.assert_allclose(moved[:3, 3] - turned[:3, 3], turned[:3, :3] @ [0.08, 0, -0.08], atol=1e-12)


def test_motor_time_of_a_line_a_short_line_and_a_turn() -> None:
    asked, poses = settings(settle_seconds=2.0), [np.eye(4) for _ in range(3)]
    poses[0][0, 3] = 0.1  # 100 mm at 50 mm/s, 0.2 m/s^2
    poses[1][0, 3] = 0.105  # 5 mm: no constant speed
    poses[2][0, 3] = 0.105
    poses[2][:3, :3] = Rotation.from_euler("z", 90, degrees=True).as_matrix()
    expected = (2 + 0.25) + 2 * np.sqrt(0.005 / 0.2) + 90 / 15 + 3 * 2
    assert motor_seconds(np.eye(4), poses, asked) == pytest.approx(expected)


def at(x: float, y: float) -> Array:
    T = np.eye(4)
    T[:2, 3] = x, y
    return T


def free_space(*no_go: Box) -> PlanSettings:
    box = Box(lower_mm=(-1000, -1000, -1000), upper_mm=(1000, 1000, 1000))
    return settings(workspace=Workspace(box=box, no_go=no_go))


def test_groups_come_before_single_stops_and_the_nearest_next() -> None:
    poses = [at(0.01, 0), at(0.3, 0), at(0.1, 0), at(0.2, 0), at(0.5, 0)]
    order = order_stops(Start("", None, at(0, 0)), poses, [0, 1, 1, 1, 2], free_space())
    assert order.visited == [2, 3, 1, 4, 0]
    assert not order.stranded


def test_stop_that_the_last_one_cannot_reach_is_put_in_between() -> None:
    wall = Box(lower_mm=(140, 100, -100), upper_mm=(160, 300, 100))
    poses = [at(0.1, 0), at(0.2, 0.1), at(0.1, 0.3)]
    order = order_stops(Start("", None, at(0, 0)), poses, [0, 1, 2], free_space(wall))
    assert order.visited == [2, 0, 1]


def test_stop_behind_a_wall_is_stranded_with_the_reason() -> None:
    walls = Box(lower_mm=(350, -900, -900), upper_mm=(400, 900, 900))
    order = order_stops(Start("", None, at(0, 0)), [at(0.1, 0), at(0.5, 0)], [0, 1], free_space(walls))
    assert (order.visited, order.stranded) == ([0], [1])
    assert "inside the no-go box" in order.reason


def test_stop_that_the_arm_cannot_reach_is_stranded_with_the_reason() -> None:
    near, far = flange(JOINTS), flange(JOINTS)
    near[:3, 3] += [0.02, 0.0, 0.02]
    far[:3, 3] += [0.0, 0.0, 0.4]
    order = order_stops(start(), [far, near], [0, 1], free_space())
    assert (order.visited, order.stranded) == ([1], [0])
    assert order.reason.startswith("UR5e: ")
    assert order_stops(start(None), [far, near], [0, 1], free_space()).visited == [1, 0]


def test_fewest_finds_the_first_that_suffices() -> None:
    for first in range(4, 12):
        assert fewest(first.__le__, 4, 11) == first


def test_target_is_met_by_the_covariance_of_a_usable_calibration() -> None:
    calibration = refined()
    at_t = [calibration.parameter_names.index(name) for name in ("tx", "ty", "tz")]
    sigma_mm = 1000 * float(np.sqrt(np.diag(calibration.covariance)[at_t].sum()))
    assert target_met(calibration, settings(stops=None, target_sigma_mm=1.01 * sigma_mm))
    assert not target_met(calibration, settings(stops=None, target_sigma_mm=0.99 * sigma_mm))
    assert not target_met(calibration, settings())
    assert calibration.verdict is not None
    doubted = calibration.model_copy(update={"verdict": calibration.verdict.model_copy(update={"usable": False})})
    assert not target_met(doubted, settings(stops=None, target_sigma_mm=1.01 * sigma_mm))


def test_start_of_a_robot_has_joints_where_its_model_is_known() -> None:
    reading = RobotPose(flange(JOINTS), JOINTS, 0.0, 0.0)
    for model in ("ur5e", None):
        robot = SimpleNamespace(name="a robot", model=model, pose=lambda: reading)
        found = start_of(cast(Robot, robot))
        assert (found.robot, found.model) == ("a robot", model)
        np.testing.assert_array_equal(found.T_gripper2base, flange(JOINTS))
        assert (found.joints is None) == (model is None)
