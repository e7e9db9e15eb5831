# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The subset of YAML that `cv::FileStorage`, PyYAML and we read alike, each with exactly the written numbers.

Matrices are maps `rows`, `cols`, `dt: d`, `data`; truth values are 1 and 0: cv::FileStorage takes `true` for text.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from pydantic import BaseModel

HEADER = "%YAML 1.2\n---\n"
STEP = "   "


def emit(model: BaseModel) -> str:
    """The whole file: the fields of `model` in their order; a field that is None is left out."""
    return HEADER + _fields(model, "")


def unpack(value: Any) -> Any:
    """An OpenCV matrix map (rows, cols, dt, data) as an array (rows, cols); anything else unchanged."""
    if not isinstance(value, Mapping):
        return value
    unknown = set(value) - {"rows", "cols", "dt", "data"}
    missing = {"rows", "cols", "dt", "data"} - set(value)
    if unknown or missing or value["dt"] != "d":
        given = ", ".join(map(str, value))
        raise ValueError(f"needs a matrix map with rows, cols, dt: d and data, given the keys {given}")
    rows, cols, data = value["rows"], value["cols"], value["data"]
    if not (isinstance(rows, int) and isinstance(cols, int) and rows >= 0 and cols >= 0 and isinstance(data, list)):
        raise ValueError(f"needs counts rows and cols and a list data, given {rows!r}, {cols!r} and {data!r:.80}")
    if len(data) != rows * cols:
        raise ValueError(f"needs {rows} x {cols} = {rows * cols} numbers in data, given {len(data)}")
    wrong = [x for x in data if not isinstance(x, (int, float))]
    if wrong:
        raise ValueError(f"needs numbers in data, given {wrong[0]!r:.80}")
    return np.array(data, dtype=np.float64).reshape(rows, cols)


def _fields(model: BaseModel, indent: str) -> str:
    values = {name: getattr(model, name) for name in type(model).model_fields}
    return "".join(_entry(key, value, indent) for key, value in values.items() if value is not None)


def _entry(key: str, value: Any, indent: str) -> str:
    if isinstance(value, BaseModel):
        return f"{indent}{key}:\n{_fields(value, indent + STEP)}"
    if isinstance(value, np.ndarray):
        return f"{indent}{key}:\n{_matrix(value, indent + STEP)}"
    if isinstance(value, tuple):
        return f"{indent}{key}:{_sequence(value, indent + STEP)}\n"
    return f"{indent}{key}: {_scalar(value)}\n"


def _matrix(value: np.ndarray[Any, Any], indent: str) -> str:
    matrix = value.reshape(len(value), -1)
    lines = [", ".join(_number(float(x)) for x in line) for line in (matrix.T if matrix.shape[1] == 1 else matrix)]
    rows = f",\n{indent}        ".join(lines)
    lines = [f"rows: {matrix.shape[0]}", f"cols: {matrix.shape[1]}", "dt: d", f"data: [ {rows} ]"]
    return "".join(f"{indent}{line}\n" for line in lines)


def _sequence(items: tuple[Any, ...], indent: str) -> str:
    """On one line while it is short: cv::FileStorage reads lines of limited length."""
    scalars = [_scalar(item) for item in items]
    line = f" [ {', '.join(scalars)} ]"
    return line if len(line) < 200 else "".join(f"\n{indent}- {scalar}" for scalar in scalars)


def _scalar(value: Any) -> str:
    if isinstance(value, float):
        return _number(value)
    return str(int(value)) if isinstance(value, int) else json.dumps(value, ensure_ascii=False)


def _number(x: float) -> str:
    """Shortest text that reads back as the same double; YAML 1.1 takes 1e-05 for a string, 1.0e-05 for a number."""
    if not math.isfinite(x):
        return ".NaN" if math.isnan(x) else ".Inf" if x > 0 else "-.Inf"
    text = repr(float(x))
    mantissa, _, exponent = text.partition("e")
    return text if not exponent or "." in mantissa else f"{mantissa}.0e{exponent}"
