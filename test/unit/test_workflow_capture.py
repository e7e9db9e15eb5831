# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What was taken is on disk whatever happens next, belongs to the pose it was taken at, and is gone on from."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from support.recordings import Notes
from support.scripted_camera import ScriptedCamera
from support.scripted_robot import BOX, ScriptedRobot, at

from cv_active_handeye.cameras.base import CameraError
from cv_active_handeye.cameras.laser_switch import CameraLineConfig, NoLaserConfig, laser_switch
from cv_active_handeye.dataset import Dataset
from cv_active_handeye.files import FileFormatError
from cv_active_handeye.plan_file import Plan, PlannedPose, PlannedStop
from cv_active_handeye.robots.base import MoveRefusedError, RobotStoppedError, Speed, StopReason
from cv_active_handeye.robots.guard import GuardedRobot
from cv_active_handeye.workflow.capture import CaptureError, CaptureSettings, Improve, Station
from cv_active_handeye.workflow.event_log import EventLog, read_events
from cv_active_handeye.workflow.resume import image_shift
from cv_active_handeye.workflow.run import record
from cv_active_handeye.workflow.settle import SettleSettings

QUICK = CaptureSettings(settle=SettleSettings(dwell_s=0.0, poses=2, deadline_s=0.3), least_free_mb=1)
PLACES = (10, 20, 30, 40, 55, 70)


def some_plan(places: tuple[int, ...] = PLACES) -> Plan:
    ts = [at(x)[:3, 3] for x in places]
    stops = [PlannedStop(R_gripper2base=np.eye(3), t_gripper2base=t, group=i // 3) for i, t in enumerate(ts)]
    start = PlannedPose(R_gripper2base=np.eye(3), t_gripper2base=np.zeros(3))
    return Plan(robot="scripted", model=None, start=start, workspace=BOX, stops=tuple(stops))


class Cell:
    """A scripted robot, camera and laser, and a data set folder."""

    def __init__(self, folder: Path, laser: bool = True) -> None:
        self.folder, self.notes = folder, Notes()
        self.robot = ScriptedRobot()
        self.camera = ScriptedCamera(self.robot)
        self.laser_config = CameraLineConfig(settle_s=0) if laser else NoLaserConfig()

    @contextmanager
    def station(self) -> Iterator[Station]:
        self.log = EventLog(self.folder.with_suffix(".jsonl"))
        with GuardedRobot(self.robot, BOX, Speed(), self.log) as guard:
            switch = laser_switch(self.laser_config, self.camera, self.robot, lambda text: None)
            with switch, self.log:
                yield Station(guard, self.camera, switch)

    def record(self, plan: Plan | None = None, improve: Improve | None = None) -> Dataset:
        with self.station() as station:
            return record(self.folder, plan or some_plan(), station, QUICK, self.log, self.notes, improve)


def test_capture_stores_a_view_for_every_stop_with_its_pose_and_both_images(tmp_path: Path) -> None:
    cell = Cell(tmp_path / "set")
    cell.record()
    read = Dataset.open(tmp_path / "set")
    assert read.problems() == []
    assert len(read) == len(PLACES)
    np.testing.assert_allclose(1000 * read.t_gripper2base[:, 0], PLACES, atol=1e-9)
    for view, x in enumerate(PLACES):
        cell.robot.T, cell.camera.laser = at(x), False
        image, laser_image = read.image(view), read.laser_image(view)
        np.testing.assert_array_equal(image, cell.camera.grab().image)
        assert image is not None
        assert laser_image is not None
        assert abs(float(np.mean(laser_image.astype(float) - image)) - 50) < 1
    assert not cell.camera.laser
    kinds = [event["event"] for event in read_events(tmp_path / "set.jsonl")]
    assert kinds.count("stored") == len(PLACES)
    assert [kind for kind in kinds if kind in ("move", "stored")] == ["move", "stored"] * len(PLACES)


def test_station_without_a_laser_takes_one_image_a_stop(tmp_path: Path) -> None:
    cell = Cell(tmp_path / "set", laser=False)
    dataset = cell.record()
    assert cell.camera.grabbed == len(PLACES)
    assert all(view.laser_image is None for view in dataset.views)
    assert dataset.laser is None


def fail_at(call: int, error: BaseException) -> Iterator[None]:
    for _ in range(call):
        yield
    raise error


@pytest.mark.parametrize("where", ["move", "grab"])
@pytest.mark.parametrize(
    "error",
    [
        RobotStoppedError(StopReason.PROTECTIVE_STOP, "touched something"),
        CameraError("scripted: no frame"),
        KeyboardInterrupt(),
        ValueError("a bug"),
    ],
)
def test_whatever_ends_a_capture_what_was_taken_is_there_and_resume_goes_on(
    tmp_path: Path, where: str, error: BaseException
) -> None:
    cell = Cell(tmp_path / "set")
    calls = fail_at(7 if where == "grab" else 3, error)
    setattr(cell.robot if where == "move" else cell.camera, f"on_{where}", lambda: next(calls))
    with pytest.raises(type(error)):
        cell.record()
    taken = len(Dataset.open(tmp_path / "set"))
    assert taken == 3
    assert not cell.camera.laser
    assert cell.robot.calls[-1] == "close"

    again = Cell(tmp_path / "set")
    again.robot.T = cell.robot.T
    dataset = again.record()
    assert [note for note in again.notes.notes if "going on with view 3 of 6" in note]
    np.testing.assert_allclose(1000 * dataset.t_gripper2base[:, 0], PLACES, atol=1e-9)
    assert Dataset.open(tmp_path / "set").problems() == []


def test_nothing_moves_after_a_stop(tmp_path: Path) -> None:
    cell = Cell(tmp_path / "set")
    calls = fail_at(2, RobotStoppedError(StopReason.EMERGENCY_STOP, "pressed"))
    cell.robot.on_move = lambda: next(calls)
    with pytest.raises(RobotStoppedError, match="emergency stop: pressed"):
        cell.record()
    assert cell.robot.calls.count("move_linear") == 3
    after = cell.robot.calls[len(cell.robot.calls) - cell.robot.calls[::-1].index("move_linear") :]
    assert set(after) == {"stop", "close"}
    events = read_events(tmp_path / "set.jsonl")
    assert events[-1]["event"] == "stop_condition"
    assert events[-1]["reason"] == "emergency stop"


def test_full_disk_loses_the_view_in_hand_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cell = Cell(tmp_path / "set")
    write = os.fsync

    def fsync(file: int) -> None:
        if cell.camera.grabbed >= 5:
            raise OSError(errno.ENOSPC, "No space left on device")
        write(file)

    monkeypatch.setattr(os, "fsync", fsync)
    with pytest.raises(CaptureError, match="view 2 could not be written: No space left on device; 2 views are safe"):
        cell.record()
    monkeypatch.undo()
    assert len(Dataset.open(tmp_path / "set")) == 2
    assert len(Cell(tmp_path / "set").record()) == len(PLACES)


def test_too_little_space_is_told_before_anything_moves(tmp_path: Path) -> None:
    cell = Cell(tmp_path / "set")
    greedy = QUICK.model_copy(update={"least_free_mb": 1e12})
    with cell.station() as station, pytest.raises(CaptureError, match=r"12 images may need .* MB, .* MB are free"):
        record(cell.folder, some_plan(), station, greedy, cell.log, cell.notes)
    assert cell.robot.targets == []


def test_frame_of_an_arm_that_moved_meanwhile_is_taken_again_and_has_the_new_pose(tmp_path: Path) -> None:
    cell = Cell(tmp_path / "set", laser=False)
    pushes = iter([at(10.03)])
    cell.camera.on_grab = lambda: setattr(cell.robot, "T", next(pushes, cell.robot.T))
    dataset = cell.record()
    np.testing.assert_allclose(1000 * dataset.t_gripper2base[:, 0], [10.03, *PLACES[1:]], atol=1e-9)
    rejected = [event for event in read_events(tmp_path / "set.jsonl") if event["event"] == "rejected"]
    assert [(event["view"], event["attempt"]) for event in rejected] == [(0, 1)]
    assert rejected[0]["text"] == "poses before and after are 0.030 mm and 0.0000 deg apart"


def test_arm_that_moves_during_every_exposure_ends_the_capture(tmp_path: Path) -> None:
    cell = Cell(tmp_path / "set", laser=False)
    cell.camera.on_grab = lambda: setattr(cell.robot, "T", at(10.03 - 0.03 * (cell.camera.grabbed % 2)))
    with pytest.raises(CaptureError, match=r"view 0: the arm moved during 3 exposures in a row .* 0.030 mm"):
        cell.record()
    assert len(Dataset.open(tmp_path / "set")) == 0


def test_whole_plan_is_checked_before_the_first_move(tmp_path: Path) -> None:
    cell = Cell(tmp_path / "set")
    with pytest.raises(MoveRefusedError, match=r"stop 2 of 3: workspace: the flange would be at \(50[0-9], 0, 0\)"):
        cell.record(some_plan((10, 20, 600)))
    assert cell.robot.targets == []
    assert not (tmp_path / "set").exists()


def test_resume_refuses_a_scene_that_moved(tmp_path: Path) -> None:
    cell = Cell(tmp_path / "set")
    calls = fail_at(3, CameraError("no frame"))
    cell.robot.on_move = lambda: next(calls)
    with pytest.raises(CameraError):
        cell.record()
    again = Cell(tmp_path / "set")
    again.camera.shift_px = 6
    with pytest.raises(CaptureError, match=r"at the stop of view 2 the image is [56]\.[0-9] px away"):
        again.record()
    assert len(Dataset.open(tmp_path / "set")) == 3


@pytest.mark.parametrize(("shift", "seen"), [(0.0, 0.0), (0.5, 0.5), (3.0, 3.0), (6.0, 6.0)])
def test_image_shift_is_found(shift: float, seen: float) -> None:
    camera = ScriptedCamera(ScriptedRobot())
    before = camera.grab().image
    camera.shift_px = shift
    assert image_shift(before, camera.grab().image) == pytest.approx(seen, abs=0.3)


def test_images_without_anything_in_common_have_no_shift() -> None:
    rng = np.random.default_rng(2)
    a, b = rng.integers(0, 255, (2, 64, 96), dtype=np.uint8)
    assert image_shift(a, b) == float("inf")


def test_resume_refuses_another_robot_camera_or_plan(tmp_path: Path) -> None:
    Cell(tmp_path / "set").record()
    plan = Plan.load(tmp_path / "set" / "plan.yaml")
    other = Cell(tmp_path / "set")
    other.robot.name = "another"
    with pytest.raises(FileFormatError, match="was taken with scripted, this is another"):
        other.record()
    other = Cell(tmp_path / "set")
    other.camera.info = other.camera.info.model_copy(update={"width": 95})
    with pytest.raises(FileFormatError, match=r"was taken with 96 x 64 mono8, the camera gives 95 x 64 mono8"):
        other.record()
    some_plan((10, 20, 31, 40, 55, 70)).save(tmp_path / "set" / "plan.yaml")
    with pytest.raises(FileFormatError, match=r"view 2: its pose is 1.000 mm and 0.0000 deg from its stop"):
        Cell(tmp_path / "set").record()
    plan.model_copy(update={"stops": plan.stops[:4]}).save(tmp_path / "set" / "plan.yaml")
    with pytest.raises(FileFormatError, match="holds 6 views, its plan has 4 stops"):
        Cell(tmp_path / "set").record()


def test_improved_plan_is_followed_and_kept_beside_the_views(tmp_path: Path) -> None:
    asked: list[int] = []

    def improve(dataset: Dataset, plan: Plan) -> Plan | None:
        asked.append(len(dataset))
        return some_plan((10, 20, 30, 90, 95)) if len(dataset) == 3 else None

    cell = Cell(tmp_path / "set")
    dataset = cell.record(improve=improve)
    assert asked == [3, 5]
    np.testing.assert_allclose(1000 * dataset.t_gripper2base[:, 0], [10, 20, 30, 90, 95], atol=1e-9)
    assert Dataset.open(tmp_path / "set").problems() == []
    assert Plan.load(tmp_path / "set" / "plan.yaml").sha256() == some_plan((10, 20, 30, 90, 95)).sha256()


def test_target_that_is_met_ends_the_capture(tmp_path: Path) -> None:
    cell = Cell(tmp_path / "set")
    dataset = cell.record(improve=lambda dataset, plan: None)
    assert len(dataset) == 3
    assert Dataset.open(tmp_path / "set").problems() == []
    assert "the target is met after 3 stops" in cell.notes.notes


def test_improved_plan_that_forgets_what_was_taken_is_refused(tmp_path: Path) -> None:
    cell = Cell(tmp_path / "set")
    with pytest.raises(ValueError, match="needs the stops that were taken already"):
        cell.record(improve=lambda dataset, plan: some_plan((11, 20, 30, 90)))
