# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The state of an emulated UR controller, behind all of its ports."""

from __future__ import annotations

import math
import re
import threading
from dataclasses import dataclass

import numpy as np

from ....robots.base import Array
from ....robots.rtde_packets import Value
from ....robots.ur_pose import pose_vector
from ..arm import EmulatedArm, EmulatorStop
from .program import MOTIONS, NAMES, NONE, ControlProgram
from .registers import Registers
from .rtde_packets import OUTPUT_TYPES

VERSIONS = {
    "3.15": (3, 15, 8, 106339),
    "5.4": (5, 4, 3, 529),
    "5.11": (5, 11, 0, 108249),
    "5.23": (5, 23, 0, 1134),
    "10.11": (10, 11, 0, 205),
}
"""PolyScope versions that can be emulated: major, minor, bug fix, build. 10 is PolyScope X, without a dashboard."""

_STOPPED, _PLAYING, _PAUSED = 1, 2, 4
_NORMAL, _PROTECTIVE, _EMERGENCY = 1 << 0, 1 << 2, 1 << 6 | 1 << 7
_RUNNING, _POWER_OFF = 7, 3
_OFFSET = re.compile(r"reg_offset_int = # int register offset\s*(\d+)")


@dataclass(frozen=True)
class Snapshot:
    """What one package of the stream says: controller time (s), joints (6,), TCP pose vector (6,)."""

    time: float
    joints: tuple[float, ...]
    pose: tuple[float, ...]


class UrController:
    """One controller with its arm. T_tcp2flange: the active tool centre point (4, 4), m. Thread-safe."""

    def __init__(
        self,
        arm: EmulatedArm,
        version: str = "5.11",
        T_tcp2flange: Array | None = None,
        serial: str = "20235500000",
    ) -> None:
        """`version`: a key of VERSIONS. `T_tcp2flange`: what the installation says; None = 100 mm along z."""
        if version not in VERSIONS:
            raise ValueError(f"version: needs one of {', '.join(VERSIONS)}, given {version!r}")
        self.arm, self.version, self.serial = arm, VERSIONS[version], serial
        self.registers = Registers()
        self.T_tcp2flange = _tool_of(100.0) if T_tcp2flange is None else T_tcp2flange
        self._lock = threading.RLock()
        self._program: ControlProgram | None = None
        self._last = self._snapshot_now()
        arm.faults.subscribe(self._fault)

    @property
    def playing(self) -> bool:
        """Whether the control program runs."""
        return self._program is not None and self._program.running and self.arm.stop_condition is None

    @property
    def runtime_state(self) -> int:
        """As RTDE says it."""
        if self.arm.stop_condition == "protective stop":
            return _PAUSED
        return _PLAYING if self.playing else _STOPPED

    @property
    def safety_bits(self) -> int:
        """As RTDE says them."""
        return {None: _NORMAL, "protective stop": _PROTECTIVE}.get(self.arm.stop_condition, _EMERGENCY)

    @property
    def robot_mode(self) -> int:
        """As RTDE says it."""
        return _POWER_OFF if self.safety_bits == _EMERGENCY else _RUNNING

    @property
    def remote(self) -> bool:
        """Whether the controller is in remote control."""
        return not self.arm.faults.value("not_remote")

    def tcp_pose(self) -> Array:
        """The reported pose (4, 4) of the active tool centre point."""
        return np.asarray(self.arm.reported_pose() @ self.T_tcp2flange)

    def snapshot(self) -> Snapshot:
        """What the stream says now; the same again and again while the fault frozen_timestamp lasts."""
        if not self.arm.faults.value("frozen_timestamp"):
            self._last = self._snapshot_now()
        return self._last

    def value(self, name: str, snapshot: Snapshot) -> Value:
        """An output variable; what nobody asks an emulator for (currents, forces, speeds) is zero."""
        if "_register_" in name:
            return self.registers.output(name)
        known: dict[str, Value] = {
            "timestamp": snapshot.time,
            "actual_q": snapshot.joints,
            "target_q": snapshot.joints,
            "actual_TCP_pose": snapshot.pose,
            "target_TCP_pose": snapshot.pose,
            "tcp_offset": tuple(pose_vector(self.T_tcp2flange)),
            "runtime_state": self.runtime_state,
            "robot_mode": self.robot_mode,
            "safety_mode": 3 if self.safety_bits == _PROTECTIVE else 7 if self.safety_bits == _EMERGENCY else 1,
            "joint_mode": (253,) * 6,
            "robot_status_bits": 1 | (2 if self.playing else 0),
            "safety_status_bits": self.safety_bits,
            "speed_scaling": self.arm.faults.value("slow_motion") or 1.0,
            "target_speed_fraction": 1.0,
            "actual_digital_output_bits": sum(1 << pin for pin, on in self.arm.outputs.items() if on),
        }
        return known.get(name, _ZERO[OUTPUT_TYPES[name]])

    def write_inputs(self, values: dict[str, Value]) -> None:
        """A client's package: digital outputs are switched, registers go to the program."""
        mask, levels = values.get("standard_digital_output_mask", 0), values.get("standard_digital_output", 0)
        if isinstance(mask, int) and isinstance(levels, int):
            for pin in range(8):
                if mask >> pin & 1:
                    self.arm.set_output(pin, bool(levels >> pin & 1))
        self._judge(values)
        self.registers.write_inputs(values)

    def start_program(self, text: str) -> None:
        """A program on the program port; ur_rtde's control program and one that only stops are known.

        Any program ends the one that runs; none begins in local control.
        """
        first, *body = [line.strip() for line in text.strip().split("\n")]
        self.arm.log.add("command", name="program", args=[first[:60]])
        if not text.startswith("def rtde_control()"):
            self.stop_program()
            if not all(line == "end" or line.startswith(("stopl(", "stopj(")) for line in body):
                self.arm.log.add("violation", text=f"the program {first[:60]!r} is not known to this emulator")
            return
        if not self.remote or self.arm.stop_condition is not None:
            self.arm.log.add("violation", text="a program was sent to a controller that cannot run one")
            return
        self.stop_program()
        found = _OFFSET.search(text)
        with self._lock:
            self._program = ControlProgram(self, int(found[1]) if found else 0)

    def stop_program(self) -> None:
        """Ends the program and its motion."""
        with self._lock:
            program, self._program = self._program, None
        if program is not None:
            program.stop()

    def tell_stop(self, stop: EmulatorStop) -> None:
        """The program ended because a motion could not be done."""
        if stop.reason not in ("cancelled", self.arm.stop_condition):
            self.arm.log.add("stop_condition", reason="program stopped", text=str(stop))

    def _judge(self, values: dict[str, Value]) -> None:
        """Logs the command in a client's package, and what is wrong about it."""
        program = self._program
        offset = 0 if program is None else program.offset
        command = values.get(f"input_int_register_{offset}", NONE)
        if not isinstance(command, int) or command == NONE:
            return
        what = NAMES.get(command, str(command))
        numbers = [x for name, x in values.items() if name.startswith("input_double") and isinstance(x, float)]
        asynchronous = values.get(f"input_int_register_{offset + 1}") == 1
        self.arm.log.add("command", name=what, args=numbers, asynchronous=asynchronous)
        motion = command in MOTIONS
        if not self.playing:
            self.arm.log.add("violation", text=f"{what} without a running program", refused_motion=motion)
        elif program is not None and program.executing not in (NONE, command):
            self.arm.log.add("violation", text=f"{what} while {NAMES.get(program.executing)} is not acknowledged")

    def _snapshot_now(self) -> Snapshot:
        joints, pose = self.arm.joints, pose_vector(self.tcp_pose())
        if self.arm.faults.value("nan_pose"):
            pose = [math.nan] * 6
        return Snapshot(self.arm.now, tuple(float(x) for x in joints), tuple(pose))

    def _fault(self, name: str, value: float) -> None:
        if value and name == "program_stopped":
            with self._lock:
                if self._program is not None:
                    self._program.end()
            self.arm.log.add("stop_condition", reason="program stopped")
            threading.Thread(target=self.stop_program, daemon=True).start()  # a fault may come from the motion itself


_ZERO: dict[str, Value] = {
    "BOOL": False,
    "DOUBLE": 0.0,
    "VECTOR3D": (0.0,) * 3,
    "VECTOR6D": (0.0,) * 6,
    "VECTOR6INT32": (0,) * 6,
    **dict.fromkeys(("UINT8", "UINT32", "UINT64", "INT32"), 0),
}


def _tool_of(length_mm: float) -> Array:
    T = np.eye(4)
    T[2, 3] = length_mm / 1000
    return T
