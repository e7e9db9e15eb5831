# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A plan says after reading what it said before writing, and a changed one is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.scripted_robot import BOX

from cv_active_handeye.files import FileFormatError
from cv_active_handeye.plan_file import Plan, PlannedPose, PlannedStop


def some_plan() -> Plan:
    rng = np.random.default_rng(3)
    poses = [(R.as_matrix(), rng.normal(size=3)) for R in Rotation.random(4, random_state=rng)]
    stops = [
        PlannedStop(R_gripper2base=R, t_gripper2base=t, group=i // 2, laser=i > 0) for i, (R, t) in enumerate(poses)
    ]
    start = PlannedPose(R_gripper2base=poses[0][0], t_gripper2base=poses[0][1])
    return Plan(robot="scripted", model=None, start=start, workspace=BOX, stops=tuple(stops))


def test_plan_survives_the_file(tmp_path: Path) -> None:
    plan = some_plan()
    plan.save(tmp_path / "plan.yaml")
    read = Plan.load(tmp_path / "plan.yaml")
    assert read.sha256() == plan.sha256()
    assert read.workspace == plan.workspace
    for a, b in zip(read.stops, plan.stops, strict=True):
        np.testing.assert_array_equal(a.T_gripper2base, b.T_gripper2base)
        assert (a.group, a.laser) == (b.group, b.laser)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("group: 1", "group: 0"),
        ("laser: false", "laser: true"),
        ("upper_mm: [500.0, 500.0, 500.0]", "upper_mm: [500.0, 500.0, 900.0]"),
        ("max_step_mm: 100.0", "max_step_mm: 400.0"),
        ("sha256: ", "sha256: 0"),
    ],
)
def test_plan_that_was_changed_is_refused(tmp_path: Path, old: str, new: str) -> None:
    path = tmp_path / "plan.yaml"
    some_plan().save(path)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(FileFormatError, match="'sha256': the plan was changed since it was made"):
        Plan.load(path)


def test_plan_without_hash_or_of_another_version_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "plan.yaml"
    some_plan().save(path)
    text = path.read_text()
    path.write_text(text[: text.index("sha256")])
    with pytest.raises(FileFormatError, match="sha256"):
        Plan.load(path)
    path.write_text(text.replace("schema_version: 1", "schema_version: 7"))
    with pytest.raises(FileFormatError, match="reads version 1 of the plan file, the file says 7"):
        Plan.load(path)


def test_mirrored_pose_is_refused() -> None:
    with pytest.raises(ValueError, match="determinant is -1"):
        PlannedPose(R_gripper2base=np.diag([1.0, 1.0, -1.0]), t_gripper2base=np.zeros(3))
