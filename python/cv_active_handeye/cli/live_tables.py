# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A planned motion as a table and as a sentence."""

from __future__ import annotations

from rich.table import Table

from ..plan_file import Plan
from ..robots.base import Speed
from ..workflow.dry_run import PlannedMove
from .tables import plain_table


def moves_table(plan: Plan, moves: list[PlannedMove]) -> Table:
    """A row for every stop: its orientation group, where it is, and how far the way to it is."""
    found = plain_table("planned moves", "stop", "group", "x y z [mm]", "way [mm]", "turn [deg]", "laser")
    for move in moves:
        stop = plan.stops[move.stop]
        place = " ".join(f"{1000 * x:.1f}" for x in stop.t_gripper2base)
        laser = "yes" if stop.laser else "-"
        found.add_row(
            str(move.stop), str(stop.group), place, f"{1000 * move.length:.1f}", f"{move.angle:.2f}", laser
        )
    return found


def motion_text(moves: list[PlannedMove], speed: Speed) -> str:
    """How many moves there are, how far, how fast, and how long they take."""
    length = sum(move.length for move in moves)
    minutes, seconds = divmod(round(sum(move.seconds for move in moves)), 60)
    return (
        f"{len(moves)} moves, {length:.2f} m in all, at most {1000 * speed.metres_per_second:g} mm/s: about "
        f"{minutes} min {seconds} s of motion, beside the time to come to rest and to expose"
    )
