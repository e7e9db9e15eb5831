# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Every public name of both languages says what it is, with shapes, units, errors and where it comes from."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from typing import Any

import pytest
from support import public_headers

import cv_active_handeye as cah

FUNCTIONS = public_headers.functions()
MEMBERS = public_headers.members()
ENUMERATORS = {member.name for member in MEMBERS if member.name.isupper()}
OWNERS = sorted({member.owner for member in MEMBERS} - {m.owner for m in MEMBERS if m.name in ENUMERATORS})
SHAPE = re.compile(
    r"\d ?x ?\d|\b[A-Z] x |\([A-Z0-9]+(?:(?:x|, )[A-Z0-9 ]*)+\)"  # 3 x 3, N x 2, (Nx2), (N, 2), (3,)
    r"|\b[A-Z] (?:arrays|rotations|(?:planned )?translations|integers|numbers|vectors|standard|straight|stripe)"
    r"|\bvector of 3|\b3 numbers|nx, ny, nz, d|k1, k2|one number|rows, columns|channels|as in OpenCV"
    r"|same (?:size|shape|scene points)|numbers of (?:the )?views"
)
UNIT = re.compile(r"px|pixel|degrees|\brad\b|unit of|any unit of length|in the unit|base frame|camera frame|0, 1")


def public(kind: Callable[[Any], bool]) -> dict[str, Any]:
    return {name: getattr(cah, name) for name in cah.__all__ if kind(getattr(cah, name))}


PYTHON_FUNCTIONS = public(lambda value: callable(value) and not inspect.isclass(value))
PYTHON_CLASSES = public(inspect.isclass)


def section(docstring: str, title: str) -> str:
    found = re.search(rf"^{title}:\n((?: +.*\n|\n)*)", docstring, re.MULTILINE)
    return found[1] if found else ""


def entries(text: str) -> dict[str, str]:
    """Entries of a section: names before the colon, the text behind it."""
    found: dict[str, str] = {}
    for names, body in re.findall(r"^ {4}(\w+(?:, \w+)*): ((?:.*\n?)(?: {8}.*\n?)*)", text, re.MULTILINE):
        found.update(dict.fromkeys(names.split(", "), body))
    return found


def parameters(docstring: str) -> list[str]:
    """Names of the parameters in the signature that the bindings write into the first line."""
    signature = docstring.splitlines()[0]
    return re.findall(r"[(,] ?(\w+): ", re.sub(r"\[[^\]]*\]", "", signature))


def result_types(docstring: str) -> list[str]:
    """Types of the results in the signature."""
    hint = docstring.splitlines()[0].rsplit(" -> ", 1)[1]
    several = re.fullmatch(r"tuple\[(.*)\]", hint)
    return re.split(r", (?![^\[]*\])", several[1]) if several else [hint]


def test_both_languages_have_the_same_names() -> None:
    assert {function.name for function in FUNCTIONS} == set(PYTHON_FUNCTIONS)
    assert {name for name in cah.__all__ if name.isupper()} == ENUMERATORS
    assert set(OWNERS) | {"error"} == set(PYTHON_CLASSES)


@pytest.mark.parametrize("name", sorted(PYTHON_FUNCTIONS))
def test_python_function_documents_all_parameters_results_and_errors(name: str) -> None:
    docstring = inspect.cleandoc(PYTHON_FUNCTIONS[name].__doc__) + "\n"
    arguments = entries(section(docstring, "Args"))
    assert list(arguments) == parameters(docstring)
    for argument in re.findall(r"(\w+): numpy\.typing\.ArrayLike", docstring.splitlines()[0]):
        assert SHAPE.search(arguments[argument]), f"{argument}: its shape is not said"
    results = entries(section(docstring, "Returns"))
    hints = result_types(docstring)
    assert len(results) == len(hints)
    for (result, body), hint in zip(results.items(), hints, strict=True):
        assert "NDArray" not in hint or SHAPE.search(body), f"{result}: its shape is not said"
    assert UNIT.search(docstring)
    assert "error: " in section(docstring, "Raises")
    source = re.search(r"^Source: (doc/method/\w+\.md)", docstring, re.MULTILINE)
    assert source
    assert f"`{name}`" in (public_headers.ROOT / source[1]).read_text(encoding="utf-8")


@pytest.mark.parametrize("name", sorted(set(PYTHON_CLASSES) - {"error"}))
def test_python_class_documents_all_its_attributes(name: str) -> None:
    kind = PYTHON_CLASSES[name]
    documented = entries(section(inspect.cleandoc(kind.__doc__ or "") + "\n", "Attributes"))
    members = {key for key, value in vars(kind).items() if isinstance(value, property)}
    assert set(documented) == members
    assert members == {member.name for member in MEMBERS if member.owner == name}


def test_python_error_documents_its_attributes() -> None:
    documented = entries(section(inspect.cleandoc(cah.error.__doc__ or "") + "\n", "Attributes"))
    assert set(documented) == {"code", "err", "func", "line"}


@pytest.mark.parametrize("name", sorted(ENUMERATORS))
def test_constant_is_explained_where_it_is_used(name: str) -> None:
    docstrings = [value.__doc__ or "" for value in (PYTHON_FUNCTIONS | PYTHON_CLASSES).values()]
    assert any(re.search(rf"\b{name}\b", docstring) for docstring in docstrings)


@pytest.mark.parametrize("function", FUNCTIONS, ids=[function.name for function in FUNCTIONS])
def test_cpp_function_documents_all_arguments_result_and_errors(function: public_headers.Function) -> None:
    comment = function.comment
    documented = re.findall(r"@param\[(?:in|out|in,out)\] (\w+) \S", comment)
    assert documented == function.arguments
    assert ("@return " in comment) == (function.result != "void")
    assert re.search(r"@throws cv::Exception .*Sts", comment, re.DOTALL)
    pages = [public_headers.ROOT / page for page in re.findall(r"doc/method/\w+\.md", comment)]
    assert any(f"`{function.name}`" in page.read_text(encoding="utf-8") for page in pages)
    arrays = re.findall(r"(?:Input|Output)Array(?:OfArrays)? (\w+)", function.signature)
    for name, body in re.findall(r"@param\[[a-z,]+\] (\w+) ((?:(?!@).)*)", comment, re.DOTALL):
        assert name not in arrays or SHAPE.search(body), f"{name}: its shape is not said"
    assert UNIT.search(comment)


@pytest.mark.parametrize("member", MEMBERS, ids=[f"{member.owner}.{member.name}" for member in MEMBERS])
def test_cpp_member_is_documented(member: public_headers.Member) -> None:
    assert len(member.comment.strip("< /!")) >= 2


@pytest.mark.parametrize("group", public_headers.groups(), ids=lambda group: str(group.name))
def test_cpp_enumeration_or_structure_is_documented(group: public_headers.Member) -> None:
    assert len(group.comment.strip("/! \n")) > 10
