# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""When a pose of a DENSO controller is too old to be believed."""

from __future__ import annotations

import time
from typing import cast

import numpy as np
import pytest

from cv_active_handeye.robots.base import RobotStoppedError
from cv_active_handeye.robots.bcap_packets import Value
from cv_active_handeye.robots.denso_link import DensoLink
from cv_active_handeye.robots.denso_watch import DensoWatch

FRESH_S = 0.1


class Link:
    """A controller whose clock counts its answers, each of which takes the next of `pauses` (s), then none."""

    def __init__(self, *pauses: float, frozen: bool = False) -> None:
        self._pauses, self._frozen, self.asked = list(pauses), frozen, 0

    def execute(self, command: str, deadline_s: float) -> Value:
        assert deadline_s == FRESH_S
        if command == "CurJnt":
            return [0.0] * 6
        self.asked += 1
        time.sleep(self._pauses.pop(0) if self._pauses else 0.0)
        return [1.0 if self._frozen else float(self.asked), 0.0, 0.0, 500.0, 0.0, 0.0, 0.0, -1.0]


def watch(link: Link) -> DensoWatch:
    return DensoWatch(cast(DensoLink, link), "rc8", FRESH_S)


def test_late_reading_is_asked_for_once_more_for_this_process_may_have_been_paused() -> None:
    link = Link(3 * FRESH_S)
    pose = watch(link).pose()
    assert (link.asked, pose.controller_time) == (2, 0.002)
    np.testing.assert_allclose(pose.T_gripper2base[:3, 3], [0, 0, 0.5], atol=1e-12)


def test_controller_that_is_late_twice_gives_no_pose() -> None:
    with pytest.raises(RobotStoppedError, match=r"stale pose: no pose came within 0\.1 s"):
        watch(Link(3 * FRESH_S, 3 * FRESH_S)).pose()


def test_pause_before_a_clock_that_stands_still_hides_it_for_one_reading_only() -> None:
    link = Link(0.0, 3 * FRESH_S, frozen=True)
    looking = watch(link)
    looking.pose()
    with pytest.raises(RobotStoppedError, match=r"stale pose: the controller's clock stands still at 0\.001 s"):
        looking.pose()
    assert link.asked == 3


class SwitchedLink(Link):
    """A controller that somebody switches to manual mode, which is an error, after so many of its answers."""

    def __init__(self, after: int) -> None:
        super().__init__()
        self._after = after

    def read(self, name: str, deadline_s: float) -> int:
        assert deadline_s == FRESH_S
        automatic = self.asked < self._after
        self.asked += 1
        return {"@MODE": 3 if automatic else 1, "@ERROR_CODE": 0 if automatic else 0x04400004}.get(name, 0)

    def describe(self, code: int) -> str:
        return f"error {code}"


@pytest.mark.parametrize("after", range(3))
def test_error_is_never_told_instead_of_the_mode_that_is_its_cause(after: int) -> None:
    with pytest.raises(RobotStoppedError, match=r"the controller is in manual mode \(1\), automatic is needed"):
        watch(SwitchedLink(after)).check(motor_on=False)


def test_switch_after_the_last_reading_is_not_seen() -> None:
    link = SwitchedLink(3)
    watch(link).check(motor_on=False)
    assert link.asked == 3


class FailingLink(Link):
    """A controller that ends every program with an error and switches the motor off, after so many of its answers."""

    def __init__(self, after: int, code: int) -> None:
        super().__init__()
        self._after, self._code = after, code

    def read(self, name: str, deadline_s: float) -> int:
        assert deadline_s == FRESH_S
        good = self.asked < self._after
        self.asked += 1
        return {"@MODE": 3, "@SERVO_ON": int(good), "@ERROR_CODE": 0 if good else self._code}.get(name, 0)

    def describe(self, code: int) -> str:
        return f"error {code:#x}"


@pytest.mark.parametrize("after", range(4))
def test_motor_that_an_error_switched_off_is_told_with_the_error(after: int) -> None:
    with pytest.raises(RobotStoppedError, match=r"controller error: 0x83201482 \(error 0x83201482\)"):
        watch(FailingLink(after, 0x83201482)).check(motor_on=True)


def test_motor_that_was_switched_off_without_an_error_is_called_that() -> None:
    with pytest.raises(RobotStoppedError, match=r"program stopped: the motor was switched off"):
        watch(FailingLink(0, 0)).check(motor_on=True)
