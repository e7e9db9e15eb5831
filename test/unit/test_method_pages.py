# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The pages of the method beside the code: one for every header, equations and figures by the same numbers."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from support import public_headers

ROOT = Path(__file__).parents[2]
METHOD = ROOT / "doc/method"
CODE = [
    *public_headers.HEADERS,
    *sorted((ROOT / "modules/active_handeye/src").glob("*.?pp")),
    *sorted((ROOT / "python/bindings").glob("*.cpp")),
]
NUMBERS = r"((?:\(\d+\)(?:, | and | to |-)?)+)"
CITATION = re.compile(rf"paper(?:'s)?,? (?:equations? )?{NUMBERS}")


def numbers(text: str) -> set[int]:
    """`(3), (14) to (16)` names 3, 14, 15 and 16."""
    found: set[int] = set()
    for first, last in re.findall(r"\((\d+)\)(?:(?: to |-)\((\d+)\))?", text):
        found.update(range(int(first), int(last or first) + 1))
    return found


def cited(path: Path) -> set[int]:
    """Equations of the paper that a source cites, also over the end of a line."""
    text = re.sub(r"\s*\n\s*(?://!?)?\s*", " ", path.read_text(encoding="utf-8"))
    return set().union(*map(numbers, CITATION.findall(text)))


def page_of(path: Path) -> Path | None:
    """The page of a header, or of its binding; None for what has no page of its own."""
    page = METHOD / f"{path.stem.removeprefix('bind_')}.md"
    return page if page.exists() else None


CITING = [path for path in CODE if cited(path)]


@pytest.mark.parametrize("header", public_headers.HEADERS, ids=lambda path: str(path.stem))
def test_header_has_a_page_that_names_its_functions(header: Path) -> None:
    pages = "".join(page.read_text(encoding="utf-8") for page in METHOD.glob("*.md"))
    own = (METHOD / f"{header.stem}.md").read_text(encoding="utf-8")
    names = [function.name for function in public_headers.functions() if function.header == header.stem]
    assert names
    assert any(f"`{name}`" in own for name in names)
    assert [name for name in names if f"`{name}`" not in pages] == []
    assert f"({header.stem}.md)" in (METHOD / "README.md").read_text(encoding="utf-8")


def test_equations_are_cited_where_they_are_used() -> None:
    names = {path.name for path in CITING}
    assert {"foe.hpp", "translations.cpp", "stripe_directions.hpp", "bind_rotation.cpp"} <= names


@pytest.mark.parametrize("path", CITING, ids=lambda path: str(path.name))
def test_equation_of_the_paper_has_the_number_of_the_page(path: Path) -> None:
    page = page_of(path)
    pages = [page] if page else sorted(METHOD.glob("*.md"))
    explained = set().union(*(numbers(page.read_text(encoding="utf-8")) for page in pages))
    assert cited(path) <= explained, f"{[page.name for page in pages]} do not explain {sorted(cited(path) - explained)}"


def test_equations_of_our_own_pages_exist() -> None:
    cited = [
        (path.name, page, number)
        for path in CODE
        for page, list_of in re.findall(rf"doc/method/(\w+)\.md,? {NUMBERS}", path.read_text(encoding="utf-8"))
        for number in numbers(list_of)
    ]
    assert cited
    missing = [c for c in cited if f"({c[2]})\n" not in (METHOD / f"{c[1]}.md").read_text(encoding="utf-8")]
    assert missing == []


def test_every_decision_is_in_the_list_with_its_title() -> None:
    listed = (ROOT / "doc/decisions/README.md").read_text(encoding="utf-8")
    for page in set((ROOT / "doc/decisions").glob("*.md")) - {ROOT / "doc/decisions/README.md"}:
        title = page.read_text(encoding="utf-8").splitlines()[0].removeprefix("# ")
        assert f"[{title}]({page.name})" in listed


@pytest.mark.parametrize("path", sorted({*METHOD.glob("*.md"), ROOT / "doc/why.md"}), ids=lambda path: str(path.stem))
def test_page_cites_tests_and_benchmarks_that_exist(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    named = re.findall(r"`((?:benchmark|test|python|modules|samples)/[\w/]+\.\w+)", text)
    named += [
        f"benchmark/{name}.py" for line in re.findall(r"`python -m benchmark ([\w ]+)`", text) for name in line.split()
    ]
    assert [name for name in named if not (ROOT / name).exists()] == []


def test_numbers_in_the_tables_of_why_are_those_of_the_benchmarks() -> None:
    tables = (ROOT / "doc/accuracy.md").read_text(encoding="utf-8")
    measured = {cell.strip() for line in tables.splitlines() if line.startswith("|") for cell in line.split("|")}
    text = (ROOT / "doc/why.md").read_text(encoding="utf-8")
    quoted = [cell.strip() for line in text.splitlines() if line.startswith("|") for cell in line.split("|")]
    quoted = [cell for cell in quoted if re.fullmatch(r"[\d.]+", cell)]
    assert len(quoted) >= 20
    assert [cell for cell in quoted if cell not in measured] == []
