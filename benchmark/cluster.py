# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Runs many seeded trials in parallel: on the cores of this machine, or on a cluster that runs dask.distributed.

A trial is a function of its number; what it does with random numbers it seeds with [seed, number]. So results do not
depend on how many workers there are, nor on which of them ran a trial.
"""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import logging
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, TypeVar

from .report import Report, finish, parser

T = TypeVar("T")
CHUNKS_PER_WORKER = 20


@dataclass(frozen=True)
class Workers:
    """Where trials run; `client` is dask's, None = in this process."""

    client: Any = None
    count: int = 1

    def run(self, trial: Callable[[int], T], trials: int, what: str) -> list[T]:
        """trial(0), ..., trial(trials - 1), in this order. `trial` has to be picklable when there is a cluster."""
        show = Progress(trials, what)
        results: dict[int, list[T]] = {}
        for first, found in self._chunks(trial, trials):
            results[first] = found
            show.add(len(found))
        return [result for first in sorted(results) for result in results[first]]

    def _chunks(self, trial: Callable[[int], T], trials: int) -> Iterator[tuple[int, list[T]]]:
        """First number and results of every chunk, in the order in which they are ready."""
        size = max(1, trials // (CHUNKS_PER_WORKER * self.count))
        chunks = [range(first, min(first + size, trials)) for first in range(0, trials, size)]
        if self.client is None:
            yield from (_run_chunk(trial, chunk) for chunk in chunks)
            return
        ready = importlib.import_module("distributed").as_completed
        tasks = [self.client.submit(_run_chunk, trial, chunk, pure=False) for chunk in chunks]
        for _, result in ready(tasks, with_results=True):
            yield result


def _run_chunk(trial: Callable[[int], T], numbers: Sequence[int]) -> tuple[int, list[T]]:
    return numbers[0], [trial(number) for number in numbers]


class Progress:
    """A counter on standard error with the time left; one line where that is a terminal, else one every half minute."""

    def __init__(self, total: int, what: str) -> None:
        self.total, self.what, self.done = total, what, 0
        self.start = self.shown = time.monotonic()

    def add(self, trials: int) -> None:
        """Counts `trials` more."""
        self.done += trials
        now, terminal = time.monotonic(), sys.stderr.isatty()
        finished = self.done >= self.total
        if now - self.shown < (0.2 if terminal else 30) and not (finished and terminal):
            return
        self.shown = now
        left = (now - self.start) * (self.total / self.done - 1)
        end = "\n" if finished or not terminal else ""
        text = f"{self.what}: {self.done}/{self.total}, {left:.0f} s left"
        print(f"\r{text:<79}" if terminal else text, end=end, file=sys.stderr, flush=True)


def add_options(line: argparse.ArgumentParser) -> None:
    """--workers and --scheduler."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    help_text = f"processes on this machine (default: all cores, here {cores}); 1 needs no dask"
    line.add_argument("--workers", type=int, default=cores, metavar="N", help=help_text)
    line.add_argument("--scheduler", metavar="ADDRESS", help="run on the dask cluster of this scheduler instead")


@contextmanager
def start(options: argparse.Namespace) -> Iterator[Workers]:
    """Workers as the command line asks for them; a cluster of this machine ends with the block."""
    if options.scheduler is None and options.workers > 1 and importlib.util.find_spec("distributed") is None:
        print("dask.distributed is not installed (extra `bench`): running in one process", file=sys.stderr)
        options.workers = 1
    if options.scheduler is None and options.workers <= 1:
        yield Workers()
        return
    distributed = importlib.import_module("distributed")
    if options.scheduler:
        with distributed.Client(options.scheduler) as client:
            client.run(_one_thread)
            yield Workers(client, max(1, sum(client.nthreads().values())))
        return
    with (
        tempfile.TemporaryDirectory(prefix="active_handeye_bench") as scratch,
        distributed.LocalCluster(
            n_workers=options.workers,
            threads_per_worker=1,
            processes=True,
            dashboard_address=None,
            local_directory=scratch,
            silence_logs=logging.ERROR,
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        client.run(_one_thread)
        yield Workers(client, options.workers)


def main(
    description: str | None,
    measure: Callable[[Workers, argparse.Namespace], Report],
    trials: int,
    what: str,
    arguments: Sequence[str] | None,
    has_names: bool = False,
) -> int:
    """Command line of a benchmark of so many `trials` on workers; with `has_names` it also has --only."""
    line = parser(description or "")
    line.add_argument("--trials", type=int, default=trials, help=f"{what} (default {trials})")
    line.add_argument("--seed", type=int, default=1, help="trial i uses the random numbers of (seed, i)")
    if has_names:
        line.add_argument("--only", metavar="TEXT", help="only those whose names contain this")
    add_options(line)
    options = line.parse_args(arguments)
    with start(options) as workers:
        report = measure(workers, options)
    return finish(report, options.output)


def _one_thread() -> None:
    """Keeps OpenCV from starting threads of its own on a worker."""
    importlib.import_module("cv2").setNumThreads(1)
