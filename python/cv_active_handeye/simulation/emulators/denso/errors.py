# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""How the emulated controller refuses: result codes, and the texts that GetErrorDescription gives for them."""

from __future__ import annotations

from ....robots.bcap_codes import Result

MOTOR_OFF = 0x83500022
ARM_NOT_TAKEN = 0x83500027
NOT_AUTOMATIC = 0x83500030
OUT_OF_RANGE = 0x84204050
STOPPED = {
    "emergency stop": 0x84400001,
    "protective stop": 0x84400002,
    "program stopped": 0x84400003,
    "manual mode": 0x84400004,
}
"""Error of the controller after a stop condition; these numbers are the emulator's own."""

DESCRIPTIONS = {
    MOTOR_OFF: "motor power is off",
    ARM_NOT_TAKEN: "the arm is not taken by this client",
    NOT_AUTOMATIC: "not in automatic mode",
    OUT_OF_RANGE: "the target is out of the motion range",
    STOPPED["emergency stop"]: "emergency stop",
    STOPPED["protective stop"]: "protective stop after a collision",
    STOPPED["program stopped"]: "all programs were stopped",
    STOPPED["manual mode"]: "switched to manual mode",
}


class Refusal(Exception):  # noqa: N818 (an answer of the controller, not an error of the emulator)
    """A call that the controller answers with a result code other than S_OK. client_erred: goes into the log."""

    def __init__(self, code: int, client_erred: str = "") -> None:
        """`code`: HRESULT, unsigned."""
        super().__init__(f"{code:#010x}")
        self.code, self.client_erred = code, client_erred


def signed(code: int) -> int:
    """An HRESULT as the 32-bit integer that variables hold."""
    return code - (1 << 32) if code >= 1 << 31 else code


def invalid(text: str) -> Refusal:
    """The refusal of an argument."""
    return Refusal(Result.E_INVALIDARG, text)
