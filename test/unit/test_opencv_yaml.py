# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What `emit` writes, cv::FileStorage and PyYAML read back, every double bit for bit and every text to the letter."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import yaml
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict

from cv_active_handeye.opencv_yaml import emit, unpack


class Inner(BaseModel):
    flag: bool
    text: str


class Content(BaseModel):
    model_config = ConfigDict(arbitrary_types_allowed=True)

    number: float = 0.0
    count: int = 0
    text: str = ""
    words: tuple[str, ...] = ()
    flags: tuple[bool, ...] = ()
    array: NDArray[np.float64] | None = None
    inner: Inner | None = None


def both(folder: Path, content: Content) -> tuple[Any, Any]:
    """The content as cv::FileStorage and as PyYAML see it."""
    path = folder / "c.yaml"
    path.write_text(emit(content), encoding="utf-8")
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    assert storage.isOpened()
    return storage, yaml.safe_load(path.read_text(encoding="utf-8"))


def test_random_doubles_read_back_bit_for_bit(tmp_path: Path) -> None:
    bits = np.random.default_rng(1).integers(0, 2**64, 4000, np.uint64).view(np.float64)
    numbers = bits[np.isfinite(bits)].reshape(-1, 1)
    storage, content = both(tmp_path, Content(array=numbers))
    assert np.array_equal(storage.getNode("array").mat(), numbers)
    assert content["array"]["data"] == numbers.ravel().tolist()
    assert np.array_equal(unpack(content["array"]), numbers)


@pytest.mark.parametrize(
    "number", [0.0, -0.0, 1e-5, -1e-5, 1e16, 1e22, 5e-324, 1.7976931348623157e308, 1 / 3, 123456789.0]
)
def test_single_number_reads_back_as_a_number(tmp_path: Path, number: float) -> None:
    storage, content = both(tmp_path, Content(number=number))
    assert storage.getNode("number").real() == number
    assert isinstance(content["number"], float)
    assert str(content["number"]) == str(number)


def test_infinities_and_nan_read_back(tmp_path: Path) -> None:
    numbers = np.array([[np.inf, -np.inf], [np.nan, 1.0]])
    storage, content = both(tmp_path, Content(number=-np.inf, array=numbers))
    assert np.array_equal(storage.getNode("array").mat(), numbers, equal_nan=True)
    assert np.array_equal(unpack(content["array"]), numbers, equal_nan=True)
    assert storage.getNode("number").real() == content["number"] == -np.inf


@pytest.mark.parametrize(
    "text",
    ["", "yes", "1e5", "~", '"quoted" \\ back', "a: b # c", "- [x, {y}]", "± 0.3 °, µm – ü", "%YAML", "'", "x" * 1500],
)
def test_text_reads_back_to_the_letter(tmp_path: Path, text: str) -> None:
    storage, content = both(tmp_path, Content(text=text, words=(text, "b"), inner=Inner(flag=True, text=text)))
    assert storage.getNode("text").string() == content["text"] == text
    assert storage.getNode("words").at(0).string() == content["words"][0] == text
    assert storage.getNode("inner").getNode("text").string() == content["inner"]["text"] == text


@pytest.mark.parametrize("count", [0, 1, 3, 60])
def test_sequences_of_any_length_read_back(tmp_path: Path, count: int) -> None:
    words = tuple(f"word {i}" for i in range(count))
    storage, content = both(tmp_path, Content(words=words, count=5))
    node = storage.getNode("words")
    assert tuple(node.at(i).string() for i in range(node.size())) == tuple(content["words"]) == words
    assert storage.getNode("count").real() == content["count"] == 5


def test_truth_values_are_numbers_for_both(tmp_path: Path) -> None:
    storage, content = both(tmp_path, Content(flags=(True, False), inner=Inner(flag=True, text="")))
    assert [storage.getNode("flags").at(i).real() for i in range(2)] == content["flags"] == [1, 0]
    assert storage.getNode("inner").getNode("flag").real() == content["inner"]["flag"] == 1


def test_vectors_become_columns_and_none_is_left_out(tmp_path: Path) -> None:
    storage, content = both(tmp_path, Content(array=np.arange(3.0)))
    assert storage.getNode("array").mat().tolist() == [[0], [1], [2]]
    assert "inner" not in content
    assert unpack(content["array"]).tolist() == [[0], [1], [2]]


def test_large_matrix_is_written_row_by_row(tmp_path: Path) -> None:
    matrix = np.random.default_rng(2).normal(size=(20, 20))
    storage, _ = both(tmp_path, Content(array=matrix))
    assert np.array_equal(storage.getNode("array").mat(), matrix)
    assert sum(line.count(",") == 20 for line in emit(Content(array=matrix)).splitlines()) == 19


def test_unpack_leaves_what_is_no_map_alone() -> None:
    for value in (3.0, "text", [1, 2], None):
        assert unpack(value) is value
