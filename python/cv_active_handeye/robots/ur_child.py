# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The process that talks to a UR controller through ur_rtde: python -m cv_active_handeye.robots.ur_child HOST

ur_rtde's calls can wait for minutes on a dead link, its constructors for ever and with the interpreter locked. Here
they may: the process is given up when one does not return. Requests come as JSON lines on standard input, answers go
to standard output. When the input ends, because the program that asked was closed or killed, the arm is stopped, the
tool centre point is restored, and the program on the controller is ended.

From the first move on this process also kicks the controller's watchdog (URScript's `rtde_set_watchdog`): when no
package of ours comes for its time, for the link is cut or this process is gone, the controller ends the program by
itself, which stops the arm. The kicks come from the loop that waits for requests, in this process that computes
nothing: images and calibrations of the program that asks, and its interpreter lock, cannot hold them up.
"""

from __future__ import annotations

import json
import os
import queue
import signal
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any, TextIO

_VARIABLES = [
    *("timestamp", "actual_q", "actual_TCP_pose", "speed_scaling", "actual_digital_output_bits"),
    *("robot_mode", "runtime_state", "safety_status_bits"),
]
_FREQUENCY = 125.0
_LEAVE_S, _BEGIN_S, _KICK_S = 8.0, 1.0, 4.0
_KICKS = 10  # within the watchdog's time
_PAUSE_S = 3.0  # beyond a request's deadline, which the caller keeps: a process that was paused shall not end for it
_PLAYING = 2
_STOP = 2.0  # m/s^2
_READS = 20


class Interfaces:
    """ur_rtde's three interfaces to one controller; every method is a request of the same name."""

    def __init__(self, host: str) -> None:
        self._host = host
        self._receive: Any = None
        self._control: Any = None
        self._io: Any = None
        self._taken: tuple[list[float], str] | None = None
        self._kick_due = 0.0
        self.kick_every: float | None = None
        """Seconds between kicks of the watchdog; None while none is needed."""

    def open_receive(self) -> None:
        """Opens the stream of states."""
        from rtde_receive import RTDEReceiveInterface

        self._receive = RTDEReceiveInterface(self._host, _FREQUENCY, _VARIABLES)

    def open_control(self, upper_registers: bool) -> None:
        """Starts ur_rtde's program on the controller."""
        from rtde_control import RTDEControlInterface as Control

        flags = Control.FLAG_UPLOAD_SCRIPT | (Control.FLAG_UPPER_RANGE_REGISTERS if upper_registers else 0)
        self._control = Control(self._host, _FREQUENCY, flags)
        deadline = time.monotonic() + _BEGIN_S
        while self._receive.getRuntimeState() != _PLAYING:  # the other stream may be a package behind
            if time.monotonic() > deadline:
                raise RuntimeError("the controller does not run the program that was sent to it")
            time.sleep(0.005)

    def state(self) -> dict[str, Any]:
        """All of one package: the time before and after must be the same."""
        r = self._receive
        for _ in range(_READS):
            stamp = r.getTimestamp()
            out = {
                "time": stamp,
                "pose": list(r.getActualTCPPose()),
                "joints": list(r.getActualQ()),
                "safety_bits": r.getSafetyStatusBits(),
                "runtime_state": r.getRuntimeState(),
                "robot_mode": r.getRobotMode(),
                "outputs": r.getActualDigitalOutputBits(),
                "speed_scaling": r.getSpeedScaling(),
            }
            if r.getTimestamp() == stamp:
                break
        else:
            raise RuntimeError(f"no package could be read whole in {_READS} attempts")
        out["connected"] = r.isConnected() and (self._control is None or self._control.isConnected())
        out["moving"] = self._control is not None and self._moving()
        return out

    def tool(self) -> list[float]:
        """The active tool centre point, a pose vector."""
        return list(self._control.getTCPOffset())

    def take_tool(self, tool: list[float], record: str) -> None:
        """Makes the flange the tool centre point; `tool` comes back in `leave`, and then the file `record` goes."""
        self._taken = (tool, record)
        if not self._control.setTcp([0.0] * 6) or any(self.tool()):
            raise RuntimeError("the controller did not set the tool centre point to zero")

    def give_tool(self, tool: list[float], record: str) -> bool:
        """Makes `tool` the active tool centre point again and deletes its record; whether the controller says so."""
        if not self._control.isConnected() or not self._control.isProgramRunning():
            return False
        done = bool(self._control.setTcp(tool)) and all(
            abs(a - b) < 1e-9 for a, b in zip(self.tool(), tool, strict=True)
        )
        if done:
            self._taken = None
            with suppress(FileNotFoundError):
                os.unlink(record)
        return done

    def move(self, pose: list[float], speed: float, acceleration: float, watchdog_s: float | None) -> bool:
        """Begins a straight move to a pose vector; m/s, m/s^2. Whether the controller took it.

        watchdog_s: how long the controller may hear nothing of this process before it stops the arm; None = for ever.
        It is set anew for every move, for ur_rtde may have sent its program anew meanwhile, and that has none.
        """
        if watchdog_s is not None:
            if not self._control.setWatchdog(1.0 / watchdog_s):
                return False
            self.kick_every = watchdog_s / _KICKS
            self._kick_due = 0.0
        return bool(self._control.moveL(pose, speed, acceleration, True))

    def kick(self) -> None:
        """Kicks the watchdog where that is due. Never where ur_rtde would connect anew for it, and begin a program."""
        now = time.monotonic()
        if self.kick_every is None or now < self._kick_due:
            return
        if self._control.isConnected() and self._control.isProgramRunning():
            self._control.kickWatchdog()
            self._kick_due = now + self.kick_every
        else:
            self.kick_every = None

    def stop(self) -> None:
        """Begins to stop the arm."""
        self._control.stopL(_STOP, True)

    def steady(self) -> bool:
        """Whether the controller says that the arm is at rest."""
        return bool(self._control.isSteady())

    def reachable(self, pose: list[float]) -> bool:
        """Whether a pose vector is within reach and safety limits."""
        return bool(self._control.isPoseWithinSafetyLimits(pose))

    def output(self, pin: int, on: bool) -> bool:
        """Switches a standard digital output; whether the request was sent."""
        if self._io is None:
            from rtde_io import RTDEIOInterface

            self._io = RTDEIOInterface(self._host)
        return bool(self._io.setStandardDigitalOut(pin, on))

    def leave(self) -> None:
        """Stops, restores the tool, ends the program on the controller, and disconnects."""
        if self._control is not None:
            if self._control.isProgramRunning():
                if self._moving():
                    self.stop()
                if self._taken is not None:
                    self.give_tool(*self._taken)
                self._control.stopScript()
            self._control.disconnect()
        for interface in (self._io, self._receive):
            if interface is not None:
                interface.disconnect()

    def _moving(self) -> bool:
        return bool(self._control.getAsyncOperationProgressEx().isAsyncOperationRunning())


REQUESTS = (
    *("open_receive", "open_control", "state", "tool", "take_tool", "give_tool", "move", "stop", "steady"),
    *("reachable", "output", "leave"),
)
"""What may be asked for."""


def main(host: str, requests: TextIO, answers: TextIO) -> None:
    """Obeys requests {"id", "call", "arguments", "deadline"} until the input ends."""
    interfaces = Interfaces(host)
    lines: queue.SimpleQueue[str | None] = queue.SimpleQueue()
    threading.Thread(target=_read, args=(requests, lines), name="requests", daemon=True).start()
    while True:
        with suppress(queue.Empty):
            line = lines.get(timeout=interfaces.kick_every)
            if line is None:
                break
            _answer(interfaces, json.loads(line), answers)
        _kick(interfaces)
    _set_deadline(_LEAVE_S)
    with suppress(Exception):
        interfaces.leave()


def _read(requests: TextIO, lines: queue.SimpleQueue[str | None]) -> None:
    """Hands on every request, and None when there will be no more."""
    with suppress(ValueError):  # the input was closed while it was read
        for line in requests:
            lines.put(line)
    lines.put(None)


def _answer(interfaces: Interfaces, request: dict[str, Any], answers: TextIO) -> None:
    _set_deadline(request["deadline"] + _PAUSE_S)
    answer = {"id": request["id"], **_answered(interfaces, request)}
    _set_deadline(0.0)
    with suppress(BrokenPipeError):
        print(json.dumps(answer), file=answers, flush=True)


def _kick(interfaces: Interfaces) -> None:
    if interfaces.kick_every is not None:
        _set_deadline(_KICK_S + _PAUSE_S)
        with suppress(Exception):  # a lost link is told by the next state; the controller's watchdog does the rest
            interfaces.kick()
        _set_deadline(0.0)


def _answered(interfaces: Interfaces, request: dict[str, Any]) -> dict[str, Any]:
    if request["call"] not in REQUESTS:
        return {"error": f"call: needs one of {', '.join(REQUESTS)}, given {request['call']!r}", "missing": None}
    call: Callable[..., Any] = getattr(interfaces, request["call"])
    try:
        return {"value": call(*request["arguments"])}
    except ModuleNotFoundError as error:
        return {"error": str(error), "missing": error.name}
    except Exception as error:  # whatever a native library throws is an answer, not the end of this process
        return {"error": str(error), "missing": None}


_timer: threading.Timer | None = None


def _set_deadline(seconds: float) -> None:
    """Ends this process after so many seconds, whatever it is doing then; 0 = no deadline."""
    global _timer
    if hasattr(signal, "setitimer"):
        signal.setitimer(signal.ITIMER_REAL, seconds)  # its default action needs no interpreter lock
        return
    if _timer is not None:
        _timer.cancel()
    _timer = threading.Timer(seconds, os._exit, (1,)) if seconds else None
    if _timer is not None:
        _timer.daemon = True
        _timer.start()


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    own = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # ur_rtde prints
    main(sys.argv[1], sys.stdin, own)
    own.flush()
    os._exit(0)
