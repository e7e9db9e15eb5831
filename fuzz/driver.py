# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Runs a fuzz target with the seeds of the repository, a time limit for every input, and a limit on memory."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import atheris

INPUT_S, MEMORY_MB, LONGEST = 20, 1024, 1 << 16
_ROOT = Path(__file__).parents[1]


def run(name: str, target: Callable[[bytes], None]) -> None:
    """Fuzzes until libFuzzer's arguments (-max_total_time=60, an input file, ...) say stop.

    What reaches new code is kept in build/fuzz/NAME/corpus, the seeds are read from fuzz/corpus/NAME.
    """
    work = _ROOT / "build/fuzz" / name
    (work / "corpus").mkdir(parents=True, exist_ok=True)
    limits = [f"-timeout={INPUT_S}", f"-rss_limit_mb={MEMORY_MB}", f"-max_len={LONGEST}", f"-artifact_prefix={work}/"]
    files = [argument for argument in sys.argv[1:] if not argument.startswith("-")]
    options = [argument for argument in sys.argv[1:] if argument.startswith("-")]
    places = files or [str(work / "corpus"), str(_ROOT / "fuzz/corpus" / name)]
    atheris.Setup([sys.argv[0], *limits, *options, *places], target)
    atheris.Fuzz()


def require(holds: bool, what: str) -> None:
    """Ends the run with a finding where a promise is broken."""
    if not holds:
        raise AssertionError(what)
