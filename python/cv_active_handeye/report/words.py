# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Numbers and lists as one writes them in a sentence."""

from __future__ import annotations

import math
from typing import Any

NAMES = ("fx", "fy", "cx", "cy", "skew", "k1", "k2", "p1", "p2", "k3")


COMMAND_LINE_WORDS = {
    "REFINE_ALLOW_PARTIAL": "--allow-partial",
    "REFINE_FIX_K": "--camera",
    "REFINE_FIX_ASPECT": "--square-pixels",
    " (unit of t_gripper2base)": " m",
}


def command_line_words(text: str) -> str:
    """A text of the C++ library with options of the command line instead of its flags, and lengths in metres."""
    for word, replacement in COMMAND_LINE_WORDS.items():
        text = text.replace(word, replacement)
    return text


def sentence(text: str) -> str:
    """`text` in `command_line_words` with a full stop, and a capital letter unless it begins with a name like cx."""
    text = command_line_words(text)
    first = text.split(" ", 1)[0].rstrip(":,;.")
    start = text[:1].upper() if first.isalpha() and first not in NAMES else text[:1]
    return f"{start}{text[1:].rstrip('.')}."


def counted(number: int, noun: str) -> str:
    """`1 view`, `2 views`."""
    return f"{number} {noun}{'' if number == 1 else 's'}"


def listed(numbers: Any, most: int = 12) -> str:
    """`1, 2 and 5`; of a long list the beginning and how many more there are."""
    texts = [str(number) for number in numbers]
    if len(texts) > most:
        return f"{', '.join(texts[:most])} and {len(texts) - most} more"
    return " and ".join(filter(None, [", ".join(texts[:-1]), *texts[-1:]]))


def views_listed(numbers: Any) -> str:
    """`view 3`, `views 3 and 9`."""
    views = list(numbers)
    return f"{'view' if len(views) == 1 else 'views'} {listed(views)}"


def two_digits(x: float) -> str:
    """`x` with two significant digits, never in exponent form; an en dash for what is not a number."""
    if x == 0 or not math.isfinite(x):
        return "0" if x == 0 else "–"
    return f"{x:.{max(0, 1 - math.floor(math.log10(abs(float(f'{x:.1e}')))))}f}"


def fixed(x: float, digits: int) -> str:
    """`x` with `digits` after the point; an en dash for what is not a number."""
    return f"{x:.{digits}f}" if math.isfinite(x) else "–"
