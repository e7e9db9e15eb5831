# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Runs a fuzz target with the seeds of the repository, a time limit for every input, and a limit on memory."""

from __future__ import annotations

import gc
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from types import FunctionType

import atheris

INPUT_S, MEMORY_MB, LONGEST = 20, 1024, 1 << 16
_ROOT = Path(__file__).parents[1]


def run(name: str, target: Callable[[bytes], None], *modules: str) -> None:
    """Fuzzes until libFuzzer's arguments (-max_total_time=60, an input file, ...) say stop.

    What reaches new code of `modules`, which are loaded, is kept in build/fuzz/NAME/corpus. That begins with what
    earlier runs found, fuzz/corpus/NAME.tar.xz; the seeds are read from fuzz/corpus/NAME.
    """
    _instrument(modules)
    work = _ROOT / "build/fuzz" / name
    if not (work / "corpus").is_dir():
        shutil.unpack_archive(_ROOT / "fuzz/corpus" / f"{name}.tar.xz", work / "corpus")
    limits = [f"-timeout={INPUT_S}", f"-rss_limit_mb={MEMORY_MB}", f"-max_len={LONGEST}", f"-artifact_prefix={work}/"]
    files = [argument for argument in sys.argv[1:] if not argument.startswith("-")]
    options = [argument for argument in sys.argv[1:] if argument.startswith("-")]
    places = files or [str(work / "corpus"), str(_ROOT / "fuzz/corpus" / name)]
    atheris.Setup([sys.argv[0], *limits, *options, *places], target)
    atheris.Fuzz()


def _instrument(modules: tuple[str, ...]) -> None:
    """Atheris' hook of imports sees nothing of a package that is installed to be edited, so this comes after them."""
    functions = [thing for thing in gc.get_objects() if isinstance(thing, FunctionType)]
    chosen = [function for function in functions if (function.__module__ or "").startswith(modules)]
    require(bool(chosen), f"modules: needs loaded modules with functions, given {', '.join(modules)}")
    for function in chosen:
        atheris.instrument_func(function)


def require(holds: bool, what: str) -> None:
    """Ends the run with a finding where a promise is broken."""
    if not holds:
        raise AssertionError(what)
