# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Functions and result codes of b-CAP, as far as they are used here."""

from __future__ import annotations

from enum import IntEnum


class Function(IntEnum):
    """What a request asks for; the numbers are those of DENSO's b-CAP specification."""

    SERVICE_START = 1
    SERVICE_STOP = 2
    CONTROLLER_CONNECT = 3
    CONTROLLER_DISCONNECT = 4
    CONTROLLER_GET_ROBOT = 7
    CONTROLLER_GET_VARIABLE = 9
    CONTROLLER_EXECUTE = 17
    ROBOT_GET_VARIABLE = 62
    ROBOT_EXECUTE = 64
    ROBOT_CHANGE = 66
    ROBOT_HALT = 70
    ROBOT_MOVE = 72
    ROBOT_RELEASE = 84
    VARIABLE_GET_VALUE = 101
    VARIABLE_PUT_VALUE = 102
    VARIABLE_RELEASE = 111


class Result(IntEnum):
    """Result codes (HRESULT, unsigned) with a name of their own."""

    S_OK = 0x00000000
    S_EXECUTING = 0x00000900
    E_NOTIMPL = 0x80004001
    E_ABORT = 0x80004004
    E_FAIL = 0x80004005
    E_UNEXPECTED = 0x8000FFFF
    E_ACCESSDENIED = 0x80070005
    E_HANDLE = 0x80070006
    E_OUTOFMEMORY = 0x8007000E
    E_INVALIDARG = 0x80070057
    E_TIMEOUT = 0x80000900
    E_NOT_CONNECTED = 0x80000902
    E_INVALIDPACKET = 0x80010000
    E_INVALIDPACKET_SOH = 0x80010001
    E_ROBOTISBUSY = 0x80010004
    E_BUSY_CONNECTION = 0x809100AA
    E_NOT_IN_SLAVE_MODE = 0x83500121
    E_SLAVE_MODE = 0x83501032
    E_BUFFER_FULL = 0x83201483


_MEANINGS = {
    Result.E_NOTIMPL: "the controller does not have this function",
    Result.E_ABORT: "the call was ended before it was done",
    Result.E_FAIL: "the controller failed for a reason it does not tell",
    Result.E_UNEXPECTED: "not possible in this state of the controller",
    Result.E_ACCESSDENIED: "refused: the executable token or the arm belongs to somebody else",
    Result.E_HANDLE: "the object of this call does not exist or was released",
    Result.E_OUTOFMEMORY: "the controller has no memory left for this",
    Result.E_INVALIDARG: "an argument has the wrong type or value",
    Result.E_TIMEOUT: "the controller did not finish in its own time",
    Result.E_NOT_CONNECTED: "the controller is not connected",
    Result.E_INVALIDPACKET: "the controller could not read the packet",
    Result.E_INVALIDPACKET_SOH: "the controller could not read the packet's beginning",
    Result.E_ROBOTISBUSY: "the robot is busy with another motion or client",
    Result.E_BUSY_CONNECTION: "a call is still being worked on for this connection",
    Result.E_NOT_IN_SLAVE_MODE: "only possible in slave mode",
    Result.E_SLAVE_MODE: "not possible in slave mode",
    Result.E_BUFFER_FULL: "the controller's command buffer is full",
}


def is_failure(code: int) -> bool:
    """Whether an HRESULT (unsigned) says that a call failed."""
    return bool(code & 0x80000000)


def result_name(code: int) -> str:
    """The name of a result code, or what kind of error codes it belongs to."""
    if code in Result.__members__.values():
        return Result(code).name
    return "motion error" if code >> 24 == 0x84 else "controller error"


def result_meaning(code: int) -> str:
    """What a result code means, empty where only the controller knows."""
    return _MEANINGS.get(Result(code), "") if code in Result.__members__.values() else ""
