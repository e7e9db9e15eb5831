# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""How far a motion has come at what time: constant acceleration, constant speed, constant deceleration."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Profile:
    """A motion over `length` (m): at `speed` (m/s) from `first_speed` to rest, changing at `acceleration` (m/s^2)."""

    length: float
    speed: float
    acceleration: float
    first_speed: float = 0.0

    @classmethod
    def trapezoid(cls, length: float, speed: float, acceleration: float) -> Profile:
        """From rest to rest; a short motion does not reach `speed`."""
        top = min(speed, float(np.sqrt(length * acceleration)))
        return cls(length, top, acceleration)

    def braked(self, time: float, deceleration: float) -> Profile:
        """What is left from `time` (s) on when the motion is stopped there; not longer than the motion itself."""
        now = self.speed_at(time)
        rest = self.length - self.position(time)
        if now <= 0.0 or rest <= 0.0:
            return Profile(0.0, 0.0, deceleration)
        return Profile(min(rest, now**2 / (2 * deceleration)), now, max(deceleration, now**2 / (2 * rest)), now)

    @property
    def duration(self) -> float:
        """Seconds from the beginning to rest."""
        return self._rise + self._cruise + self._fall

    def position(self, time: float) -> float:
        """Metres done after `time` s."""
        if time >= self.duration:
            return self.length
        t = max(time, 0.0)
        if t < self._rise:
            return self.first_speed * t + self.acceleration * t**2 / 2
        if t < self._rise + self._cruise:
            return self._rise_length + self.speed * (t - self._rise)
        return self.length - self.acceleration * (self.duration - t) ** 2 / 2

    def speed_at(self, time: float) -> float:
        """m/s after `time` s."""
        if not 0.0 <= time < self.duration:
            return 0.0
        rising = self.first_speed + self.acceleration * time
        return float(min(rising, self.speed, self.acceleration * (self.duration - time)))

    @property
    def _rise(self) -> float:
        return (self.speed - self.first_speed) / self.acceleration

    @property
    def _rise_length(self) -> float:
        return (self.speed + self.first_speed) / 2 * self._rise

    @property
    def _fall(self) -> float:
        return self.speed / self.acceleration

    @property
    def _cruise(self) -> float:
        left = self.length - self._rise_length - self.speed * self._fall / 2
        return max(left, 0.0) / self.speed if self.speed > 0.0 else 0.0
