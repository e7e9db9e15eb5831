# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The emulated DENSO controller with any requests: an answer to each, never another exception."""

from __future__ import annotations

import socket
import struct

import numpy as np
from driver import require, run

from cv_active_handeye.robots.bcap_codes import Function, is_failure
from cv_active_handeye.robots.bcap_packets import Packet, PacketError, decode_packet, encode_packet
from cv_active_handeye.robots.denso_link import PROVIDERS
from cv_active_handeye.simulation.config import CellConfig
from cv_active_handeye.simulation.emulators import EmulatedArm, EventLog, Faults
from cv_active_handeye.simulation.emulators.denso import DENSO_FAULTS, PROFILES
from cv_active_handeye.simulation.emulators.denso.controller import DensoController
from cv_active_handeye.simulation.emulators.denso.session import Session

_FUNCTIONS = tuple(Function)
_START = np.radians([20.0, 35.0, 110.0, -10.0, 40.0, -50.0])
_log = EventLog()
_arm = EmulatedArm(CellConfig(), speedup=1000, log=_log, start=_START, faults=Faults(_log, DENSO_FAULTS))
_controller = DensoController(_arm, PROFILES["rc8"], "xyz", 0)
_connection = socket.socket()


def opened() -> Session:
    """Controller (handle 1), robot (2), variables (3, 4), arm taken, motor on; motions end at once."""
    session = Session(_controller, _connection)
    calls = [
        (Function.SERVICE_START, ("",)),
        (Function.CONTROLLER_CONNECT, ("", PROVIDERS["rc8"], "", "")),
        (Function.CONTROLLER_GET_ROBOT, (1, "Arm", "")),
        (Function.CONTROLLER_GET_VARIABLE, (1, "IO[1]", "")),
        (Function.ROBOT_GET_VARIABLE, (2, "@SERVO_ON", "")),
        (Function.ROBOT_EXECUTE, (2, "TakeArm", [0, 0])),
        (Function.ROBOT_EXECUTE, (2, "ExtSpeed", [5.0])),
        (Function.ROBOT_EXECUTE, (2, "Motor", [1, 0])),
    ]
    for function, arguments in calls:
        require(not is_failure(session.answer(Packet(1, function, arguments)).code), f"{function.name} failed")
    _controller.halt()
    return session


def target(data: bytes) -> None:
    """Each byte pair before 0xff asks for a function with a handle, the arguments follow as those of one packet."""
    asked, _, arguments = data.partition(b"\xff")
    frame = struct.pack("<BIHHIH", 1, 16 + len(arguments), 1, 0, 64, data[0] % 4 if data else 0) + arguments + b"\x04"
    try:
        given = decode_packet(frame).arguments
    except PacketError:
        return
    session = opened()
    try:
        for function, handle in zip(asked[:40:2], asked[1:40:2], strict=False):
            request = Packet(1, _FUNCTIONS[function % len(_FUNCTIONS)], (handle % 6, *given))
            answer = session.answer(request)
            require(decode_packet(encode_packet(answer)).serial == 1, "the answer cannot be sent")
    finally:
        _controller.give_arm(session)
        _controller.clear_errors()


if __name__ == "__main__":
    run("denso_requests", target, "cv_active_handeye.simulation.emulators.denso")
