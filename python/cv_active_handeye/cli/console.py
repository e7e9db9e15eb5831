# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What the commands share: progress on the terminal, and errors as one clear text with an exit status."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from enum import IntEnum

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, SpinnerColumn, TaskProgressColumn, TextColumn, TimeElapsedColumn

import cv_active_handeye as cah

from ..cameras.base import CameraError
from ..cameras.laser_switch import LaserError
from ..files import FileFormatError
from ..report.words import command_line_words
from ..robots.base import RobotError
from ..workflow.capture import CaptureError
from ..workflow.reporter import NO_CONVERGENCE, InsufficientDataError
from ..workflow.reporter import Progress as ProgressCall

out = Console(highlight=False)
err = Console(stderr=True, highlight=False)


class Exit(IntEnum):
    """Exit statuses, told in the help of every command."""

    USABLE = 0
    INTERNAL = 1
    USAGE = 2
    INSUFFICIENT_DATA = 3
    BAD_FILE = 4
    BEYOND_LIMITS = 5
    STOPPED = 6
    INTERRUPTED = 130


class TerminalReporter:
    """Shows every step with a bar and its time."""

    def __init__(self, progress: Progress) -> None:
        """`progress` is running already, see `terminal_reporter`."""
        self._progress = progress
        self.current = ""

    def step(self, name: str) -> ProgressCall:
        """Begins a step."""
        self.current = name
        task = self._progress.add_task(escape(name), total=None)

        def progress(done: int, total: int) -> None:
            self._progress.update(task, completed=done, total=total)

        return progress

    def ask(self, text: str) -> None:
        """Shows a sentence and waits for Enter, with the bars out of the way."""
        self._progress.stop()
        typer.prompt(text, default="", show_default=False, err=True)
        self._progress.start()

    def note(self, text: str) -> None:
        """Prints a sentence above the bars."""
        self._progress.console.print(f"[yellow]note:[/] {escape(text)}")


@contextmanager
def terminal_reporter() -> Iterator[TerminalReporter]:
    """A reporter whose bars live as long as the block."""
    columns = (SpinnerColumn(), TextColumn("{task.description}"), BarColumn(24), TaskProgressColumn())
    with Progress(*columns, TimeElapsedColumn(), console=err) as progress:
        yield TerminalReporter(progress)


@contextmanager
def told_errors(debug: bool, reporter: TerminalReporter | None = None) -> Iterator[None]:
    """Turns what went wrong into one text and an exit status; with `debug` the exception goes on as it is."""
    try:
        yield
    except (typer.Exit, typer.BadParameter, typer.Abort):
        raise
    except KeyboardInterrupt as error:
        err.print("[bold red]interrupted[/] from the keyboard")
        raise typer.Exit(int(Exit.INTERRUPTED)) from error
    except Exception as error:
        if debug:
            raise
        where = f" (while: {reporter.current})" if reporter is not None and reporter.current else ""
        status = status_of(error)
        prefix = "internal error" if status == Exit.INTERNAL else "error"
        hint = "\n--debug before the command shows where it came from." if status == Exit.INTERNAL else ""
        if isinstance(error, ModuleNotFoundError):
            hint = escape("\nIt comes with pip install 'cv_active_handeye[workflow,sim]'.")
        text = command_line_words(str(error).strip()) or type(error).__name__
        err.print(f"[bold red]{prefix}{escape(where)}:[/] {escape(text)}{hint}")
        raise typer.Exit(int(status)) from error


def status_of(error: Exception) -> Exit:
    """The exit status that tells a script what kind of failure this is."""
    if isinstance(error, InsufficientDataError):
        return Exit.INSUFFICIENT_DATA
    if isinstance(error, cah.error):
        return Exit.INSUFFICIENT_DATA if getattr(error, "code", 0) == NO_CONVERGENCE else Exit.BAD_FILE
    if isinstance(error, FileFormatError):
        return Exit.BAD_FILE
    if isinstance(error, (RobotError, CameraError, LaserError, CaptureError)):
        return Exit.STOPPED
    if isinstance(error, ModuleNotFoundError):
        return Exit.USAGE
    if isinstance(error, (FileExistsError, NotADirectoryError, PermissionError)):
        return Exit.USAGE
    return Exit.INTERNAL
