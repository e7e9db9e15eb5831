# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""How the help of a command looks: its doc string in paragraphs, lines to try, and the exit statuses."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import TypeVar

import typer

from .arguments import STATUS_HELP

Command = TypeVar("Command", bound=Callable[..., None])


def epilog(*examples: str) -> str:
    """Lines to try (without the program's name), and the exit statuses."""
    lines = [f"Example: cv-active-handeye {example}" for example in examples]
    return "\n\n".join([*lines, STATUS_HELP])


def command_of(app: typer.Typer) -> Callable[..., Callable[[Command], Command]]:
    """`app.command` that takes lines to try and joins the lines of a paragraph, which typer leaves as they stand."""

    def command(*examples: str) -> Callable[[Command], Command]:
        def register(function: Command) -> Command:
            paragraphs = (inspect.getdoc(function) or "").split("\n\n")
            text = "\n\n".join(" ".join(paragraph.split()) for paragraph in paragraphs)
            return app.command(help=text, epilog=epilog(*examples))(function)

        return register

    return command
