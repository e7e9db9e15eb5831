# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Calls the command line in this process, on a terminal wide enough for every table."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from typer.testing import CliRunner

from cv_active_handeye.cli import console
from cv_active_handeye.cli.commands import app

WIDTH = 200


class Outcome(NamedTuple):
    exit_code: int
    output: str
    exception: BaseException | None


def run(*arguments: str | Path) -> Outcome:
    """Exit status, what was printed (standard output and error), and an exception that got through."""
    console.out.width = console.err.width = WIDTH
    result = CliRunner(env={"COLUMNS": str(WIDTH)}).invoke(app, [str(argument) for argument in arguments])
    return Outcome(result.exit_code, result.output, result.exception)
