# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What the public headers declare, and the comments that stand before or behind it."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
HEADERS = sorted((ROOT / "modules/active_handeye/include/opencv2/active_handeye").glob("*.hpp"))


class Function(NamedTuple):
    header: str
    name: str
    result: str
    comment: str
    signature: str
    arguments: list[str]
    """Names of the arguments."""


class Member(NamedTuple):
    header: str
    owner: str
    """The enumeration or the structure."""
    name: str
    comment: str


def text(header: Path) -> str:
    """The header."""
    return header.read_text(encoding="utf-8")


def functions() -> list[Function]:
    """All functions of all headers."""
    pattern = re.compile(r"/\*\*((?:(?!\*/).)*)\*/\s*CV_EXPORTS_W (\w+) (\w+)\(((?:[^()]|\([^()]*\))*)\);", re.DOTALL)
    found = []
    for header in HEADERS:
        for comment, result, name, arguments in pattern.findall(text(header)):
            plain = re.sub(r" = (?:[^,()]|\([^()]*\))+", "", arguments)
            names = [re.findall(r"\w+", argument)[-1] for argument in plain.split(",")]
            found.append(Function(header.stem, name, result, comment, arguments, names))
    return found


def groups() -> list[Member]:
    """All enumerations and structures with their own comments."""
    pattern = re.compile(r"((?:^//!.*\n)*)^(?:enum|struct CV_EXPORTS_W_SIMPLE) (\w+)\n", re.MULTILINE)
    return [
        Member(header.stem, name, name, comment)
        for header in HEADERS
        for comment, name in pattern.findall(text(header))
    ]


def members() -> list[Member]:
    """Every enumerator and every property of every structure."""
    body = re.compile(r"^(?:enum|struct CV_EXPORTS_W_SIMPLE) (\w+)\n\{\n(.*?)^\};", re.DOTALL | re.MULTILINE)
    found = []
    for header in HEADERS:
        for owner, inside in body.findall(text(header)):
            found += [Member(header.stem, owner, name, comment) for name, comment in _declared(inside)]
    return found


def _declared(inside: str) -> list[tuple[str, str]]:
    """Names in the body of an enumeration or structure, each with the comment before or behind it."""
    inside = re.sub(r"\n +//!<", " //!<", inside)
    found, before = [], ""
    joined = re.sub(r"(CV_PROP_RW [^;/]*|\w+ =)\n\s+", r"\1 ", inside)
    for line in joined.splitlines():
        code, _, behind = line.partition("//!")
        declared = re.fullmatch(r"\s*(?:CV_PROP_RW .*?(\w+(?:, \w+)*);|(\w+) = -?\d+,?)\s*", code)
        if declared:
            names = (declared[1] or declared[2]).split(", ")
            found += [(name, before + behind if i == 0 else behind) for i, name in enumerate(names)]
        before = before + behind if not code.strip() and behind else ""
    return found
