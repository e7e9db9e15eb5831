# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Settings of a DENSO robot."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from .bcap import PORT
from .denso_link import Controller
from .kinematics import ARMS


class DensoConfig(BaseModel):
    """A DENSO arm behind b-CAP. Unknown keys are refused.

    controller: "rc8" (also RC8A) and "rc9" are supported; "rc7" only with `experimental_rc7`: its command set is known
        from documents alone, and it cannot be asked what its angles mean, so it needs a `model`.
    model: key of `kinematics.ARMS`, or None where the geometry is not known.
    external_percent: highest external speed, percent of the arm's own; what is set for a move is this or less.
    full_speed_m_s, full_acceleration_m_s2: of the flange at 100 %. The defaults are above those of all six-axis arms of
        the maker. A value too large makes moves slower than commanded; one too small makes them faster, which ends
        the first move with a stop.
    freshness_s: a pose that takes longer is no pose.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    type: Literal["denso"] = "denso"
    host: str = Field(min_length=1)
    port: int = Field(default=PORT, ge=1, le=65535)
    controller: Controller = "rc8"
    experimental_rc7: bool = False
    model: str | None = None
    external_percent: float = Field(default=5.0, ge=0.1, le=20.0)
    full_speed_m_s: float = Field(default=12.0, ge=0.5, le=50.0)
    full_acceleration_m_s2: float = Field(default=60.0, ge=1.0, le=500.0)
    freshness_s: float = Field(default=0.2, gt=0, le=1.0)

    @model_validator(mode="after")
    def _known(self) -> DensoConfig:
        if self.model is not None and self.model not in ARMS:
            raise ValueError(f"model: needs one of {sorted(ARMS)} or nothing, given {self.model!r}")
        if self.controller == "rc7" and not (self.experimental_rc7 and self.model):
            raise ValueError(
                "controller: 'rc7' is experimental: needs experimental_rc7 and a model, given "
                f"experimental_rc7 = {self.experimental_rc7}, model = {self.model!r}"
            )
        return self
