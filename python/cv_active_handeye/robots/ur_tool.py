# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The tool centre point of a UR controller: taken for the time of a session, written down, and given back.

While a session moves the arm the flange is the tool centre point (all zeros). Where a session cannot give the tool
back, for the link is lost or nobody clears a stop, the next one on the same controller finds zeros, and here what they
were. What somebody set since is kept: only zeros are replaced.
"""

from __future__ import annotations

import logging
import re
from datetime import datetime, timezone
from pathlib import Path

from pydantic import BaseModel, ConfigDict, ValidationError

from ..files import write_atomic
from . import ur_probe
from .base import RobotUnavailableError
from .ur_pose import pose_vector
from .ur_probe import UrFacts
from .ur_process import UrCallError, UrProcess, UrProcessLostError

CALL_S = 4.0
_OPEN_S, _FINISH_S = 6.0, 3.0
_log = logging.getLogger(__name__)


class ToolRecord(BaseModel):
    """A tool centre point that was taken and not given back yet. tool: pose vector, m and rad; taken: when."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    controller: str
    tool: tuple[float, float, float, float, float, float]
    taken: datetime

    @classmethod
    def load(cls, path: Path) -> ToolRecord | None:
        """Reads a file that `save` wrote; None where there is none, RobotUnavailableError where it is damaged."""
        try:
            return cls.model_validate_json(path.read_bytes())
        except FileNotFoundError:
            return None
        except (OSError, ValidationError) as error:
            text = f"{path}: cannot be read ({error}); set the tool centre point at the pendant, then delete this file"
            raise RobotUnavailableError(text) from error

    def save(self, path: Path) -> None:
        """Writes it durably; RobotUnavailableError where that cannot be, for then nothing may be taken."""
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            write_atomic(path, self.model_dump_json(indent=1).encode())
        except OSError as error:
            text = f"{path}: the tool centre point cannot be written down before it is changed: {error}"
            raise RobotUnavailableError(text) from error


def record_path(host: str, serial: str | None) -> Path:
    """Where the tool of a controller is written down: by its serial number, or by its address where it tells none."""
    from platformdirs import user_state_path

    name = f"ur-{serial}" if serial is not None else f"ur-at-{host}"
    return user_state_path("cv_active_handeye", appauthor=False) / (re.sub(r"[^\w.-]", "_", name) + ".json")


class UrTool:
    """A tool centre point that is away while `tool` waits to be given back. record: where it is written down."""

    def __init__(self, host: str, upper_registers: bool, tool: list[float], record: Path) -> None:
        """Use `take`."""
        self.tool, self.record = tool, record
        self._host, self._upper_registers = host, upper_registers

    @classmethod
    def take(cls, process: UrProcess, host: str, upper_registers: bool, facts: UrFacts) -> UrTool:
        """Makes the flange the tool centre point; what it was is on disk before.

        UrCallError or UrProcessLostError from the controller, RobotUnavailableError where it cannot be written down.
        """
        found = [float(x) for x in process.ask("tool", deadline=CALL_S)]
        record = record_path(host, ur_probe.serial_number(host, facts))
        left = None if any(found) else ToolRecord.load(record)
        tool = found if left is None else list(left.tool)
        if left is not None:
            _log.warning(
                "%s: the tool centre point is still the flange, as a session of %s left it; this one gives %s back. If "
                "zeros are what you want, set them at the pendant afterwards",
                *(host, left.taken.astimezone().strftime("%Y-%m-%d %H:%M"), _shown(tool)),
            )
        elif any(tool):
            now = datetime.now(timezone.utc)
            ToolRecord.model_validate({"controller": host, "tool": tool, "taken": now}).save(record)
        process.ask("take_tool", tool, str(record), deadline=CALL_S)
        return cls(host, upper_registers, tool, record)

    def give(self, process: UrProcess) -> str | None:
        """Gives the tool back; returns None, or what hindered it."""
        try:
            done = process.ask("give_tool", self.tool, str(self.record), deadline=CALL_S)
            return None if done else "the program on the controller has ended"
        except (UrCallError, UrProcessLostError) as error:
            return str(error)

    def give_anew(self) -> str | None:
        """Gives it back over connections of their own, where the first ones are lost and the controller allows."""
        try:
            ur_probe.usable(self._host, live=True, ours=True)
        except RobotUnavailableError as error:
            return str(error)
        process = UrProcess(self._host)
        try:
            process.ask("open_receive", deadline=CALL_S)
            process.ask("open_control", self._upper_registers, deadline=_OPEN_S)
            return self.give(process)
        except (UrCallError, UrProcessLostError) as error:
            return str(error)
        finally:
            process.finish(_FINISH_S)

    def __str__(self) -> str:
        return (
            f"The active tool centre point may still be the flange; it was {_shown(self.tool)}. The next session with "
            "moves gives it back; before other work set it at the pendant"
        )


def warn_of_left_tool(host: str, facts: UrFacts) -> None:
    """Says so where the tool centre point is still the flange because an earlier session could not give it back."""
    if facts.T_tcp2flange is None or any(pose_vector(facts.T_tcp2flange)):
        return
    try:
        left = ToolRecord.load(record_path(host, ur_probe.serial_number(host, facts)))
    except RobotUnavailableError as error:
        _log.warning("%s", error)
        return
    if left is not None:
        _log.warning(
            "%s: the tool centre point is still the flange; it was %s. The next session with moves gives it back",
            *(host, _shown(list(left.tool))),
        )


def _shown(tool: list[float]) -> str:
    return f"p{[round(x, 6) for x in tool]} (m, rad)"
