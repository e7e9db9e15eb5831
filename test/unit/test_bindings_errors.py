# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What is refused, and that the text names the argument, what was needed and what was given."""

from __future__ import annotations

import pickle
import re
from typing import Any

import numpy as np
import pytest
from support.exact_recording import exact_recording

import cv_active_handeye as cah

BAD_ARG, BAD_SIZE, OUT_OF_RANGE, NO_CONVERGENCE = -5, -201, -211, -7
GOOD = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]


def refusal(*args: Any, **kwargs: Any) -> cah.error:
    """The error with which estimateFOE refuses these arguments."""
    with pytest.raises(cah.error) as caught:
        cah.estimateFOE(*args, **kwargs)
    return caught.value


@pytest.mark.parametrize(
    ("points1", "text"),
    [
        (None, r"points1: needed an array of numbers, given None"),
        (3.5, r"points1: needed an array of 1 to 3 dimensions, given 0 dimensions"),
        (np.zeros((1, 1, 3, 2)), r"points1: needed an array of 1 to 3 dimensions, given 4 dimensions"),
        ("abc", r"points1: needed an array of real numbers, given elements of type <U3"),
        ([["a", "b"]], r"points1: needed an array of real numbers, given elements of type <U1"),
        (np.ones((3, 2)) * 1j, r"points1: needed an array of real numbers, given elements of type complex128"),
        (np.ones((3, 2), bool), r"points1: needed an array of real numbers, given elements of type bool"),
        (np.array(GOOD, object), r"points1: needed an array of real numbers, given elements of type object"),
        ([[0, None], [1, 2]], r"points1: needed an array of real numbers, given elements of type object"),
        ({"x": 1}, r"points1: needed an array of real numbers, given elements of type object"),
        ([[0, 0], [1]], r"points1: needed an array of numbers, given a list that has no one shape \(numpy: .*"),
    ],
    ids=["None", "scalar", "4-D", "text", "texts", "complex", "bool", "object", "holes", "dict", "ragged"],
)
def test_what_is_no_array_of_numbers_is_refused_by_name(points1: Any, text: str) -> None:
    error = refusal(points1, GOOD)
    assert re.match(text, str(error))
    assert error.code == BAD_ARG
    assert str(refusal(GOOD, points1)).startswith("points2: ")


def test_errors_of_the_module_arrive_with_code_and_text() -> None:
    error = refusal([[1, 2, 3], [4, 5, 6]], GOOD)
    assert error.code == BAD_SIZE
    assert str(error) == error.err
    assert re.match(r"points1: needed .* given 2 x 3", error.err)
    assert error.func
    assert error.line > 0
    assert refusal(GOOD, GOOD, threshold=-1.0).code == OUT_OF_RANGE
    assert refusal(GOOD, GOOD).code == NO_CONVERGENCE


def test_the_element_of_a_sequence_is_named() -> None:
    r = exact_recording()
    rotations = list(r.R_gripper2base)
    rotations[4] = [[1, 0, 0], [0, 1]]
    with pytest.raises(cah.error, match=r"^R_gripper2base\[4\]: needed an array of numbers"):
        cah.groupViews(rotations)


@pytest.mark.parametrize(
    ("rotations", "given"),
    [(None, "NoneType"), (5, "int"), ("poses", "str"), ({}, "dict"), (iter([]), "list_iterator")],
)
def test_what_is_no_sequence_is_refused(rotations: Any, given: str) -> None:
    with pytest.raises(cah.error, match=rf"^R_gripper2base: needed a sequence of arrays, given {given}$"):
        cah.groupViews(rotations)


def test_a_flat_array_is_no_sequence_of_arrays() -> None:
    with pytest.raises(cah.error, match=r"^R_gripper2base: needed a sequence of arrays, given an array of 1 dim"):
        cah.groupViews(np.arange(9.0))


@pytest.mark.parametrize(
    ("image", "text"),
    [
        (np.zeros((4, 4)), "type uint8 or uint16, given type float64"),
        (np.zeros((4, 4), np.int16), "type uint8 or uint16, given type int16"),
        (np.zeros(4, np.uint8), "shape (rows, columns) or (rows, columns, 3), given shape (4,)"),
        (np.zeros((4, 4, 4), np.uint8), "shape (rows, columns) or (rows, columns, 3), given shape (4, 4, 4)"),
    ],
)
def test_what_is_no_image_is_refused(image: Any, text: str) -> None:
    with pytest.raises(cah.error, match=f"^image: needed an image of {re.escape(text)}$"):
        cah.detectStripe(image)


def test_options_are_by_keyword_only() -> None:
    estimate_foe: Any = cah.estimateFOE
    with pytest.raises(TypeError, match="incompatible function arguments"):
        estimate_foe(GOOD, GOOD, cah.FOE_RANSAC)
    with pytest.raises(TypeError, match="incompatible function arguments"):
        estimate_foe(GOOD, GOOD, treshold=1.0)


def test_an_unknown_method_is_refused() -> None:
    error = refusal(GOOD, GOOD, method=99)
    assert error.code in (BAD_ARG, OUT_OF_RANGE)
    assert re.match(r"method: needed .* given 99", str(error))


def test_errors_survive_pickling() -> None:
    error = refusal(None, GOOD)
    copy = pickle.loads(pickle.dumps(error))
    assert type(copy) is cah.error
    assert (str(copy), copy.code, copy.err, copy.func, copy.line) == (
        str(error),
        error.code,
        error.err,
        error.func,
        error.line,
    )
