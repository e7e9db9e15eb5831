# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Time that counts while somebody looks."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import pytest

from cv_active_handeye.robots.waiting import LONGEST_S, WatchedTime, watched_waits


def test_looks_in_quick_succession_count_the_time_of_the_clock() -> None:
    watched = WatchedTime(100.0)
    assert [watched.look(100.0 + 0.01 * i) for i in range(1, 31)] == pytest.approx([0.01 * i for i in range(1, 31)])


def test_pause_counts_as_one_short_look_and_looking_goes_on_after_it() -> None:
    watched = WatchedTime(100.0)
    watched.look(100.02)
    assert watched.look(160.0) == pytest.approx(0.02 + LONGEST_S)
    assert watched.look(160.03) == pytest.approx(0.05 + LONGEST_S)
    watched.restart(170.0)
    assert watched.look(170.01) == pytest.approx(0.01)


def test_waits_add_up_to_the_time_that_was_asked_for() -> None:
    waits = []
    for wait in watched_waits(0.3):
        waits.append(wait)
        time.sleep(wait)
    assert len(waits) >= 0.3 / LONGEST_S
    assert max(waits) < LONGEST_S
    assert len(list(watched_waits(0.0))) == 1


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="only POSIX can pause a process")
@pytest.mark.timeout(60)
def test_paused_process_still_gets_an_answer_that_came_meanwhile() -> None:
    """A wait of 0.5 s, interrupted by a pause of 1.5 s in which the answer comes."""
    code = (
        "import queue, sys, threading\n"
        "from cv_active_handeye.robots.waiting import watched_waits\n"
        "answers = queue.Queue()\n"
        "threading.Thread(target=lambda: answers.put(sys.stdin.readline()), daemon=True).start()\n"
        "print('waiting', flush=True)\n"
        "for wait in watched_waits(0.5):\n"
        "    try: print('got', answers.get(timeout=wait), flush=True); break\n"
        "    except queue.Empty: pass\n"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1
    )
    assert process.stdin is not None
    assert process.stdout is not None
    assert process.stdout.readline() == "waiting\n"
    os.kill(process.pid, signal.SIGSTOP)
    time.sleep(1.5)
    process.stdin.write("answer\n")
    os.kill(process.pid, signal.SIGCONT)
    assert process.communicate(timeout=30)[0].startswith("got answer")
