# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Recording a planned motion: move, come to rest, take images between two readings of the pose, store, go on.

Every view is on disk before the next move begins, so whatever ends a capture, what was taken is there, and `resume`
goes on behind it.
"""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from pydantic import BaseModel, ConfigDict, Field

from ..cameras.base import Camera, CameraError, Frame
from ..cameras.laser_switch import LaserSwitch
from ..dataset import Dataset
from ..dataset_format import LaserInfo
from ..plan_file import Plan, PlannedStop
from ..robots.base import RobotPose
from ..robots.guard import GuardedRobot
from .event_log import EventLog
from .reporter import Reporter
from .settle import SettleSettings, differs, settle

PLAN_NAME = "plan.yaml"

Improve = Callable[[Dataset, Plan], Plan | None]
"""Called after each group with what was taken; returns the plan to go on with, None = enough was taken."""


class CaptureError(RuntimeError):
    """A capture that ended early for another reason than the robot; the text says what is safe and how to go on."""


class CaptureSettings(BaseModel):
    """settle: what standing still means. attempts: images of a stop taken again where the arm moved meanwhile.

    least_free_mb: disk space that must be free before the first move, beside what the images of the plan need.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    settle: SettleSettings = SettleSettings()
    attempts: int = Field(default=3, ge=1, le=20)
    least_free_mb: float = Field(default=100.0, ge=0)


@dataclass(frozen=True)
class Station:
    """What stands there: a guarded robot, a camera, the switch of the laser, and how its stripe lies in the image."""

    robot: GuardedRobot
    camera: Camera
    laser: LaserSwitch
    laser_info: LaserInfo = field(default_factory=LaserInfo)


class Capture:
    """One capture into one data set folder."""

    def __init__(
        self, station: Station, folder: Path, log: EventLog, settings: CaptureSettings, reporter: Reporter
    ) -> None:
        """Nothing moves and nothing is written before `run`."""
        self._station, self._folder, self._log = station, folder, log
        self._settings, self._reporter = settings, reporter

    def run(self, plan: Plan, dataset: Dataset, improve: Improve | None = None) -> Dataset:
        """Takes the stops of `plan` that `dataset` does not hold yet, one view a stop, in order.

        improve: asked after each group of stops. Raises RobotStoppedError, MoveRefusedError, CameraError, CaptureError;
        in every case the views taken so far are on disk.
        """
        self._check_disk(plan, len(dataset))
        progress = self._reporter.step("taking the stops")
        progress(len(dataset), len(plan.stops))
        while len(dataset) < len(plan.stops):
            self._take(plan.stops[len(dataset)], dataset)
            progress(len(dataset), len(plan.stops))
            if improve is not None and _group_ends(plan, len(dataset)):
                better = self._improved(improve(dataset, plan), plan, dataset)
                if better is None:
                    break
                plan = better
        self._log("captured", views=len(dataset))
        return dataset

    def _take(self, stop: PlannedStop, dataset: Dataset) -> None:
        """One stop: nothing else moves until its view is stored."""
        self._log.check()
        self._log("stop", view=len(dataset))
        self._station.robot.move_to(stop.T_gripper2base)
        for attempt in range(1, self._settings.attempts + 1):
            pose = settle(self._station.robot, stop.T_gripper2base, self._settings.settle)
            frame, laser_frame = self._expose(stop.laser)
            moved = differs(pose, self._station.robot.pose(), self._settings.settle)
            if not moved:
                self._store(dataset, pose, frame, laser_frame)
                return
            self._log("rejected", view=len(dataset), attempt=attempt, text=f"poses before and after are {moved}")
        raise CaptureError(
            f"view {len(dataset)}: the arm moved during {self._settings.attempts} exposures in a row (poses before and "
            f"after the last one are {moved}); what shakes it?"
        )

    def _expose(self, with_laser: bool) -> tuple[Frame, Frame | None]:
        camera, laser = self._station.camera, self._station.laser
        laser.switch(False)
        frame = camera.grab()
        if not (with_laser and laser.present):
            return frame, None
        laser.switch(True)
        try:
            return frame, camera.grab()
        finally:
            laser.switch(False)

    def _store(self, dataset: Dataset, pose: RobotPose, frame: Frame, laser_frame: Frame | None) -> None:
        R, t = pose.T_gripper2base[:3, :3], pose.T_gripper2base[:3, 3]
        laser_image = None if laser_frame is None else laser_frame.image
        index = len(dataset)
        try:
            dataset.add_view(R, t, image=frame.image, laser_image=laser_image, timestamp=time.time())
        except OSError as error:
            raise CaptureError(
                f"view {index} could not be written: {error.strerror or error}; {safe_text(index)}"
            ) from error
        except ValueError as error:
            raise CameraError(f"{self._station.camera.info.name}: {error}") from error
        self._log("stored", view=index, controller_time=pose.controller_time)

    def _improved(self, plan: Plan | None, before: Plan, dataset: Dataset) -> Plan | None:
        taken = len(dataset)
        if plan is None:
            self._reporter.note(f"the target is met after {taken} stops")
            self._log("target_met", views=taken)
            dataset.set_planned_views(taken)
            return None
        if plan.sha256() != before.sha256():
            if len(plan.stops) < taken or _differ(plan, before, taken):
                raise ValueError("plan: an improved plan needs the stops that were taken already, in their order")
            plan.save(self._folder / PLAN_NAME)
            dataset.set_planned_views(len(plan.stops))
            self._log("plan", sha256=plan.sha256(), stops=len(plan.stops))
        return plan

    def _check_disk(self, plan: Plan, taken: int) -> None:
        info = self._station.camera.info
        pixel = (2 if info.pixel_format.endswith("16") else 1) * (3 if info.pixel_format.startswith("bgr") else 1)
        images = sum(1 + stop.laser for stop in plan.stops[taken:])
        need = images * info.width * info.height * pixel / 1e6 + self._settings.least_free_mb
        free = shutil.disk_usage(self._folder).free / 1e6
        if free < need:
            raise CaptureError(f"{self._folder}: {images} images may need {need:.0f} MB, {free:.0f} MB are free")


def begin(folder: Path, plan: Plan, station: Station) -> Dataset:
    """Starts a data set with a copy of its plan; FileExistsError where the folder holds one already."""
    dataset = Dataset.create(
        folder,
        camera=station.camera.info,
        laser=station.laser_info if station.laser.present else None,
        description=station.robot.robot.name,
        planned_views=len(plan.stops),
    )
    plan.save(folder / PLAN_NAME)
    return dataset


def safe_text(views: int) -> str:
    """What is on disk and how to go on, for messages."""
    taken = "no view was taken yet" if views == 0 else f"{views} views are safe on disk"
    return f"{taken}; --resume goes on behind them"


def _group_ends(plan: Plan, taken: int) -> bool:
    return taken == len(plan.stops) or plan.stops[taken].group != plan.stops[taken - 1].group


def _differ(a: Plan, b: Plan, taken: int) -> bool:
    pairs = zip(a.stops[:taken], b.stops[:taken], strict=True)
    return any((one.T_gripper2base != other.T_gripper2base).any() for one, other in pairs)
