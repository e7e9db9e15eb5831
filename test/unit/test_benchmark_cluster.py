# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Trials in parallel: same results in the same order, with and without dask."""

from __future__ import annotations

import argparse
import importlib.util
import os

import numpy as np
import pytest

from benchmark import cluster

TRIALS = 25


def draw(number: int) -> tuple[int, float, int]:
    return number, float(np.random.default_rng([3, number]).random()), os.getpid()


def options(*arguments: str) -> argparse.Namespace:
    line = argparse.ArgumentParser()
    cluster.add_options(line)
    return line.parse_args(arguments)


def test_one_worker_runs_in_this_process_in_order() -> None:
    with cluster.start(options("--workers", "1")) as workers:
        found = workers.run(draw, TRIALS, "test")
    assert [number for number, _, _ in found] == list(range(TRIALS))
    assert {process for _, _, process in found} == {os.getpid()}


def test_without_dask_one_process_does_it(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with cluster.start(options("--workers", "4")) as workers:
        assert workers.client is None
    assert "dask.distributed is not installed" in capsys.readouterr().err


@pytest.mark.filterwarnings("default")
def test_dask_gives_the_same_results_in_the_same_order() -> None:
    pytest.importorskip("distributed")
    with cluster.start(options("--workers", "2")) as workers:
        found = workers.run(draw, TRIALS, "test")
    assert [one[:2] for one in found] == [draw(number)[:2] for number in range(TRIALS)]
    assert os.getpid() not in {process for _, _, process in found}
