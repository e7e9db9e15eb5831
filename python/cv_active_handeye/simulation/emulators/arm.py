# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""An arm that moves in time: the mechanics behind every emulated controller."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from ...robots import kinematics
from ...robots.base import Array
from ...robots.kinematics import SerialArm, UnreachableError
from ...robots.workspace import step_size
from ..cell import SimulatedCell
from ..config import CellConfig
from ..robot_errors import RobotErrors
from .faults import Faults
from .log import EventLog
from .profile import Profile

OUTPUTS = 8
_KEY = 5  # of the random stream of the arm's errors, beside those of the cell
_SETTLED = 0.5  # s after a motion
_LEVER = 0.25  # m: a turn by 1 rad takes as long as a way of this length
_POLL = 0.002  # s of the wall clock
_BIAS_DIRECTION = np.array([2.0, -1.0, 2.0]) / 3.0


class EmulatorStop(RuntimeError):  # noqa: N818 (not an error of the program: the arm did not do the motion)
    """A motion did not arrive. reason: "cancelled", "protective stop", "emergency stop" or "unreachable"."""

    def __init__(self, reason: str, text: str = "") -> None:
        """`text` says more."""
        super().__init__(f"{reason}: {text}" if text else reason)
        self.reason = reason


@dataclass
class _Motion:
    """Joints (N, 6) at the fractions (N,) of the way, begun at `begun` (arm time, s)."""

    joints: Array
    fractions: Array
    whole: float
    profile: Profile
    begun: float
    done_before: float = 0.0

    def at(self, now: float) -> Array:
        """Joints (6,) at an arm time."""
        way = self.done_before + self.profile.position(now - self.begun)
        fraction = way / self.whole if self.whole > 0 else 1.0
        return np.array([np.interp(fraction, self.fractions, column) for column in self.joints.T])

    def brake(self, now: float, deceleration: float) -> None:
        """Begins to stop."""
        done = self.profile.position(now - self.begun)
        self.profile = self.profile.braked(now - self.begun, deceleration)
        self.done_before += done
        self.begun = now


@dataclass
class _Stand:
    """Where the arm stands: commanded joints (6,), those with servo error, and poses (4, 4) reported and true."""

    commanded: Array
    joints: Array
    reported: Array
    true: Array
    since: float
    index: int


class EmulatedArm:
    """Six axes that obey motion commands in time, with the errors of `RobotErrors`. Thread-safe.

    Times run `speedup` times as fast as the wall clock. A stop condition (protective or emergency stop) keeps it from
    moving until a person clears it. Every motion, output and fault goes into the log.
    """

    def __init__(
        self,
        cell: CellConfig,
        *,
        speedup: float = 1.0,
        log: EventLog,
        start: Array | None = None,
        faults: Faults | None = None,
    ) -> None:
        """`start`: joints (6,), rad; None = where the cell's first stop is. `faults`: None = those of every device."""
        if not 0.1 <= speedup <= 1000:
            raise ValueError(f"speedup: needs 0.1 to 1000, given {speedup:g}")
        self.cell, self.speedup, self.log = cell, speedup, log
        self.arm: SerialArm = kinematics.arm(cell.robot)
        self.outputs = dict.fromkeys(range(OUTPUTS), False)
        self.halt_deceleration = 2.0
        """How hard a motion that is cancelled brakes, m/s^2; a client's stop command may set it."""
        self.stop_condition: str | None = None
        self.clears = 0
        """How many times a person has cleared the controller."""
        self.faults = Faults(log) if faults is None else faults
        self.faults.subscribe(self._fault)
        self._errors = RobotErrors(cell, _KEY)
        self._began = time.monotonic()
        self._lock = threading.RLock()
        self._busy = threading.Lock()
        self._motion: _Motion | None = None
        self._motions = 0
        self._held, self._rendered = False, -1
        self._noise = np.random.default_rng([cell.seed, _KEY, 3])
        joints = self.arm.inverse(SimulatedCell(cell).start()) if start is None else np.asarray(start, dtype=np.float64)
        self._stand = self._standing(joints, 0)
        self._stand.since = -_SETTLED

    @property
    def now(self) -> float:
        """The controller's clock, s since it was switched on."""
        return (time.monotonic() - self._began) * self.speedup

    @property
    def moving(self) -> bool:
        """Whether a motion is under way."""
        return self._motion is not None

    @property
    def stop_index(self) -> int:
        """How many times the arm has come to a stand; 0 at the start. Every stand has errors of its own."""
        return self._stand.index

    @property
    def joints(self) -> Array:
        """What the encoders say (6,), rad."""
        with self._lock:
            return self._stand.joints.copy() if self._motion is None else self._motion.at(self.now)

    def reported_pose(self) -> Array:
        """The flange pose (4, 4) the controller would say."""
        with self._lock:
            pose = self._stand.reported.copy() if self._motion is None else self.arm.forward(self.joints)
            sigma = self.faults.value("pose_noise") / 1000
            if sigma:
                pose[:3, 3] += sigma * self._noise.standard_normal(3)
            return pose

    def true_pose(self) -> Array:
        """The pose (4, 4) the flange really has."""
        with self._lock:
            if self._motion is None:
                pose = self._stand.true.copy()
            else:
                pose = self.arm.forward(self.joints)
                shift, turn = self._errors.absolute(pose[:3, 3])
                pose[:3, 3] += shift
                pose[:3, :3] = Rotation.from_rotvec(turn).as_matrix() @ pose[:3, :3]
            pose[:3, 3] += self.faults.value("pose_bias") / 1000 * _BIAS_DIRECTION
            return pose

    def steady(self) -> bool:
        """Whether the arm has come to rest and a camera feed that holds it has rendered this stop."""
        with self._lock:
            if self._motion is not None or (self._held and self._rendered < self._stand.index):
                return False
            return self.now - self._stand.since >= (self.faults.value("slow_settling") or _SETTLED)

    def hold(self, on: bool) -> None:
        """A camera feed asks, or no longer asks, that the arm counts as steady only after it has rendered."""
        with self._lock:
            self._held = on

    def rendered(self, stop: int) -> None:
        """The camera feed shows what the camera sees at this stop."""
        with self._lock:
            self._rendered = max(self._rendered, stop)

    def reachable(self, T_flange: Array) -> bool:
        """Whether the arm can take a pose (4, 4)."""
        try:
            self.arm.inverse(T_flange, self.joints)
        except UnreachableError:
            return False
        return True

    def move_linear(self, T_flange: Array, speed: float, acceleration: float, cancel: threading.Event) -> None:
        """Moves on a straight line to a pose (4, 4), m/s and m/s^2; returns on arrival, EmulatorStop otherwise.

        The way is checked before it begins. `cancel` brakes with `halt_deceleration`.
        """
        asked = time.monotonic()
        with self._busy:
            start = self._stand.commanded
            self._check_target()
            try:
                joints = self.arm.follow(start, np.asarray(T_flange, dtype=np.float64))
            except ValueError as error:
                raise EmulatorStop("unreachable", str(error)) from error
            length, angle = step_size(self.arm.forward(start), T_flange)
            length = max(length, _LEVER * np.radians(angle))
            self._run(joints, length, speed, acceleration, cancel, asked)

    def move_joints(self, q: Array, speed: float, acceleration: float, cancel: threading.Event) -> None:
        """Moves all joints to q (6,) together, the fastest at rad/s and rad/s^2; otherwise as `move_linear`."""
        asked = time.monotonic()
        with self._busy:
            start, end = self._stand.commanded, np.asarray(q, dtype=np.float64)
            self._check_target()
            if end.shape != (6,) or not np.isfinite(end).all() or (self.arm.limit_margin(end) < 0).any():
                raise EmulatorStop("unreachable", f"{self.arm.name}: joints {end} are not within the limits")
            self._run(np.stack([start, end]), float(np.abs(end - start).max()), speed, acceleration, cancel, asked)

    def set_output(self, pin: int, on: bool) -> None:
        """Switches a digital output; ValueError where there is no such pin."""
        if pin not in self.outputs:
            raise ValueError(f"pin: needs 0 to {OUTPUTS - 1}, given {pin}")
        with self._lock:
            if self.outputs[pin] != on:
                self.outputs[pin] = on
                self.log.add("output", pin=pin, on=on)

    def halt(self, reason: str) -> None:
        """A stop condition: the arm stops and does not move again before `clear`."""
        with self._lock:
            if self.stop_condition is None:
                self.stop_condition = reason
                self.log.add("stop_condition", reason=reason)

    def clear(self) -> None:
        """The person at the pendant clears every stop condition and fault."""
        with self._lock:
            self.stop_condition = None
            self.clears += 1
        self.faults.clear()
        self.log.add("cleared")

    def close(self) -> None:
        """Ends the timers of the faults."""
        self.faults.close()

    def _check_target(self) -> None:
        if self.stop_condition is not None:
            self.log.add("violation", text=f"a motion was asked for after a {self.stop_condition}", refused_motion=True)
            raise EmulatorStop(self.stop_condition, "the arm does not move before a person has cleared it")
        if self.faults.take("unreachable"):
            raise EmulatorStop("unreachable", "the controller finds no joint solution (fault)")

    def _run(
        self, joints: Array, length: float, speed: float, acceleration: float, cancel: threading.Event, asked: float
    ) -> None:
        """Moves along joints (N, 6), equally spaced on a way of `length`; `asked`: when the command came."""
        if speed <= 0 or acceleration <= 0:
            raise EmulatorStop("unreachable", f"speed and acceleration need to be > 0, given {speed}, {acceleration}")
        speed *= self.faults.value("slow_motion") or 1.0
        with self._lock:
            if cancel.is_set() or self.stop_condition is not None:
                raise EmulatorStop(self.stop_condition or "cancelled", "before the motion began")
            self._motions += 1
            profile = Profile.trapezoid(length, speed, acceleration)
            self._motion = _Motion(joints, np.linspace(0, 1, len(joints)), length, profile, self.now)
            self.log.add("motion_begin", motion=self._motions, length_m=length, asked=asked)
        reason = self._wait(self._motion, self._motions, cancel)
        with self._lock:
            end = joints[-1] if reason is None else self._motion.at(self.now)
            self._stand, self._motion = self._standing(end, self._stand.index + 1), None
            self.log.add("motion_end", motion=self._motions, arrived=reason is None, stop=self._stand.index)
        self.faults.reached("stop", self._stand.index)
        if reason is not None:
            raise EmulatorStop(reason)

    def _wait(self, motion: _Motion, number: int, cancel: threading.Event) -> str | None:
        """Lets a motion pass; returns why it was stopped, if it was."""
        reason: str | None = None
        told = False
        while (passed := self.now - motion.begun) < motion.profile.duration:
            if not told and motion.profile.position(passed) >= 0.4 * motion.whole:
                told = True
                self.faults.reached("move", number)
            if reason is None and (cancel.is_set() or self.stop_condition is not None):
                reason = self.stop_condition or "cancelled"
                with self._lock:
                    motion.brake(self.now, self.halt_deceleration)
            left = (motion.profile.duration - (self.now - motion.begun)) / self.speedup
            cancel.wait(min(_POLL, max(left, 0.0))) if reason is None else time.sleep(_POLL)
        if not told and reason is None:
            self.faults.reached("move", number)
        return reason

    def _standing(self, joints: Array, index: int) -> _Stand:
        """The arm comes to a stand: its servos leave an error, and the flange another one."""
        commanded = self.arm.forward(joints)
        wanted = self._errors.reported(commanded, index)
        turn = Rotation.from_matrix(wanted[:3, :3] @ commanded[:3, :3].T).as_rotvec()
        twist = np.concatenate([wanted[:3, 3] - commanded[:3, 3], turn])
        encoders = joints + np.linalg.lstsq(self.arm.jacobian(joints), twist, rcond=None)[0]
        reported = self.arm.forward(encoders)
        return _Stand(joints, encoders, reported, self._errors.true(reported, index), self.now, index)

    def _fault(self, name: str, value: float) -> None:
        if value and name in ("protective_stop", "emergency_stop"):
            self.halt(name.replace("_", " "))
