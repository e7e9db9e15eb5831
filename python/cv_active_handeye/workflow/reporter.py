# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""How a workflow tells what it is doing, and how it says that the data do not suffice."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

Progress = Callable[[int, int], None]
"""Called with (done, total)."""


NO_CONVERGENCE = -7
"""`cv::Error::StsNoConv`: the C++ functions use it for data that cannot answer."""


class InsufficientDataError(RuntimeError):
    """The data set is readable but does not hold what the question needs; the text says what is missing."""


class Reporter(Protocol):
    """Receives the named steps of a workflow; the command line shows them, a program may ignore them (`Silent`)."""

    def step(self, name: str) -> Progress:
        """Begins a step and returns the function that takes its progress."""
        ...

    def note(self, text: str) -> None:
        """One sentence the user should read."""
        ...


class Silent:
    """A reporter that says nothing."""

    def step(self, name: str) -> Progress:
        """Ignores the step."""
        return lambda done, total: None

    def note(self, text: str) -> None:
        """Ignores the note."""
