# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Every way to hand over the same numbers gives the same answer, bit for bit, and leaves the input alone."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from support.exact_recording import exact_recording

import cv_active_handeye as cah

Array = NDArray[np.float64]


def foe_points() -> tuple[Array, Array]:
    """Pixels with few enough digits to be exact in float32, of a translation towards the scene."""
    rng = np.random.default_rng(3)
    first = rng.integers(100, 640, (20, 2)).astype(np.float64)
    return first, first + np.round((first - [300, 200]) * rng.uniform(0.05, 0.2, (20, 1)))


def read_only(array: Array) -> Array:
    copy = array.copy()
    copy.flags.writeable = False
    return copy


SAME_NUMBERS: dict[str, Callable[[Array], Any]] = {
    "list": lambda a: a.tolist(),
    "tuple": lambda a: tuple(map(tuple, a.tolist())),
    "list of arrays": lambda a: list(a),
    "float32": lambda a: a.astype(np.float32),
    "int32": lambda a: a.astype(np.int32),
    "int64": lambda a: a.astype(np.int64),
    "uint16": lambda a: a.astype(np.uint16),
    "longdouble": lambda a: a.astype(np.longdouble),
    "big endian": lambda a: a.astype(">f8"),
    "Fortran order": np.asfortranarray,
    "every second row": lambda a: np.repeat(a, 2, axis=0)[::2],
    "reversed view": lambda a: a[::-1].copy()[::-1],
    "transposed view": lambda a: a.T.copy().T,
    "column slice": lambda a: np.hstack([a, a])[:, 1:3][:, ::-1],
    "N x 1 x 2": lambda a: a[:, None, :],
    "read-only": read_only,
}


@pytest.mark.parametrize("kind", SAME_NUMBERS)
def test_estimateFOE_is_the_same_for_every_kind_of_array(kind: str) -> None:
    points1, points2 = foe_points()
    expected = cah.estimateFOE(points1, points2)
    convert = SAME_NUMBERS[kind]

    given = convert(points1), convert(points2)
    result = cah.estimateFOE(*given)

    assert result[0] == expected[0] == 20
    for array, reference in zip(result[1:], expected[1:], strict=True):
        np.testing.assert_array_equal(array, reference, strict=True)


@pytest.mark.parametrize("stack", [list, tuple, np.asarray, read_only], ids=lambda f: f.__name__)
def test_calibrateHandEyeRotation_takes_sequences_and_stacked_arrays(stack: Callable[[Array], Any]) -> None:
    r = exact_recording()
    expected = cah.calibrateHandEyeRotation(
        r.R_gripper2base, r.t_gripper2base, r.imagePoints, r.cameraMatrix, r.distCoeffs, r.R_cam2gripper
    )
    result = cah.calibrateHandEyeRotation(
        stack(r.R_gripper2base),
        stack(r.t_gripper2base[:, :, None]),
        stack(r.imagePoints[:, :, None, :]),
        r.cameraMatrix.tolist(),
        r.distCoeffs[:, None],
        r.R_cam2gripper.T.copy().T,
    )
    assert result[0] == expected[0]
    np.testing.assert_array_equal(result[1], expected[1], strict=True)
    np.testing.assert_array_equal(result[2], expected[2], strict=True)


@pytest.mark.parametrize("shape", [(3,), (3, 1), (1, 3)])
def test_translations_of_one_view_may_have_any_vector_shape(shape: tuple[int, ...]) -> None:
    r = exact_recording()
    arguments = (r.imagePoints, r.cameraMatrix, r.distCoeffs, r.R_cam2gripper)
    expected = cah.calibrateHandEyeRotation(r.R_gripper2base, r.t_gripper2base, *arguments)
    translations = [t.reshape(shape) for t in r.t_gripper2base]
    result = cah.calibrateHandEyeRotation(r.R_gripper2base, translations, *arguments)
    np.testing.assert_array_equal(result[1], expected[1], strict=True)


def test_inputs_are_not_changed() -> None:
    r = exact_recording()
    guess = r.cameraMatrix + np.diag([5.0, 5.0, 0.0])
    inputs = [r.R_gripper2base, r.t_gripper2base, r.imagePoints, guess, r.distCoeffs]
    before = [a.copy() for a in inputs]
    _, camera_matrix, _, _ = cah.calibrateHandEyeTranslations(*inputs)
    for array, copy in zip(inputs, before, strict=True):
        np.testing.assert_array_equal(array, copy, strict=True)
    assert not np.shares_memory(camera_matrix, guess)


def test_results_are_new_writable_arrays_with_the_shapes_of_cv2() -> None:
    points1, points2 = foe_points()
    _, foe, mask, covariance = cah.estimateFOE(points1, points2)
    assert [(a.shape, str(a.dtype)) for a in (foe, mask, covariance)] == [
        ((3, 1), "float64"),
        ((20, 1), "uint8"),
        ((3, 3), "float64"),
    ]
    assert all(a.flags.owndata and a.flags.writeable and a.flags.c_contiguous for a in (foe, mask, covariance))
    ids = cah.groupViews(exact_recording().R_gripper2base)
    assert (ids.shape, str(ids.dtype)) == ((14, 1), "int32")


def test_images_keep_their_type_and_may_be_non_contiguous_or_coloured() -> None:
    rows = np.arange(120)[:, None]
    grey = (20 + 180 * np.exp(-0.5 * ((rows - 60.3) / 1.5) ** 2) + np.zeros((1, 200))).astype(np.uint8)
    expected = cah.detectStripe(grey)
    assert len(expected[0]) == 200
    wide = np.zeros((120, 400), np.uint8)
    wide[:, ::2] = grey
    colour, wider = np.dstack([grey] * 3), grey.astype(np.uint16) * 257
    for image in (wide[:, ::2], np.asfortranarray(grey), colour, grey[:, :, None], wider):
        points, _ = cah.detectStripe(image)
        np.testing.assert_allclose(points, expected[0], atol=1e-9 if image.dtype == np.uint8 else 1e-3)


def test_no_stripe_gives_empty_arrays() -> None:
    points, sigmas = cah.detectStripe(np.full((60, 80), 10, np.uint8))
    assert points.size == 0
    assert sigmas.size == 0
