# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""How the generations of DENSO controllers differ, as far as a client of b-CAP sees it."""

from __future__ import annotations

from dataclasses import dataclass

from ....robots.denso_link import PROVIDERS, Controller


@dataclass(frozen=True)
class Profile:
    """provider: name that Controller_Connect wants; missing: robot commands (lower case) that do not exist.

    frame_syntax: how Robot_Change names a tool or work frame, {} for the number.
    """

    name: Controller
    provider: str
    missing: frozenset[str] = frozenset()
    frame_syntax: tuple[str, str] = ("Tool{}", "Work{}")


_RC7_MISSING = frozenset(
    (
        "p2t",
        "t2p",
        "j2p",
        "p2j",
        "j2t",
        "t2j",
        "curtrn",
        "outrange",
        "highcurposex",
        "highcurjntex",
        "curtool",
        "curwork",
    )
)

PROFILES: dict[Controller, Profile] = {
    "rc8": Profile("rc8", PROVIDERS["rc8"]),
    "rc9": Profile("rc9", PROVIDERS["rc9"]),
    "rc7": Profile("rc7", PROVIDERS["rc7"], _RC7_MISSING, ("Tool={}", "Work={}")),
}
