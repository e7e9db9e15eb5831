# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The program itself, what stands before a command, and how lines are printed; modules of commands add to it."""

from __future__ import annotations

from typing import Annotated

import typer
from rich.markup import escape

import cv_active_handeye as cah

from .console import out
from .helping import command_of, epilog

app = typer.Typer(
    name="cv-active-handeye",
    no_args_is_help=True,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
command = command_of(app)


class Settings:
    """What was said before the command."""

    debug = False


def _print_version(wanted: bool) -> None:
    if wanted:
        out.print(cah.__version__)
        raise typer.Exit


@app.callback(epilog=epilog())
def main(
    debug: Annotated[bool, typer.Option("--debug", help="Show the trace-back of an error.")] = False,
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Version.")
    ] = False,
) -> None:
    """Calibrates a robot's camera and line laser without a target: from pure translations and turns of the robot.

    Start with [bold]cv-active-handeye demo[/]: it records a simulated cell and calibrates it.
    """
    Settings.debug = debug


def print_lines(*lines: str) -> None:
    """Prints every line as it stands."""
    for line in lines:
        out.print(escape(line))


def print_line(line: str) -> None:
    """Prints a line that a program may read: never broken, however narrow the terminal."""
    out.print(escape(line), soft_wrap=True)
