# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Docstrings are plain text in Google's style for a terminal: signs of reStructuredText in them mean themselves."""

import re
from typing import Any

from sphinx.application import Sphinx
from sphinx.util.typing import ExtensionMetadata

ENTRY = re.compile(r"\w+(?:(?:, | and )\w+)*: ")
SHORTER = (
    (r"typing\.|numpy\.typing\.|numpy\.|cv_active_handeye\._core\.", ""),
    (r"SupportsFloat \| SupportsIndex", "float"),
    (r"SupportsInt \| SupportsIndex", "int"),
)


def process_docstring(app: Sphinx, what: str, name: str, value: Any, options: Any, lines: list[str]) -> None:
    """Escape what reStructuredText would read, link pages of the method, and make lists of `name: text` sections."""
    text = "\n".join(lines)
    text = re.sub(r"(?<!`)([|*\\]|(?<=\w)_(?!\w))", r"\\\1", text)
    text = re.sub(r"\bdoc/(method/\w+)\.md", r":doc:`doc/\1.md <../\1>`", text)
    lines[:] = _with_attributes(text).split("\n")


def _with_attributes(text: str) -> str:
    """The text with a head and an indentation for every paragraph that is a list of `name: text`."""
    paragraphs = text.rstrip().split("\n\n")
    for i, paragraph in enumerate(paragraphs):
        rows = paragraph.split("\n")
        if len(rows) > 1 and all(ENTRY.match(row) or row.startswith("    ") for row in rows) and ENTRY.match(rows[0]):
            paragraphs[i] = "\n".join(["Attributes:", *(f"    {row}" for row in rows)])
    return "\n\n".join([*paragraphs, ""])


def process_signature(
    app: Sphinx, what: str, name: str, value: Any, options: Any, signature: str | None, result: str | None
) -> tuple[str | None, str | None]:
    """Types by their last names."""
    return _shorter(signature), _shorter(result)


def _shorter(text: str | None) -> str | None:
    for pattern, name in SHORTER if text else ():
        text = re.sub(pattern, name, str(text))
    return text


def setup(app: Sphinx) -> ExtensionMetadata:
    """Connect before napoleon, which makes fields of the sections."""
    app.setup_extension("sphinx.ext.autodoc")
    app.connect("autodoc-process-docstring", process_docstring, priority=400)
    app.connect("autodoc-process-signature", process_signature)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
