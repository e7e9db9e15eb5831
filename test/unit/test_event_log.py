# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""An event that was logged is in the file; a cut line and a full disk do not hurt what stands before."""

from __future__ import annotations

import errno
from pathlib import Path

import pytest

from cv_active_handeye.workflow.event_log import EventLog, read_events


def test_events_are_in_the_file_at_once_in_their_order(tmp_path: Path) -> None:
    log = EventLog(tmp_path / "events.jsonl")
    for i in range(3):
        log("move", stop=i)
        assert [event["stop"] for event in read_events(tmp_path / "events.jsonl")] == list(range(i + 1))
    times = [event["monotonic"] for event in read_events(tmp_path / "events.jsonl")]
    assert times == sorted(times)
    log.close()


def test_line_that_a_power_cut_left_is_passed_over_and_the_next_begins_anew(tmp_path: Path) -> None:
    path = tmp_path / "events.jsonl"
    with EventLog(path) as log:
        log("one")
    with open(path, "ab") as stream:
        stream.write(b'{"utc": "2026-01-')
    with EventLog(path) as log:
        log("two")
    assert [event["event"] for event in read_events(path)] == ["one", "two"]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_full_disk_is_raised_by_check_and_not_by_the_event() -> None:
    log = EventLog(Path("/dev/full"))
    log.check()
    log("stop_condition")
    with pytest.raises(OSError, match="No space left") as full:
        log.check()
    assert full.value.errno == errno.ENOSPC
    log.close()
