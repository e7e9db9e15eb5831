# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Durable writing, YAML reading and the array types that both file formats use."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated, Any, TypeVar, get_args

import numpy as np
import yaml
from numpy.typing import NDArray
from pydantic import BaseModel, BeforeValidator, PlainSerializer, ValidationError

FloatArray = NDArray[np.float64]
Model = TypeVar("Model", bound=BaseModel)

ROTATION_TOLERANCE = 1e-6
"""Largest entry of \\|R^T R - I\\| accepted, the same as in the C++ functions."""

TEMPORARY_SUFFIX = ".tmp"


class FileFormatError(ValueError):
    """A file that cannot be used; the text names the file, the key, what was needed and what was given."""


def write_atomic(path: Path, content: bytes) -> None:
    """Writes `content` so that after a crash or power cut `path` holds the old or the new bytes, never a mixture."""
    temporary = path.with_name(f".{path.name}{TEMPORARY_SUFFIX}")
    try:
        with open(temporary, "wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        os.replace(temporary, path)
    except OSError:
        temporary.unlink(missing_ok=True)
        raise
    sync_directory(path.parent)


def sync_directory(folder: Path) -> None:
    """Makes created and renamed entries of `folder` durable (no-op on Windows, which cannot open directories)."""
    if os.name == "nt":
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


class _UniqueKeyLoader(yaml.SafeLoader):
    """PyYAML keeps the last of two equal keys without a word; a file format must not."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        seen: set[Any] = set()
        for key_node, _ in node.value:
            key = self.construct_object(key_node, deep=True)
            if key in seen:
                raise yaml.constructor.ConstructorError(
                    None, None, f"the key '{key}' appears twice", key_node.start_mark
                )
            seen.add(key)
        return super().construct_mapping(node, deep)


def read_yaml(path: Path, kind: str) -> dict[str, Any]:
    """Reads a YAML file whose top level is a map; `kind` ("data set", "calibration") is used in messages."""
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise FileFormatError(f"{path}: cannot be read as a {kind} file: {reason}") from error
    try:
        content = yaml.load(text, Loader=_UniqueKeyLoader)
    except yaml.YAMLError as error:
        raise FileFormatError(f"{path}: is not valid YAML: {error}") from error
    if not isinstance(content, dict):
        found = type(content).__name__
        raise FileFormatError(f"{path}: needs a map of keys at the top level of a {kind} file, found {found}")
    return content


def check_schema_version(path: Path, content: Mapping[str, Any], kind: str, *supported: int) -> None:
    """Refuses a file whose `schema_version` this software does not know, before anything else in it is looked at."""
    if "schema_version" not in content:
        raise FileFormatError(f"{path}: key 'schema_version' is missing; a {kind} file needs it")
    version = content["schema_version"]
    if version not in supported or isinstance(version, bool):
        readable = " and ".join(map(str, supported))
        raise FileFormatError(
            f"{path}: key 'schema_version': this software reads version {readable} of the {kind} file, "
            f"the file says {version!r}"
        )


def validate(model: type[Model], content: Mapping[str, Any], path: Path) -> Model:
    """Builds `model` from the content of `path`; every problem found is told in one `FileFormatError`."""
    try:
        return model.model_validate(content)
    except ValidationError as error:
        problems = "; ".join(_explain(item, content, model) for item in error.errors())
        raise FileFormatError(f"{path}: {problems}") from error


def _explain(item: Any, content: Mapping[str, Any], model: type[BaseModel]) -> str:
    key = _key_in_file(item["loc"], content)
    if item["type"] == "extra_forbidden":
        near = get_close_matches(str(item["loc"][-1]), sorted(_names(model)), 1)
        return f"key '{key}' is unknown" + (f" (did you mean '{near[0]}'?)" if near else "")
    if item["type"] == "missing":
        return f"key '{key}' is missing"
    text = str(item["msg"]).removeprefix("Value error, ")
    if item["type"] not in ("value_error", "union_tag_invalid"):  # those say themselves what was given
        text += f", given {item['input']!r:.80}"
    return f"key '{key}': {text}" if key else text


def _key_in_file(location: Sequence[str | int], content: Any) -> str:
    """The path to a key as it stands in the file, without the names of variants that pydantic puts between."""
    shown = []
    for number, part in enumerate(location):
        listed = isinstance(content, list) and isinstance(part, int) and part < len(content)
        if listed or (isinstance(content, Mapping) and part in content):
            content = content[part]
        elif number < len(location) - 1:
            continue
        shown.append(str(part))
    return ".".join(shown)


def _names(kind: Any) -> set[str]:
    """Every key that a model knows, at all depths."""
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        inner = [_names(field.annotation) for field in kind.model_fields.values()]
        return set(kind.model_fields).union(*inner)
    return set().union(*(_names(argument) for argument in get_args(kind)))


def finite_array(value: Any, shape: tuple[int | None, ...]) -> FloatArray:
    """`value` as a read-only float64 array of `shape` (None = any length), all finite; else ValueError."""
    try:
        array: FloatArray = np.array(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ValueError(f"needs numbers of shape {_shape_text(shape)}, given {value!r:.80}") from error
    if len(shape) != array.ndim or any(need not in (None, have) for need, have in zip(shape, array.shape, strict=True)):
        raise ValueError(f"needs shape {_shape_text(shape)}, given {_shape_text(array.shape)}")
    if not np.isfinite(array).all():
        raise ValueError(f"needs finite numbers, given {array.tolist()!r:.120}")
    array.flags.writeable = False
    return array


def _shape_text(shape: tuple[int | None, ...]) -> str:
    return "x".join("N" if n is None else str(n) for n in shape) or "scalar"


def rotation_matrix(value: Any) -> FloatArray:
    """`value` as a read-only 3x3 rotation; ValueError says by how much it is not one."""
    R = finite_array(value, (3, 3))
    deviation = float(np.abs(R.T @ R - np.eye(3)).max())
    if deviation > ROTATION_TOLERANCE:
        raise ValueError(
            f"is not a rotation: max|R^T R - I| = {deviation:.3g}, at most {ROTATION_TOLERANCE:g} is accepted"
        )
    if np.linalg.det(R) < 0:
        raise ValueError("is not a rotation: its determinant is -1 (left-handed, a mirrored axis?), +1 is needed")
    return R


def vector3(value: Any) -> FloatArray:
    """`value` (3, 3x1 or 1x3) as a read-only vector of 3."""
    array = np.asarray(value, dtype=object)
    return finite_array(array.reshape(-1) if array.size == 3 else value, (3,))


Rotation = Annotated[FloatArray, BeforeValidator(rotation_matrix), PlainSerializer(lambda array: array.tolist())]
Vector3 = Annotated[FloatArray, BeforeValidator(vector3), PlainSerializer(lambda array: array.tolist())]
