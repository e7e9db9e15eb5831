# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The emulated arm in this process, without any network: to try a plan, and for tests of what comes after the robot."""

from __future__ import annotations

import threading
import time
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from .base import Array, MoveRefusedError, RobotError, RobotPose, RobotStoppedError, Speed, StopReason
from .straight_move import StraightMove

if TYPE_CHECKING:
    from ..simulation.emulators import EmulatedArm

_REASONS = {"protective stop": StopReason.PROTECTIVE_STOP, "emergency stop": StopReason.EMERGENCY_STOP}


class SimulatedRobotConfig(BaseModel):
    """An arm of the simulated cell. seed: that of the cell and of the arm's errors; speedup: faster than a real arm."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    type: Literal["sim"] = "sim"
    robot: Literal["denso_vp6242", "ur5e"] = "denso_vp6242"
    seed: int = Field(default=0, ge=0)
    speedup: float = Field(default=1.0, ge=0.1, le=1000)
    log: Path | None = None


class SimulatedRobot:
    """An `EmulatedArm` as a `base.Robot`; `arm` is what a simulated camera looks at.

    Every call returns at once, but a move, which takes its time divided by the speed-up.
    """

    def __init__(self, arm: EmulatedArm, live: bool) -> None:
        """Use `connect`, or give an arm of your own."""
        self.arm = arm
        self.name = f"simulated {arm.arm.name}"
        self.model: str | None = arm.cell.robot
        self.live = live
        self._cancel = threading.Event()
        self._stopped: RobotStoppedError | None = None

    def pose(self) -> RobotPose:
        """Returns what the controller would say."""
        return RobotPose(self.arm.reported_pose(), self.arm.joints, self.arm.now, time.monotonic())

    def check_reachable(self, T_gripper2base: Array) -> None:
        """MoveRefusedError where the arm cannot take a pose (4, 4)."""
        if not self.arm.reachable(np.asarray(T_gripper2base, dtype=np.float64)):
            raise MoveRefusedError(f"{self.name}: the pose is out of the arm's reach, limits or good positions")

    def move_linear(self, T_gripper2base: Array, speed: Speed) -> None:
        """See `base.Robot.move_linear`; the arm's own faults end it as those of a controller do."""
        from ..simulation.emulators import EmulatorStop

        if not self.live:
            raise MoveRefusedError(f"{self.name}: was not opened to be moved (live)")
        if self._stopped is not None:
            raise self._stopped
        target = np.asarray(T_gripper2base, dtype=np.float64)
        try:
            self.arm.move_linear(target, speed.metres_per_second, speed.metres_per_second2, self._cancel)
        except EmulatorStop as stop:
            if stop.reason == "unreachable":
                raise MoveRefusedError(f"{self.name}: {stop}") from stop
            raise self._latched(_REASONS.get(stop.reason, StopReason.OPERATOR), str(stop)) from stop
        except BaseException:
            self.stop()
            raise
        left = StraightMove(target, target).remaining(self.arm.reported_pose())
        if left is not None:
            raise self._latched(StopReason.NOT_ARRIVED, f"the motion is over {left}")

    def is_steady(self) -> bool:
        """Whether the arm has come to rest."""
        return self.arm.steady()

    def stop(self) -> None:
        """Stops the arm; after it the robot has to be connected anew."""
        self._latched(StopReason.OPERATOR, "a stop was asked for")
        self._cancel.set()

    def set_output(self, pin: int, on: bool) -> None:
        """Switches a digital output (0 to 7)."""
        try:
            self.arm.set_output(pin, on)
        except ValueError as error:
            raise RobotError(f"{self.name}: {error}") from error

    def close(self) -> None:
        """Stops the arm."""
        self.stop()
        self.arm.close()
        self.arm.log.close()

    def __enter__(self) -> SimulatedRobot:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _latched(self, reason: StopReason, text: str) -> RobotStoppedError:
        if self._stopped is None:
            self._stopped = RobotStoppedError(reason, f"{self.name}: {text}")
        return self._stopped


def connect(config: SimulatedRobotConfig, *, live: bool) -> SimulatedRobot:
    """Starts an arm over the simulated cell's workbench; needs the extra `sim`."""
    from ..simulation import CellConfig
    from ..simulation.emulators import EmulatedArm, EventLog

    cell = CellConfig(robot=config.robot, seed=config.seed)
    return SimulatedRobot(EmulatedArm(cell, speedup=config.speedup, log=EventLog(config.log)), live)
