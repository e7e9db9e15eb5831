# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What can be made to go wrong in an emulator, and when."""

from __future__ import annotations

import re
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from .log import EventLog

FAULTS = {
    "protective_stop": (1.0, "the controller stops the arm as after a collision, until a person clears it"),
    "emergency_stop": (1.0, "somebody presses the emergency stop, until a person clears it"),
    "unreachable": (1.0, "the next VALUE targets have no joint solution"),
    "drop_link": (1.0, "every connection of the robot's services is closed; new ones are accepted"),
    "frozen_timestamp": (1.0, "the controller's clock and pose stand still in the stream while the arm goes on"),
    "silent_port": (1.0, "connections stay open, nothing is answered or sent any more"),
    "not_remote": (1.0, "the controller is in local control"),
    "slow_settling": (3.0, "the arm needs VALUE s to come to rest after a motion instead of 0.5 s"),
    "pose_bias": (0.5, "from now on the arm is VALUE mm away from where it says it is"),
    "pose_noise": (0.5, "the reported pose jitters with every reading, sigma VALUE mm per axis"),
    "nan_pose": (1.0, "the controller says NaN instead of the numbers of its pose"),
    "slow_motion": (0.1, "motions run at VALUE times the commanded speed"),
    "program_stopped": (1.0, "somebody stops the program that obeys the client"),
    "register_conflict": (1.0, "a fieldbus owns the registers that the client needs"),
}
"""Names with the default value and what they do. The value 0 ends a fault that lasts."""

LATCHING = {"drop_link": "link lost", "frozen_timestamp": "stale pose", "silent_port": "link lost"}
"""Faults of the services after which a client must not move: the reason that the log gives."""

_SPEC = re.compile(r"(?P<name>\w+)(=(?P<value>[0-9.]+))?(@(?P<unit>stop|move)?(?P<number>[0-9.]+))?")


@dataclass(frozen=True)
class FaultPlan:
    """A fault and when it comes.

    unit: "now" at once; "s": after `number` seconds; "stop": when the arm stands for the `number`th time; "move": when
    the `number`th motion (1 = first) is 40 % done.
    """

    name: str
    value: float
    unit: Literal["now", "s", "stop", "move"] = "now"
    number: float = 0.0

    @classmethod
    def parse(cls, text: str) -> FaultPlan:
        """Reads NAME[=VALUE][@SECONDS | @stopN | @moveN]; ValueError names what is wrong."""
        match = _SPEC.fullmatch(text)
        if match is None or match["name"] not in FAULTS:
            raise ValueError(
                f"fault: needs NAME[=VALUE][@SECONDS|@stopN|@moveN] with one of {', '.join(FAULTS)}; given {text!r}"
            )
        value = float(match["value"]) if match["value"] else FAULTS[match["name"]][0]
        if match["number"] is None:
            return cls(match["name"], value)
        unit: Literal["s", "stop", "move"] = "stop" if match["unit"] == "stop" else "move" if match["unit"] else "s"
        return cls(match["name"], value, unit, float(match["number"]))


class Faults:
    """The faults of one emulator; every change is logged and told to those who subscribed. Thread-safe."""

    def __init__(self, log: EventLog, known: frozenset[str] = frozenset(FAULTS)) -> None:
        """`known`: those of `FAULTS` that this device has."""
        self.known = known
        self._log = log
        self._lock = threading.Lock()
        self._values: dict[str, float] = {}
        self._waiting: list[FaultPlan] = []
        self._timers: list[threading.Timer] = []
        self._listeners: list[Callable[[str, float], None]] = []

    def subscribe(self, listener: Callable[[str, float], None]) -> None:
        """`listener` gets (name, value) of every fault that sets in or ends."""
        self._listeners.append(listener)

    def plan(self, plan: FaultPlan) -> None:
        """Sets a fault now or prepares it for its moment; ValueError where this device does not know it."""
        self._check(plan.name)
        if plan.unit == "now":
            self.set(plan.name, plan.value)
        elif plan.unit == "s":
            timer = threading.Timer(plan.number, self.set, (plan.name, plan.value))
            timer.daemon = True
            self._timers.append(timer)
            timer.start()
        else:
            with self._lock:
                self._waiting.append(plan)

    def reached(self, unit: Literal["stop", "move"], number: int) -> None:
        """The arm tells that it stands, or moves, for the `number`th time."""
        with self._lock:
            due = [plan for plan in self._waiting if (plan.unit, plan.number) == (unit, number)]
            self._waiting = [plan for plan in self._waiting if plan not in due]
        for plan in due:
            self.set(plan.name, plan.value)

    def set(self, name: str, value: float | None = None) -> None:
        """Lets a fault set in; None = its default value, 0 ends it. ValueError where this device does not know it."""
        self._check(name)
        number = FAULTS[name][0] if value is None else float(value)
        with self._lock:
            if number:
                self._values[name] = number
            else:
                self._values.pop(name, None)
        self._log.add("fault", name=name, value=number)
        if number and name in LATCHING:
            self._log.add("stop_condition", reason=LATCHING[name])
        for listener in self._listeners:
            listener(name, number)

    def value(self, name: str) -> float:
        """The value of a fault that is there now, else 0."""
        with self._lock:
            return self._values.get(name, 0.0)

    def take(self, name: str) -> bool:
        """Whether a fault that comes VALUE times is there; counts down."""
        with self._lock:
            left = self._values.pop(name, 0.0)
            if left > 1.0:
                self._values[name] = left - 1.0
            return left > 0.0

    def clear(self) -> None:
        """Ends everything; what is planned stays planned."""
        with self._lock:
            ended, self._values = list(self._values), {}
        for name in ended:
            for listener in self._listeners:
                listener(name, 0.0)

    def close(self) -> None:
        """Forgets what was planned."""
        for timer in self._timers:
            timer.cancel()
            timer.join()

    def _check(self, name: str) -> None:
        if name not in self.known:
            raise ValueError(f"fault: needs one of {', '.join(sorted(self.known))}; given {name!r}")
