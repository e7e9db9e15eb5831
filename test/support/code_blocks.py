# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The fenced blocks of the pages, and the commands in them."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import NamedTuple

from markdown_it import MarkdownIt

ROOT = Path(__file__).parents[2]
PAGES = sorted(
    {
        *ROOT.glob("*.md"),
        *ROOT.glob("doc/**/*.md"),
        *ROOT.glob("samples/*/README.md"),
        *ROOT.glob("modules/active_handeye/*.md"),
        *ROOT.glob("modules/active_handeye/tutorials/**/*.md"),
        ROOT / "benchmark/README.md",
        ROOT / "fuzz/README.md",
    }
)


class Block(NamedTuple):
    page: str
    """Below the top of the repository."""
    line: int
    kind: str
    """First word of the info string."""
    name: str
    """The rest of it: what file the block is."""
    text: str


class Command(NamedTuple):
    words: list[str]
    status: int
    """The exit status that its comment tells; 0 without one."""


def blocks_of(path: Path) -> list[Block]:
    """All fenced and indented blocks of a page."""
    page = path.relative_to(ROOT).as_posix()
    found = []
    for token in MarkdownIt("commonmark").parse(path.read_text(encoding="utf-8")):
        if token.type in ("fence", "code_block") and token.map:
            kind, _, name = token.info.strip().partition(" ")
            found.append(Block(page, token.map[0] + 1, kind, name, token.content))
    return found


def blocks(*kinds: str) -> list[Block]:
    """The blocks of these kinds on all pages; of all kinds when none is named."""
    every = [block for path in PAGES for block in blocks_of(path)]
    return [block for block in every if block.kind in kinds] if kinds else every


def commands(block: Block) -> list[Command]:
    """The commands of a block of kind `sh`, line by line; those joined by && one by one."""
    found: list[Command] = []
    for line in block.text.replace("\\\n", " ").splitlines():
        words = shlex.split(line, comments=True)
        status = int(line.rpartition("# exit status ")[2] or 0) if "# exit status " in line else 0
        part: list[str] = []
        for word in [*words, "&&"]:
            if word != "&&":
                part.append(word)
            elif part:
                found.append(Command(part, status))
                part = []
    return found
