# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""`cv2.active_handeye` and `cv_active_handeye`: the same names, keywords, results and errors."""

from __future__ import annotations

import ast
import inspect
import re
from pathlib import Path
from types import ModuleType
from typing import Any

import cv2
import numpy as np
import pytest
from parity.calls import Call, Params, calls
from parity.refused import refused

import cv_active_handeye as cah
from cv_active_handeye import _core

cv_module: ModuleType = vars(cv2)["active_handeye"]
CALLS, REFUSED = calls(), refused()
FUNCTIONS = sorted(name for name in cah.__all__ if inspect.isroutine(getattr(cah, name)))
STRUCTURES = sorted(name for name in cah.__all__ if name.endswith(("Params", "Summary")))
CONSTANTS = sorted(name for name in cah.__all__ if name.isupper())


def run(module: ModuleType, call: Call) -> Any:
    """The results of a call through one of the bindings."""

    def value(given: Any) -> Any:
        if not isinstance(given, Params):
            return given
        params = getattr(module, given.name)()
        for field, content in given.fields.items():
            setattr(params, field, content)
        return params

    return getattr(module, call.function)(*call.inputs, **{key: value(v) for key, v in call.options.items()})


def assert_equal(ours: Any, theirs: Any, what: str) -> None:
    """Equal to 1e-12 of the largest value of an array; structures field by field."""
    if type(ours).__name__.endswith("Summary"):
        for field in fields(type(ours)):
            assert_equal(getattr(ours, field), getattr(theirs, field), f"{what}.{field}")
    elif isinstance(ours, tuple | list) and not isinstance(ours, str):
        assert len(ours) == len(theirs), what
        for k, pair in enumerate(zip(ours, theirs, strict=True)):
            assert_equal(*pair, f"{what}[{k}]")
    elif ours is None or isinstance(ours, str | bool):
        assert ours == theirs, what
    else:
        a, b = np.asarray(ours), np.asarray(theirs)
        assert (a.size == 0 and theirs is None) or a.shape == b.shape, f"{what}: {a.shape}, {b.shape}"
        if a.size:
            finite = np.abs(a[np.isfinite(a)]).max(initial=0)
            np.testing.assert_allclose(b, a, rtol=1e-12, atol=1e-12 * finite, err_msg=what)


def fields(structure: type) -> list[str]:
    """Names of the public attributes."""
    return [name for name in dir(structure) if not name.startswith("_")]


def test_both_have_the_same_names() -> None:
    ours = set(FUNCTIONS + STRUCTURES + CONSTANTS)
    theirs = {name for name in dir(cv_module) if not name.startswith("_")}
    aliases = {name for name in theirs if "_" in name and name.split("_")[0] in STRUCTURES}
    enumerations = {name for name in theirs if name.endswith(("Method", "Flags", "Model", "Orientation"))}
    assert theirs - aliases - enumerations == ours
    assert set(cah.__all__) - ours == {"__version__", "error"}


@pytest.mark.parametrize("name", CONSTANTS)
def test_constants_have_the_same_values(name: str) -> None:
    assert getattr(cah, name) == getattr(cv_module, name)


@pytest.mark.parametrize("name", STRUCTURES)
def test_structures_have_the_same_fields_and_defaults(name: str) -> None:
    theirs = getattr(cv_module, name)
    assert set(fields(getattr(cah, name))) == set(fields(theirs))
    if name.endswith("Params"):
        for field in fields(theirs):
            assert_equal(getattr(getattr(cah, name)(), field), getattr(theirs(), field), field)


def our_arguments() -> dict[str, list[str]]:
    """Arguments of the wheel's functions in order, from its stubs."""
    stub = Path(_core.__file__).with_name("_core.pyi")
    if not stub.exists():
        stub = Path(cah.__file__).with_name("_core.pyi")
    functions = [node for node in ast.parse(stub.read_text("utf-8")).body if isinstance(node, ast.FunctionDef)]
    return {f.name: [a.arg for a in f.args.args + f.args.kwonlyargs] for f in functions}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_keywords_and_results_have_the_same_names_and_order(name: str) -> None:
    signature = (getattr(cv_module, name).__doc__ or "").splitlines()[0]
    given, _, returned = signature.partition(" -> ")
    arguments = re.findall(r"\w+", given.partition("(")[2])
    results = re.findall(r"\w+", returned)
    described = (getattr(cah, name).__doc__ or "").partition("Returns:")[2].partition("Raises:")[0]
    assert re.findall(r"^ {4}(\w+):", described, re.MULTILINE) == results
    ours = our_arguments()[name]
    assert ours == [a for a in arguments if a not in results or a in ours]


def test_every_function_is_called() -> None:
    assert {call.function for call in CALLS.values()} == set(FUNCTIONS)


@pytest.mark.parametrize("name", CALLS)
def test_results_are_equal(name: str) -> None:
    assert_equal(run(cah, CALLS[name]), run(cv_module, CALLS[name]), name)


@pytest.mark.parametrize("name", REFUSED)
def test_errors_have_the_same_code_and_text(name: str) -> None:
    with pytest.raises(cah.error) as ours:
        run(cah, REFUSED[name])
    with pytest.raises(cv2.error) as theirs:
        run(cv_module, REFUSED[name])
    assert (ours.value.code, ours.value.err, ours.value.func) == (
        theirs.value.code,
        theirs.value.err,
        theirs.value.func,
    )
