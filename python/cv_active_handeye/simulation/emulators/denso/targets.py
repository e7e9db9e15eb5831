# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Pose data as clients send it: "@E P(1, 2, ...)" or [[1, 2, ...], "P", "@E"], of the types P, T and J."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.spatial.transform import Rotation

from ....robots.base import Array, RobotError
from ....robots.bcap_packets import Value
from ....robots.denso_pose import matrix_from_t, numbers
from .errors import invalid

Kind = Literal["P", "T", "J"]

_LEAST: dict[Kind, int] = {"P": 6, "T": 9, "J": 6}
_TEXT = re.compile(r"\s*(@(?P<pass>[PE]|\d+)\s+)?(?P<kind>[PTJ])\s*\((?P<values>[^()]{1,400})\)\s*", re.IGNORECASE)
_PASS = re.compile(r"@([PE]|\d+)", re.IGNORECASE)


@dataclass(frozen=True)
class Target:
    """Pose data: values in mm and deg, and whether the motion is to end exactly (@E)."""

    kind: Kind
    values: Array
    exact: bool

    @classmethod
    def parse(cls, data: Value) -> Target:
        """Reads both forms; Refusal E_INVALIDARG for anything else."""
        if isinstance(data, str):
            return cls._from_text(data)
        if not isinstance(data, (list, tuple)) or len(data) < 2 or not isinstance(data[1], str):
            raise invalid(f"pose data: needs text or [values, type], got {data!r:.80}")
        option = data[2] if len(data) > 2 else "@0"
        if not isinstance(option, str) or not _PASS.fullmatch(option):
            raise invalid(f"pose data: needs @P, @E or @number, got {option!r:.40}")
        return cls._checked(data[1], data[0], option.upper() == "@E")

    def matrix(self, convention: str = "xyz") -> Array:
        """The pose (4, 4), m, of a P- or T-type. convention: of P, as scipy's Rotation.from_euler names it."""
        if self.kind == "T":
            try:
                return matrix_from_t(self.values)
            except RobotError as error:
                raise invalid(str(error)) from error
        out = np.eye(4)
        out[:3, :3] = Rotation.from_euler(convention, self.values[3:6], degrees=True).as_matrix()
        out[:3, 3] = self.values[:3] / 1000
        return out

    @classmethod
    def _from_text(cls, text: str) -> Target:
        match = _TEXT.fullmatch(text)
        if match is None:
            raise invalid(f"pose data: cannot be read: {text!r:.80}")
        try:
            values: list[Value] = [float(value) for value in match["values"].split(",")]
        except ValueError as error:
            raise invalid(f"pose data: {error}") from error
        return cls._checked(match["kind"], values, (match["pass"] or "0").upper() == "E")

    @classmethod
    def _checked(cls, kind: str, values: Value, exact: bool) -> Target:
        for known in _LEAST:
            if kind.upper() == known:
                try:
                    return cls(known, numbers(values, _LEAST[known], f"{known}-type pose data"), exact)
                except RobotError as error:
                    raise invalid(str(error)) from error
        raise invalid(f"pose data: needs the type P, T or J, got {kind!r:.20}")
