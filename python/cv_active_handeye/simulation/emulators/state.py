# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""An emulated arm at one moment, as it goes over the control port."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from ...robots.base import Array


@dataclass(frozen=True)
class ArmState:
    """T_true, T_reported: flange (4, 4), m; joints: (6,), rad; see `EmulatedArm`. All of the same moment.

    switchings: how often an output has changed since the start.
    """

    T_true: Array
    T_reported: Array
    joints: Array
    moving: bool
    steady: bool
    stop_index: int
    outputs: dict[int, bool]
    switchings: int
    speedup: float
    stop_condition: str | None

    def to_json(self) -> dict[str, Any]:
        """Lists instead of arrays; every double keeps its value."""
        content = {field.name: getattr(self, field.name) for field in fields(self)}
        return {key: value.tolist() if isinstance(value, np.ndarray) else value for key, value in content.items()}

    @classmethod
    def from_json(cls, answer: dict[str, Any]) -> ArmState:
        """What `to_json` gave, after its way through JSON; KeyError where something is missing."""
        content = {field.name: answer[field.name] for field in fields(cls)}
        arrays = {key: np.array(content[key], dtype=np.float64) for key in ("T_true", "T_reported", "joints")}
        outputs = {int(pin): on for pin, on in content["outputs"].items()}
        return cls(**{**content, **arrays, "outputs": outputs})
